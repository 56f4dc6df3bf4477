"""Pictures of a drum: the bed along the axis with fitted lines, and its angle over time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.bulk_tests.drum.angles import DrumAngles
from grainfit.bulk_tests.drum.setup import DrumSetup
from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView, raised
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement.angle_of_repose import Flank
from grainfit.measurement.drawing import Drawing, Line, fitted_lines, wall_line
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import FLANK, INK, OVERSAMPLING, sheet
from grainfit.measurement.side_view import SideView

_PANEL_WIDTH = 640 * OVERSAMPLING
#: Drawings have this many pixels in a particle diameter.
_PIXELS = 20
_CORNERS = 72
#: Depth behind the front to which particles are drawn as a camera sees them, in diameters.
_FRONT = 1.5


def draw_drum(
    path: Path,
    angles: DrumAngles,
    lining: Particles | None,
    measured: Mapping[str, Response] | str,
) -> None:
    """Write a PNG of the bed and the lining at the end, and of the inclination over time.

    What was measured is the responses, or the reason why there are none.
    """
    bed, flanks_of = angles.bed, ("upper_angle", "lower_angle")
    flanks: Sequence[Flank] = ()
    with suppress(NotMeasurableError):
        flanks = [flank for name, flank in angles.flanks().items() if name in flanks_of]
    title, subtitle = _titles(angles, measured)
    view = SideView(
        particles=seen_along_axis(bed.last, bed.setup),
        extent=_extent(bed.setup, bed.diameter),
        walls=(),
        flanks=[raised(flank, bed.setup.drum_radius) for flank in flanks],
        lines=[_circle(bed.setup)],
        glued=() if lining is None else (seen_along_axis(lining, bed.setup),),
    )
    panels = [view.panel(_PANEL_WIDTH), _series_panel(angles)]
    sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)


def _titles(angles: DrumAngles, measured: Mapping[str, Response] | str) -> tuple[str, str]:
    if isinstance(measured, str):
        return "Drum: not valid", measured
    mean = measured["dynamic_angle"]
    others = (
        f"{name.replace('_', ' ')} {found.value:.1f}° ± {found.standard_error:.1f}°"
        for name, found in measured.items()
        if name != "dynamic_angle"
    )
    return (
        f"Dynamic angle of repose {mean.value:.1f}° ± {mean.standard_error:.1f}°",
        f"{', '.join(others)} (± standard error), wall slip {100 * angles.slip:.0f} %; "
        f"{len(angles.avalanches)} whole avalanches, which begin at the lines, in "
        f"{angles.bed.turns:.2g} turns; the last frame is shown",
    )


def seen_along_axis(particles: Particles, setup: DrumSetup) -> Particles:
    """Return particles with the axis of the drum along y, and its lowest point at the origin."""
    x, y, z = particles.positions.T
    places = np.column_stack((y, setup.drum_length / 2 - x, z + setup.drum_radius))
    return replace(particles, positions=places)


def _extent(setup: DrumSetup, diameter: float) -> tuple[float, float, float, float]:
    side = setup.drum_radius + diameter
    return (-side, -diameter, side, 2 * setup.drum_radius + diameter)


def _circle(setup: DrumSetup) -> list[tuple[float, float]]:
    """Return the drum as a line across and height, from its lowest point on the way it turns."""
    azimuths = np.linspace(0, 2 * math.pi, _CORNERS + 1)
    radius = setup.drum_radius
    return [(radius * math.sin(a), radius - radius * math.cos(a)) for a in azimuths]


def _series_panel(angles: DrumAngles) -> Image.Image:
    """Draw the inclination over time, and the whole avalanches that were averaged."""
    series, turns = angles.bed.inclinations, angles.bed.turns
    places = np.linspace(0, turns, len(series))
    marks: list[float] = []
    with suppress(NotMeasurableError):
        marks = [bound / (len(series) - 1) * turns for bound in angles.avalanches.bounds]
    lines = [
        PlottedLine([0, turns], 2 * [angles.mean], f"mean {angles.mean:.1f}°", FLANK, 4),
        PlottedLine(places, series, colour=INK),
    ]
    labels = "turns of the drum", "inclination of the bed by its centre of mass, °"
    size = _PANEL_WIDTH, 0.6 * _PANEL_WIDTH
    return line_panel(lines, *labels, size, from_zero=False, marks=marks)


@dataclass(frozen=True)
class DrumView(RunView):
    """The bed in a turning drum.

    Parameters
    ----------
    angles : DrumAngles
        The bed, and what is measured on it.
    """

    angles: DrumAngles

    @property
    def _setup(self) -> DrumSetup:
        return self.angles.bed.setup

    @property
    def particles(self) -> Particles:  # type: ignore[override]
        """Particles at the end; the axis of the drum is along y, its lowest point at the origin."""
        return seen_along_axis(self.angles.bed.last, self._setup)

    def drawing(self) -> Drawing:
        """Draw the mean surface of the bed."""
        return self._drawing((), None)

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw the mean surface with a line at the dynamic angle."""
        try:
            flank = self.angles.flanks()["dynamic_angle"]
        except NotMeasurableError:
            return MeasuredDrawing(self.drawing(), "")
        words = f"inclination by the centre of mass, mean of {self.angles.bed.turns:.2g} turns"
        return MeasuredDrawing(self._drawing((flank,), target), words)

    @property
    def _pixel(self) -> float:
        return self.angles.bed.diameter / _PIXELS

    def _drawing(self, flanks: Sequence[Flank], target: float | None) -> Drawing:
        setup, pixel = self._setup, self._pixel
        fitted, wanted = fitted_lines(flanks, setup.drum_radius, pixel, target)
        side = math.ceil(setup.drum_radius / pixel) + _PIXELS
        return Drawing(
            path=self._path(),
            half_width=side,
            height=side + math.ceil(setup.drum_radius / pixel),
            fitted=fitted,
            wanted=wanted,
            walls=tuple(self._walls()),
        )

    def _walls(self) -> list[Line]:
        corners = _circle(self._setup)
        ends = itertools.pairwise(corners)
        return [wall_line(start, end, self._pixel) for start, end in ends]

    def _path(self) -> str:
        """Return the outline of the mean bed as an SVG path: its surface, and the drum below it."""
        radius, pixel = self._setup.drum_radius, self._pixel
        places = self.angles.surface.places()
        surface = [(y, z) for y, z in places if math.hypot(y, z) < radius]
        upper, lower = (math.atan2(surface[end][0], -surface[end][1]) for end in (-1, 0))
        arc = [(radius * math.sin(a), -radius * math.cos(a)) for a in np.linspace(upper, lower, 40)]
        points = (f"{y / pixel:.0f},{-(z + radius) / pixel:.0f}" for y, z in [*surface, *arc])
        return f"M{' L'.join(points)}Z"

    def before_camera(self) -> Drawing:
        """Draw the particles at the front at the end, and lines at the angles of all frames."""
        flanks: Sequence[Flank] = ()
        with suppress(NotMeasurableError):
            flanks = list(self.angles.flanks().values())
        pixel = self._pixel
        return replace(
            self._drawing((), None),
            path=self._front(),
            fitted=fitted_lines(flanks, 0.0, pixel, None)[0],
            pixel_size=pixel,
        )

    def _front(self) -> str:
        """Return the particles nearest to the camera as circles of an SVG path."""
        setup, pixel, seen = self._setup, self._pixel, self.particles
        across, depth, heights = seen.positions.T
        near = depth + setup.drum_length / 2 < _FRONT * seen.diameter
        places = (across[near], heights[near] - setup.drum_radius, seen.radii[near])
        circles = zip(*(values / pixel for values in places), strict=True)
        return "".join(
            f"M{y - r:.0f},{-z:.0f}a{r:.0f},{r:.0f} 0 1 0 {2 * r:.0f},0"
            f"a{r:.0f},{r:.0f} 0 1 0 {-2 * r:.0f},0"
            for y, z, r in circles
        )

    def outlines(self) -> Sequence[Outline]:
        """Return the two ends of the simulated slice of the drum."""
        half = self._setup.drum_length / 2
        return [[(y, end, z) for y, z in _circle(self._setup)] for end in (-half, half)]
