"""Calibration file of two rendered pictures of a heap of beads."""

from __future__ import annotations

from pathlib import Path

import grainfit as gf
from grainfit.calibration_file.build import CalibrationSetup
from tests.beads_file import BEADS

HEAP = f'{BEADS}[[test]]\ntype = "heap"\nsolver = "lammps"\n'
ANGLE = 'targets.angle_of_repose = { photos = ["heap_*.jpg"], plate = "620 mm" }\n'
PROFILE = 'targets.profile = { photos = ["heap_*.jpg"], plate = "620 mm", tolerance = "5 %" }\n'


def load(folder: Path, targets: str) -> CalibrationSetup:
    """Write the file with these targets, and read it."""
    (folder / "beads.toml").write_text(HEAP + targets)
    return gf.load(folder / "beads.toml", folder / "work")
