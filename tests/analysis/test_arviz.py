"""The posterior in ArviZ: the chains as emcee made them."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from given_metamodels import Given, given

from grainfit import ground_messages
from grainfit.analysis.posterior import Posterior, sample_posterior
from grainfit.errors import InputError
from grainfit.problem import Target


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    model = Given(lambda x: 10.0 + x @ np.array([4.0, 2.0]), 0.1)
    return sample_posterior(given([Target("y", 12.0, uncertainty=0.5)], [model], 2))


def test_the_sample_is_taken_from_the_chains(posterior: Posterior) -> None:
    walkers, steps, dimension = posterior.chains.shape
    assert (walkers, dimension) == (256, 2)
    steps_of_walkers = {tuple(step) for step in posterior.chains.reshape(-1, 2).round(9)}
    assert {tuple(value) for value in posterior.values.round(9)} <= steps_of_walkers
    # A walker stays or moves: a chain is a walk, not a mixture of walkers.
    stays = (np.diff(posterior.chains, axis=1) == 0).all(axis=2).mean()
    assert steps >= 40
    assert 0.2 < stays < 0.9


@pytest.mark.filterwarnings("ignore::FutureWarning", "ignore::UserWarning")
def test_arviz_tells_the_same_of_it(posterior: Posterior) -> None:
    arviz = pytest.importorskip("arviz", reason="pip install 'grainfit[arviz]'")
    data = posterior.to_arviz()

    assert tuple(data.posterior.data_vars) == posterior.names
    assert dict(data.posterior.sizes) == dict(
        zip(("chain", "draw"), posterior.chains.shape[:2], strict=True)
    )
    summary = arviz.summary(data, round_to="none")
    for name in posterior.names:
        exact = float(posterior.chains[..., posterior.names.index(name)].mean())
        assert summary["mean"][name] == pytest.approx(exact)
        spread = float(posterior.chains[..., posterior.names.index(name)].std())
        assert abs(posterior.median(name) - exact) < spread
    assert data.posterior.attrs["inference_library"] == "emcee"


def test_without_arviz_the_error_says_how_to_install_it(
    posterior: Posterior, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "arviz", None)
    with pytest.raises(
        InputError,
        match=rf"{ground_messages.NOT_INSTALLED.matching(package='arviz')}.*grainfit\[arviz\]",
    ):
        posterior.to_arviz()
