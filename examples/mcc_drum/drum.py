"""Dynamic angle of a drum by frictions and speed, from a published table of simulated drums."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.interpolate import RegularGridInterpolator

TABLE = Path(__file__).parents[2] / "studies" / "benchmarks" / "data" / "granudrum" / "lookup.csv"
SPEEDS = (10, 15, 30, 45)
#: Speeds of the simulated drums, rpm.
SIMULATED = (10, 30, 50)
#: Mean diameter of the powder, mm, and the restitution of both published calibrations.
SIZE, RESTITUTION = 1.2, 0.3


def angles(parameters: dict[str, float]) -> dict[str, float]:
    """Return the dynamic angle, in degrees, at each of the photographed speeds."""
    table = np.genfromtxt(TABLE, delimiter=",", names=True)
    keys = ("size_mm", "restitution", "sliding", "rolling")
    axes = [np.unique(table[key]) for key in keys]
    order = np.lexsort([table[key] for key in reversed(keys)])
    columns = [table[f"angle_{speed}rpm_deg"][order] for speed in SIMULATED]
    values = np.stack(columns, axis=-1).reshape(*map(len, axes), len(SIMULATED))
    look_up = RegularGridInterpolator((*axes, np.array(SIMULATED, dtype=float)), values)
    frictions = (parameters["sliding_friction"], parameters["rolling_friction"])
    return {
        f"angle_{speed}rpm": float(look_up((SIZE, RESTITUTION, *frictions, speed))[()])
        for speed in SPEEDS
    }
