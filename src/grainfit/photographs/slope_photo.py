"""Angles of inclined planes and beds that were photographed: friction on a wall."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from PIL import ImageDraw

from grainfit.evaluation import Response
from grainfit.measurement.sheet import FLANK
from grainfit.one_line import OneLine
from grainfit.photographs import messages
from grainfit.photographs.overlay import PLATE, draw_line, write_overlay
from grainfit.photographs.several import mean_of_repeats, measure_each, with_sources
from grainfit.photographs.slope import LEVEL, Points, SlopeInPicture, measure_slope
from grainfit.tables import Summary, TextTable


@dataclass(frozen=True)
class PhotographedSlopes(Summary, OneLine):
    """What was measured on pictures of inclined planes or beds.

    Parameters
    ----------
    angle : Response
        Mean of the pictures and its standard uncertainty, degrees.
    slopes : tuple of SlopeInPicture
        What was found on each.
    parts : dict
        Standard uncertainties of the mean by their source, degrees.
    refused : dict
        Reason of each picture that was not measured.
    """

    angle: Response
    slopes: tuple[SlopeInPicture, ...]
    parts: dict[str, float]
    refused: dict[Path, str]

    @property
    def target(self) -> str:
        """Line of a calibration file, below ``[particle_wall]``."""
        value, error = self.angle.value, self.angle.standard_error
        return (
            f'sliding_friction = {{ measured_angle = "{value:.2f} deg", '
            f'uncertainty = "{error:.2f} deg" }}'
        )

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return a table of the pictures, what is refused, and the result."""
        rows = tuple(
            (
                found.picture.path.name,
                f"{found.angle:.2f} ± {found.uncertainty:.2f}",
                f"{found.level:+.2f}",
                found.seen_by,
            )
            for found in self.slopes
        )
        table = TextTable(("picture", "angle, °", "horizontal, °", "by"), rows)
        lines: list[str | TextTable] = [table]
        lines += [messages.REFUSED(path=path, reason=why) for path, why in self.refused.items()]
        lines.append(f"angle: {with_sources(self.angle, self.parts)}")
        if self.parts["horizontal"] >= LEVEL:
            lines.append(messages.LEVEL_SLOPE(error=self.parts["horizontal"]))
        if len(self.slopes) == 1:
            lines.append(messages.ONE_SLOPE())
        return (*lines, self.target)


def photo_slopes(
    paths: Sequence[Path], reference: Points | None, level: float | None, overlays: Path | None
) -> PhotographedSlopes:
    """Measure the inclination of a plane or a bed on pictures, each a repeat.

    Parameters
    ----------
    paths : sequence of Path
        The pictures.
    reference : pair of places, optional
        Columns and rows of two points of a level line in the one picture, pixels.
    level : float, optional
        Standard uncertainty of how level the camera is, degrees.
    overlays : Path, optional
        Folder for pictures with what was found drawn on them.

    Raises
    ------
    InputError
        A picture cannot be read.
    NotMeasurableError
        None can be measured, and why.
    """
    slopes, refused = measure_each(
        paths,
        lambda one: measure_slope(one, reference, level),
        partial(write_overlay, draw=_draw),
        overlays,
    )
    mean, parts = mean_of_repeats(
        [found.angle for found in slopes], [found.parts for found in slopes], "edge"
    )
    return PhotographedSlopes(mean, tuple(slopes), parts, refused)


def _draw(draw: ImageDraw.ImageDraw, found: SlopeInPicture, width: int) -> str:
    """Draw the slope and the horizontal; return the angle in words."""
    edge = found.edge
    foot = min(edge.start, edge.end, key=lambda place: -place[1])
    other = edge.end if foot == edge.start else edge.start
    reach, a = other[0] - foot[0], math.tan(math.radians(found.level))
    level = np.array([foot, (foot[0] + reach, foot[1] - reach * a)])
    draw_line(draw, level, PLATE, width)
    draw_line(draw, np.array([edge.start, edge.end]), FLANK, width)
    return f"{found.angle:.2f}° ± {found.uncertainty:.2f}° (horizontal {found.seen_by})"
