"""Pictures of a discharge: the rest in the container, and the mass in it over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grainfit.bulk_tests.discharge.setup import DischargeSetup
from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.shared.validity import arch
from grainfit.bulk_tests.view import MeasuredDrawing, Outline, RunView, moved
from grainfit.errors import NotMeasurableError
from grainfit.measurement.drawing import CurveScale, Drawing, Line, surface_path, wall_line
from grainfit.measurement.flow_rate import FlowRate, flow_rate, stopped_flow
from grainfit.measurement.height_map import height_map
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import FLANK, OVERSAMPLING, sheet
from grainfit.measurement.side_view import Rectangle, SideView

_PANEL_WIDTH = 560 * OVERSAMPLING
_MASS_SIZE = (_PANEL_WIDTH, 420 * OVERSAMPLING)
#: Half the width of the drawing of the mass over time, pixels.
_HALF_WIDTH = 400
#: Drawings of the container have this many pixels in a particle diameter.
_PIXELS = 20
_SPACE = 12
#: Share of the mass that may leave between the last record and the end of a run.
_RECORDED_BEFORE = 0.025


@dataclass(frozen=True)
class DischargeView(RunView):
    """The end of one discharge.

    Parameters
    ----------
    setup : DischargeSetup
        Geometry of the test.
    end : Particles
        All particles that are left.
    time, mass : ndarray of shape (n,)
        Mass in the container over time, s and kg.
    diameter : float
        Sauter diameter, m.
    """

    setup: DischargeSetup
    end: Particles
    time: NDArray[np.float64]
    mass: NDArray[np.float64]
    diameter: float

    @property
    def particles(self) -> Particles:  # type: ignore[override]
        """Particles that are left in the container.

        Raises
        ------
        NotMeasurableError
            The container is empty.
        """
        inside = self._inside
        return replace(inside, positions=inside.positions - [0.0, self._middle, 0.0])

    @property
    def drawn(self) -> Particles:
        """Particles that are drawn."""
        return self.end

    @property
    def drawn_when(self) -> str:
        """When it was as it is drawn, if not at the end: the end of a sentence."""
        return ""

    @property
    def _inside(self) -> Particles:
        inside = self.drawn.select(self.drawn.positions[:, 2] > 0)
        if not len(inside):
            raise NotMeasurableError(messages.EMPTY_CONTAINER())
        return inside

    @property
    def _middle(self) -> float:
        """Middle of the depth, m."""
        return (self.setup.container.period or 0.0) / 2

    @property
    def is_whole(self) -> bool:
        """Whether the run went on until all was at rest."""
        share = self.setup.known_share
        if share is None:
            return True
        return bool(self.mass[-1] > (1 - share + _RECORDED_BEFORE) * self.mass[0])

    @property
    def arch(self) -> str:
        """Description of an arch over the orifice that has stopped the flow; empty without one."""
        if not self.is_whole:
            return ""
        container, positions = self.setup.container, self.end.positions
        is_slot = container.period is not None
        across = positions[:, 0] if is_slot else np.hypot(positions[:, 0], positions[:, 1])
        held = (np.abs(across) < container.half_outlet / 2) & (positions[:, 2] > 0)
        return arch(self.end.select(held), "slot" if is_slot else "orifice")

    def flow(self) -> FlowRate:
        """Return the mass flow; a material that arches has none, which is a result.

        Raises
        ------
        NotMeasurableError
            Nothing flows, though nothing holds it, or it was recorded too rarely.
        """
        if self.arch:
            return stopped_flow(self.time, self.mass, float(self.end.masses.mean()))
        return flow_rate(self.time, self.mass, is_whole=self.is_whole)

    def picture(self, path: Path, flow: FlowRate | str, words: str = "") -> None:
        """Write a PNG of the rest in the container and of the mass in it over time.

        The flow that was measured, or the reason why there is none; what else was measured in
        words.
        """
        if isinstance(flow, str):
            title, subtitle, fitted = f"{path.stem.capitalize()}: not valid", flow, None
        else:
            title = f"Mass flow {flow.value:.3g} ± {flow.standard_error:.1g} kg/s"
            how = f"the flow is measured while {self._window} has left"
            subtitle, fitted = f"{words}; {self.arch or how}{self.drawn_when}", flow
        panels = [
            SideView(self._shown, self._extent, (), lines=self._walls).panel(_PANEL_WIDTH),
            self._mass_panel(fitted),
        ]
        sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)

    def _mass_panel(self, flow: FlowRate | None) -> Image.Image:
        """Draw the mass in the container over time, and the part that the flow was fitted to."""
        lines = [PlottedLine(self.time - self.time[0], self.mass)]
        if flow is not None:
            times, left = zip(flow.start, flow.end, strict=True)
            masses = float(self.mass[0]) - np.array(left)
            label = f"fitted: {flow.value:.3g} kg/s"
            lines.append(PlottedLine(times - self.time[0], masses, label, FLANK, 4))
        return line_panel(lines, "time, s", "mass in the container, kg", _MASS_SIZE)

    @property
    def _window(self) -> str:
        return f"10 to 50 % of the mass{' that leaves' if self.is_whole else ''}"

    @property
    def _shown(self) -> Particles:
        """All particles of a slice; the half of a cylinder behind its axis."""
        if self.setup.container.period is not None:
            return self.drawn
        return self.drawn.select(self.drawn.positions[:, 1] > 0)

    @property
    def _height(self) -> float:
        return self.setup.bed_height

    @property
    def _extent(self) -> Rectangle:
        half = self.setup.half_width + self.diameter
        return (-half, -2 * self.diameter, half, self._height)

    @property
    def _walls(self) -> list[list[tuple[float, float]]]:
        """Sections of the container on both sides, m."""
        corners = self.setup.container.section(self._height)
        return [[(side * x, z) for x, z in corners] for side in (-1, 1)]

    def drawing(self) -> Drawing:
        """Draw the rest in the container from the side."""
        inner, pixel = self.setup.half_width, self.diameter / _PIXELS
        path = "M0,0Z"
        if (self.drawn.positions[:, 2] > 0).any():
            x, heights = self._silhouette()
            path = surface_path(x, heights, 0.0, pixel)
        walls = [line for side in self._walls for line in pairwise(side)]
        return Drawing(
            path=path,
            half_width=round(inner / pixel) + _SPACE,
            height=round(self._height / pixel) + _SPACE,
            walls=tuple(wall_line(start, end, pixel) for start, end in walls),
        )

    def _silhouette(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Highest surface over x, averaged over the depth of a slot."""
        period, inner = self.setup.container.period, self.setup.half_width
        if period is not None:
            surface = height_map(self._inside, -inner, inner, period, 0.0)
            return surface.x, surface.profile
        # A slice through the axis, one diameter thick.
        middle = np.abs(self._inside.positions[:, 1]) < self.diameter / 2
        slab = self._inside.select(middle) if middle.any() else self._inside
        surface = height_map(slab, -inner, inner, 2 * inner, 0.0)
        return surface.x, np.asarray(surface.heights.max(axis=0))

    def measured_drawing(self, target: float | None) -> MeasuredDrawing:
        """Draw the mass in the container over time, the fitted flow, and the target's slope."""
        try:
            flow = self.flow()
        except NotMeasurableError:
            return MeasuredDrawing(self.drawing(), "")
        full, begin = float(self.mass[0]), float(self.time[0])
        scale = CurveScale(float(self.time[-1]) - begin, full, _HALF_WIDTH)
        (first, gone), (last, _) = flow.start, flow.end

        def line(rate: float) -> Line:
            later = gone + rate * (last - first)
            return scale.line((first - begin, full - gone), (last - begin, full - later))

        wanted = [] if target is None else [line(target)]
        curve = (self.time - begin, self.mass)
        drawing = scale.drawing([curve], [line(flow.value)], wanted)
        words = f"slope of the drawn mass in the container over time, while {self._window} has left"
        return MeasuredDrawing(drawing, self.arch or words)

    def outlines(self) -> Sequence[Outline]:
        """Return the edges of the container."""
        return moved(self.setup.container.outlines(self._height), -self._middle, 0.0)
