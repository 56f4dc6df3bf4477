"""Ends of runs to be drawn in three dimensions, as small whole numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.view import RunView
from grainfit.report.drawing_data import DrawingScale
from grainfit.report.sections.particles.shown_runs import visible

#: Particles of each of several drawings that are small.
_MOST_OF_SEVERAL = 8_000
#: Share of the particles that a picture shows: single ones roll away.
_NEARLY_ALL = 0.99
#: Direction from which drawings are seen first, radians about the z axis, as in the script.
_AZIMUTH = 0.5
_NO_EDGE = np.empty((0, 3))


def scene_of(view: RunView) -> dict[str, Any]:
    """Return the data of one drawing."""
    table = _table(view)
    return _scene(view, table, DrawingScale.of(table))


def scenes_of_one_scale(views: Sequence[RunView]) -> list[dict[str, Any]]:
    """Return the data of drawings that stand side by side, in which lengths are the same."""
    if not views:
        return []
    tables = [_table(view, _MOST_OF_SEVERAL) for view in views]
    scale = DrawingScale.of(*tables)
    edges = [np.reshape(line, (-1, 3)) for view in views for line in view.outlines()]
    places, corners = np.concatenate(tables), np.concatenate([*edges, _NO_EDGE])
    extent = _extent(places / scale.step, corners / scale.step)
    drawn = zip(views, tables, strict=True)
    return [{**_scene(view, table, scale), "extent": extent} for view, table in drawn]


def _extent(places: NDArray[np.float64], edges: NDArray[np.float64]) -> dict[str, int]:
    """Return what a picture shows: as it begins, across and deep from the middle, and upwards."""
    top = (places[:, 2] + places[:, 3]).max()
    return {
        "across": _reach(places, edges, 0.0),
        "deep": _reach(places, edges, math.pi / 2),
        "top": round(float(top)),
        "roof": round(float(max(top, edges[:, 2].max(initial=0.0)))),
    }


def _reach(places: NDArray[np.float64], edges: NDArray[np.float64], turn: float) -> int:
    """Return how far nearly all particles and all edges reach to a side."""
    cosine, sine = math.cos(_AZIMUTH + turn), math.sin(_AZIMUTH + turn)
    sides = np.abs(places[:, 0] * cosine + places[:, 1] * sine) + places[:, 3]
    others = np.abs(edges[:, 0] * cosine + edges[:, 1] * sine)
    return round(float(max(np.quantile(sides, _NEARLY_ALL), others.max(initial=0.0))))


def _table(view: RunView, *most: int) -> NDArray[np.float64]:
    shown = visible(view.particles, *most)
    return np.column_stack([shown.positions, shown.radii])


def _scene(view: RunView, table: NDArray[np.float64], scale: DrawingScale) -> dict[str, Any]:
    return {"particles": scale.packed(table), "outlines": scale.outlines(view.outlines())}
