"""Drums whose beads are placed and not simulated: the bed is steeper with more friction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import grainfit as gf
from grainfit.scenes.run_output import STAGES, STAGES_HEADER, RunOutput

FRICTION = "particle_particle.sliding_friction"
#: Frames, steps between them, and time step, s.
_FRAMES, _EVERY, _STEP = 26, 100, 1e-4


class Turned(gf.solvers.Solver):
    """Runs of a drum with a bed of beads."""

    name = "placed"

    def __init__(self) -> None:
        self.test = gf.tests.Drum(diameter="10 mm", drum_radius="100 mm")

    @property
    def response_names(self) -> tuple[str, ...] | None:
        return self.test.response_names

    @property
    def bulk_test(self) -> gf.tests.Drum:
        return self.test

    def model(self) -> Mapping[str, Any]:
        return {"solver": self.name, "test": self.test.definition()}

    def run(self, parameters: Mapping[str, float], seed: int, workspace: Any) -> dict[str, Any]:
        _write_bed(workspace.folder, 24 + 20 * parameters[FRICTION], self.test.setup)
        angles = self.test.view(RunOutput(workspace.folder)).angles
        return {**angles.responses(), "surface": angles.surface.curve()}


def _write_bed(folder: Path, angle: float, setup: Any) -> None:
    """Write frames of beads below a plane that swings about an angle, degrees."""
    radius, size = setup.drum_radius - setup.d / 2, setup.d
    axis = np.arange(-radius, radius, 0.9 * size)
    x, y, z = np.meshgrid(np.arange(0.5, setup.drum_length / size) * size, axis, axis)
    beads = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    beads = beads[np.hypot(beads[:, 1], beads[:, 2]) < radius]
    count = round(0.4 * len(beads))
    text = []
    for frame in range(_FRAMES):
        now = math.radians(angle + 2.0 * math.sin(2 * math.pi * frame / 5.2))
        above = beads[:, 2] * math.cos(now) - beads[:, 1] * math.sin(now)
        bed = beads[np.argsort(above)[:count]]
        rows = "".join(
            f"{i} {a:.5f} {b:.5f} {c:.5f} {size / 2} 0.001\n" for i, (a, b, c) in enumerate(bed, 1)
        )
        text.append(
            f"ITEM: TIMESTEP\n{_EVERY * frame}\nITEM: NUMBER OF ATOMS\n{count}\n"
            "ITEM: BOX BOUNDS pp ff ff\n0 1\n0 1\n0 1\n"
            f"ITEM: ATOMS id x y z radius mass\n{rows}"
        )
    (folder / "snapshots").mkdir()
    (folder / "snapshots/turning.dump").write_text("".join(text))
    last = _EVERY * (_FRAMES - 1)
    (folder / STAGES).write_text(f"{STAGES_HEADER}\nturn,done,{last},{_STEP * last},{count},0\n")
