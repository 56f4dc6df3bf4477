"""Two published calibrations of one powder that disagree: why, and which test would have told.

Both calibrated microcrystalline cellulose on pictures of the same instrument, a drum of 84 mm by
20 mm, by the same program with the same contact law. No simulation is made here: a published
look-up of drums, from which angles are interpolated, says what either answer predicts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from studies.benchmarks.drum_pictures import LOOKUP_SPEEDS
from studies.benchmarks.published import DATA

#: Sliding and rolling friction of either answer.
ANSWERS: Mapping[str, tuple[float, float]] = {
    "first": (0.3197, 0.00248),
    "second": (0.5613, 0.2931),
}
#: Speeds that either calibration was fitted to, rpm.
FITTED: Mapping[str, tuple[int, ...]] = {"first": (45,), "second": (15, 45)}
#: Mean diameter of the powder, mm, and its restitution in both calibrations.
SIZE, RESTITUTION = 1.2, 0.3
#: Angles within this agree, degrees: as near as the look-up comes to what it was not fitted to.
AGREES = 1.5
_FINE = 241


def _table(name: str) -> NDArray[np.void]:
    path = DATA / "granudrum" / f"{name}.csv"
    found: NDArray[np.void] = np.genfromtxt(path, delimiter=",", names=True, dtype=None)
    return found


@cache
def photographed() -> dict[tuple[str, int], tuple[float, float]]:
    """Return angle, degrees, and fill level on the photographs, by calibration and speed."""
    return {
        (str(row["calibration"]), int(row["speed_rpm"])): (
            float(row["angle_deg"]),
            float(row["fill"]),
        )
        for row in _table("photographs")
    }


class LookUp:
    """Dynamic angles of simulated drums between the points of the published look-up."""

    @cached_property
    def _angles(self) -> RegularGridInterpolator:
        table = _table("lookup")
        keys = ("size_mm", "restitution", "sliding", "rolling")
        axes = [np.unique(table[key]) for key in keys]
        shape = tuple(map(len, axes))
        values = np.empty((*shape, len(LOOKUP_SPEEDS)))
        places = tuple(np.searchsorted(a, table[k]) for a, k in zip(axes, keys, strict=True))
        for number, speed in enumerate(LOOKUP_SPEEDS):
            values[..., number][places] = table[f"angle_{speed}rpm_deg"]
        return RegularGridInterpolator((*axes, np.array(LOOKUP_SPEEDS, dtype=float)), values)

    def angle(
        self, sliding: NDArray[np.float64] | float, rolling: NDArray[np.float64] | float, speed: int
    ) -> NDArray[np.float64]:
        """Return the angles, degrees, of frictions at a speed in rpm."""
        sliding, rolling = np.broadcast_arrays(sliding, rolling)
        fixed = (np.full(sliding.shape, value) for value in (SIZE, RESTITUTION))
        points = np.stack([*fixed, sliding, rolling, np.full(sliding.shape, float(speed))], axis=-1)
        found: NDArray[np.float64] = self._angles(points).reshape(sliding.shape)
        return found

    @cached_property
    def frictions(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sliding and rolling friction of a fine grid over the look-up."""
        sliding, rolling = np.linspace(0.15, 1.0, _FINE), np.linspace(0.0, 0.7, _FINE)
        first, second = np.meshgrid(sliding, rolling, indexing="ij")
        return first, second

    def agreeing(self, wanted: Sequence[tuple[str, int]]) -> NDArray[np.bool_]:
        """Return where on the grid the angles are those of all these photographs."""
        agree = np.ones((_FINE, _FINE), dtype=bool)
        for calibration, speed in wanted:
            found = self.angle(*self.frictions, speed)
            agree &= np.abs(found - photographed()[calibration, speed][0]) < AGREES
        return agree


def predictions() -> list[tuple[str, int, float, dict[str, float]]]:
    """Return every photograph with its angle, and what either answer predicts, degrees."""
    look_up = LookUp()
    return [
        (
            calibration,
            speed,
            angle,
            {name: float(look_up.angle(*answer, speed)) for name, answer in ANSWERS.items()},
        )
        for (calibration, speed), (angle, _) in photographed().items()
    ]


def agreement() -> list[tuple[str, float, tuple[float, float] | None, tuple[float, float] | None]]:
    """Return sets of photographs, the share of the frictions that agrees, and their intervals."""
    look_up = LookUp()
    sliding, rolling = look_up.frictions
    rows = []
    second = [("second", speed) for speed in (10, 15, 30, 45)]
    for words, wanted in (
        ("the first photograph, 45 rpm", [("first", 45)]),
        ("the second photograph at 45 rpm", [("second", 45)]),
        ("the second photographs at 15 and 45 rpm", [second[1], second[3]]),
        ("the second photographs at all four speeds", second),
        ("the first photograph and the second one at 45 rpm", [("first", 45), ("second", 45)]),
    ):
        agrees = look_up.agreeing(wanted)
        intervals = [
            (float(v[agrees].min()), float(v[agrees].max())) if agrees.any() else None
            for v in (sliding, rolling)
        ]
        rows.append((words, float(agrees.mean()), intervals[0], intervals[1]))
    return rows


def along_the_ridge() -> dict[int, tuple[float, float]]:
    """Return the least and the largest angle at each speed where 45 rpm is that of the first."""
    look_up = LookUp()
    agrees = look_up.agreeing([("first", 45)])
    return {
        speed: (float(found[agrees].min()), float(found[agrees].max()))
        for speed in (10, 30)
        for found in [look_up.angle(*look_up.frictions, speed)]
    }


def search_of_the_second() -> dict[str, float]:
    """Return what the 240 published simulations of the second calibration say."""
    table = _table("second_search")
    slow, fast = table["misfit_15rpm_mm2"], table["misfit_45rpm_mm2"]
    sliding, rolling = ANSWERS["first"]
    near = np.argmin(np.hypot(table["sliding"] - sliding, table["rolling"] - rolling))
    best = np.argmin(slow * fast)
    return {
        "runs": len(table),
        "nearest_sliding": float(table["sliding"][near]),
        "nearest_rolling": float(table["rolling"][near]),
        "nearest_slow": float(slow[near]),
        "nearest_fast": float(fast[near]),
        "answer_slow": float(slow[best]),
        "answer_fast": float(fast[best]),
        "answer_particles": float(table["particles"][best]),
        "best_slow": float(slow.min()),
        "best_slow_particles": float(table["particles"][slow.argmin()]),
        "best_slow_fast": float(fast[slow.argmin()]),
        "best_fast": float(fast.min()),
        "best_fast_particles": float(table["particles"][fast.argmin()]),
        "best_fast_slow": float(slow[fast.argmin()]),
    }
