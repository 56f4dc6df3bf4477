"""The material that ``grainfit new`` begins with, as a law of the benchmarks of whole beds."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.starter import starter_file

#: Laws of a bed: the material of the benchmark itself, and that of a new file.
OWN, NEW = "own", "new"
LAWS = (OWN, NEW)


@cache
def material_of_new() -> Mapping[str, float]:
    """Return its fixed values, and the middles of the intervals of those that are free."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "calibration.toml"
        path.write_text(starter_file(), encoding="utf-8")
        setup = load_calibration(path)
    return {**setup.file.fixed, **setup.problem.middle}
