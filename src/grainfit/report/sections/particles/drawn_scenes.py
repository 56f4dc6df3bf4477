"""Ends of runs to be drawn in three dimensions, as small whole numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.view import RunView
from grainfit.report.packing import LARGEST, packed
from grainfit.report.sections.particles.shown_runs import visible

#: Particles of each of several drawings that are small.
_MOST_OF_SEVERAL = 8_000


def scene_of(view: RunView) -> dict[str, Any]:
    """Return the data of one drawing."""
    table = _table(view)
    return _scene(view, table, _step([table]))


def scenes_of_one_scale(views: Sequence[RunView]) -> list[dict[str, Any]]:
    """Return the data of drawings that stand side by side, in which lengths are the same."""
    if not views:
        return []
    tables = [_table(view, _MOST_OF_SEVERAL) for view in views]
    step = _step(tables)
    places = np.concatenate(tables) / step
    edges = [z / step for view in views for line in view.outlines() for _, _, z in line]
    top = float((places[:, 2] + places[:, 3]).max())
    reach = round(float((np.hypot(places[:, 0], places[:, 1]) + places[:, 3]).max()))
    extent = {"across": reach, "deep": reach, "top": round(top), "roof": round(max(top, *edges))}
    drawn = zip(views, tables, strict=True)
    return [{**_scene(view, table, step), "extent": extent} for view, table in drawn]


def _table(view: RunView, *most: int) -> NDArray[np.float64]:
    shown = visible(view.particles, *most)
    return np.column_stack([shown.positions, shown.radii])


def _step(tables: Sequence[NDArray[np.float64]]) -> float:
    return max(float(np.abs(table).max()) for table in tables) / LARGEST


def _scene(view: RunView, table: NDArray[np.float64], step: float) -> dict[str, Any]:
    return {
        "particles": packed(table / step),
        "outlines": [np.round(np.array(line) / step).tolist() for line in view.outlines()],
    }
