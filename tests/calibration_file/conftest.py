from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from grainfit.calibration_file.load import load_calibration_file
from grainfit.errors import InputError
from grainfit.options.places import FileFault

EXAMPLES = Path(__file__).parents[2] / "examples"

GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")

Change = tuple[str, str]


@pytest.fixture
def faults_of(tmp_path: Path) -> Callable[..., list[FileFault]]:
    """Faults of the glass-bead file after changes, each a text in it and what replaces it."""

    def load(*changes: Change, text: str = GLASS_BEADS) -> list[FileFault]:
        for old, new in changes:
            assert text.count(old) == 1, f"{old!r} must be in the file once"
            text = text.replace(old, new)
        path = tmp_path / "calibration.toml"
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError) as caught:
            load_calibration_file(path)
        assert caught.value.source == str(path)
        return list(caught.value.faults)

    return load
