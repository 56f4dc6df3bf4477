import pytest

from grainfit.testing.materials import GLASS_BEADS


@pytest.fixture
def glass_beads():
    """The 14 parameters of Rackl et al. (2016)."""
    return dict(GLASS_BEADS)
