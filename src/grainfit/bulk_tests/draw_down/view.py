"""Pictures of a draw-down: the wedges on the shelf and the heap on the floor, from the side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.draw_down.surfaces import Surfaces
from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView, moved, raised
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.angle_of_repose import Flank
from grainfit.measurement.drawing import Drawing, fitted_lines, surface_path, wall_line
from grainfit.measurement.height_map import HeightMap
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import OVERSAMPLING, sheet
from grainfit.measurement.side_view import Rectangle, SideView

_PANEL_WIDTH = 960 * OVERSAMPLING
#: Drawings have this many pixels in a particle diameter.
_PIXELS = 20
#: Space beside the heap and above the bed in pictures, in diameters.
_SPACE = 2.0


def draw_draw_down(path: Path, surfaces: Surfaces, measured: Mapping[str, Response] | str) -> None:
    """Write a PNG of the end of a draw-down, with what was measured.

    That is the responses, or the reason why there are none.
    """
    if isinstance(measured, str):
        title, subtitle = "Draw-down: not valid", measured
        flanks: tuple[Flank, ...] = ()
    else:
        title, subtitle = _title(measured), _subtitle(measured)
        flanks = tuple(_raised_flanks(surfaces))
    view = SideView(surfaces.particles, _extent(surfaces), _walls(surfaces), flanks)
    sheet(title, subtitle, [view.panel(_PANEL_WIDTH)], _PANEL_WIDTH).save(path)


def _title(measured: Mapping[str, Response]) -> str:
    shear, repose = measured["shear_angle"], measured["angle_of_repose"]
    return (
        f"Shear angle {shear.value:.1f}° ± {shear.standard_error:.1f}°, "
        f"angle of repose {repose.value:.1f}° ± {repose.standard_error:.1f}°"
    )


def _subtitle(measured: Mapping[str, Response]) -> str:
    density, flow = measured["bulk_density"], measured["mass_flow"]
    share = measured["discharged_share"]
    return (
        f"bulk density {density.value:.0f} ± {density.standard_error:.0f} kg/m^3, mass flow "
        f"{flow.value:.3g} ± {flow.standard_error:.1g} kg/s, discharged share "
        f"{share.value:.3f} ± {share.standard_error:.3f} (± standard error)"
    )


def _raised_flanks(surfaces: Surfaces) -> Sequence[Flank]:
    """Return the fitted lines at their height in the scene, as far as there are any."""
    flanks: list[Flank] = []
    for measure, ground in (
        (surfaces.shear_angle, 0.0),
        (surfaces.angle_of_repose, surfaces.setup.floor),
    ):
        with suppress(NotMeasurableError):
            flanks += [raised(flank, ground) for flank in measure().flanks]
    return flanks


def _reach(surfaces: Surfaces) -> float:
    """Half the width that holds the box and nearly all of the heap, m."""
    x = np.abs(surfaces.particles.positions[:, 0])
    return max(float(np.quantile(x, 0.995)), surfaces.setup.box.width / 2)


def _extent(surfaces: Surfaces) -> Rectangle:
    space = _SPACE * surfaces.diameter
    half = _reach(surfaces) + space
    top = surfaces.setup.box.fill_height
    return (-half, surfaces.setup.floor - space / 2, half, top)


def _walls(surfaces: Surfaces) -> list[Rectangle]:
    """Sections of the walls: sides, shelf and floor."""
    setup = surfaces.setup
    inner, slot, low = setup.box.width / 2, setup.box.slot_width / 2, setup.underside
    outer, top = inner + surfaces.diameter / 2, setup.box.fill_height
    half, floor = setup.floor_half_width, setup.floor
    return [
        (-outer, low, -inner, top),
        (inner, low, outer, top),
        (-outer, low, -slot, 0.0),
        (slot, low, outer, 0.0),
        (-half, floor - surfaces.diameter / 2, half, floor),
    ]


@dataclass(frozen=True)
class DrawDownView(RunView):
    """The end of one draw-down.

    Parameters
    ----------
    surfaces : Surfaces
        The particles, and what is measured on them.
    """

    surfaces: Surfaces

    @property
    def particles(self) -> Particles:  # type: ignore[override]
        """Particles at the end; the lower floor is at z = 0, the middle of the depth at y = 0."""
        found, setup = self.surfaces.particles, self.surfaces.setup
        found = found.select(found.positions[:, 2] > setup.floor)
        middle = np.array([0.0, setup.box.depth / 2, setup.floor])
        return replace(found, positions=found.positions - middle)

    def drawing(self) -> Drawing:
        """Draw the surfaces from the side."""
        return self._drawing((), None)

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw the surfaces with the flanks of the heap and of the wedges."""
        try:
            measured = self.surfaces.angle_of_repose()
        except NotMeasurableError:
            return MeasuredDrawing(self.drawing(), "")
        words = "mean of both flanks of the lower heap, from its surface averaged over the depth"
        return MeasuredDrawing(self._drawing(measured.flanks, target), words)

    def _drawing(self, flanks: Sequence[Flank], target: float | None) -> Drawing:
        surfaces, setup = self.surfaces, self.surfaces.setup
        pixel = surfaces.diameter / _PIXELS
        shelf = -setup.floor
        fitted, wanted = fitted_lines(flanks, 0.0, pixel, target)
        paths = [
            _path(surfaces.heap, 0.0, pixel, _reach(surfaces)),
            _path(surfaces.wedges, shelf, pixel, setup.box.width),
        ]
        inner, slot, top = setup.box.width / 2, setup.box.slot_width / 2, setup.box.fill_height
        walls = [((-setup.floor_half_width, 0.0), (setup.floor_half_width, 0.0))]
        for side in (-1, 1):
            walls.append(((side * slot, shelf), (side * inner, shelf)))
            walls.append(((side * inner, shelf), (side * inner, shelf + top)))
        return Drawing(
            path=" ".join(paths),
            half_width=round(_reach(surfaces) / pixel) + _PIXELS,
            height=round((shelf + top) / pixel) + _PIXELS,
            fitted=fitted,
            wanted=wanted,
            walls=tuple(wall_line(start, end, pixel) for start, end in walls),
        )

    def outlines(self) -> Sequence[Outline]:
        """Return the edges of box, shelf and floor."""
        setup = self.surfaces.setup
        half, depth = _reach(self.surfaces), setup.box.depth
        corners = [(-half, 0.0), (half, 0.0), (half, depth), (-half, depth), (-half, 0.0)]
        floor = [(x, y, setup.floor) for x, y in corners]
        lines = [*setup.box.outlines(setup.box.fill_height), floor]
        return moved(lines, -depth / 2, -setup.floor)


def _path(surface: HeightMap, ground: float, pixel: float, reach: float) -> str:
    shown = np.abs(surface.x) <= reach
    return surface_path(surface.x[shown], surface.profile[shown], ground, pixel)
