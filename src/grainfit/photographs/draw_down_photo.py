"""Angles of draw-downs that were photographed, for the targets of a calibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PIL import ImageDraw

from grainfit.evaluation import Response
from grainfit.measurement.sheet import FLANK
from grainfit.one_line import OneLine
from grainfit.photographs import messages
from grainfit.photographs.draw_down import DrawDownInPicture, measure_draw_down
from grainfit.photographs.heap import contour_of
from grainfit.photographs.overlay import OUTLINE, draw_line, write_overlay
from grainfit.photographs.several import mean_of_repeats, measure_each, with_sources
from grainfit.tables import Summary, TextTable


@dataclass(frozen=True)
class PhotographedDrawDowns(Summary, OneLine):
    """What was measured on pictures of draw-downs.

    Parameters
    ----------
    responses : dict
        Angles of the draw-down test by their names, with their standard uncertainties, degrees;
        without ``shear_angle`` where no picture shows two wedges.
    parts : dict
        Standard uncertainties of each by their source, degrees.
    pictures : tuple of DrawDownInPicture
        What was found on each.
    refused : dict
        Reason of each picture that was not measured.
    """

    responses: dict[str, Response]
    parts: dict[str, dict[str, float]]
    pictures: tuple[DrawDownInPicture, ...]
    refused: dict[Path, str]

    @property
    def targets(self) -> tuple[str, ...]:
        """Lines of a calibration file."""
        return tuple(
            f'targets.{name} = {{ value = "{found.value:.2f} deg", '
            f'uncertainty = "{found.standard_error:.2f} deg" }}'
            for name, found in self.responses.items()
        )

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return a table of the pictures, what is refused, and lines for a calibration file."""
        names = ("angle_of_repose", "shear_angle")
        rows = tuple(
            (one.picture.path.name, *(_number(one.angles.get(name)) for name in names))
            for one in self.pictures
        )
        lines: list[str | TextTable] = [TextTable(("picture", "repose, °", "shear, °"), rows)]
        unseen = {one.picture.path: one.no_wedges for one in self.pictures if one.no_wedges}
        reasons = {**unseen, **self.refused}
        lines += [messages.REFUSED(path=path, reason=why) for path, why in reasons.items()]
        for name, found in self.responses.items():
            lines.append(f"{name.replace('_', ' ')}: {with_sources(found, self.parts[name])}")
        if len(self.pictures) == 1:
            lines.append(messages.ONE_HEAP())
        return (*lines, *self.targets)


def _number(angle: float | None) -> str:
    return "–" if angle is None else f"{angle:.2f}"


def photo_draw_downs(
    paths: Sequence[Path], diameters: float | None, overlays: Path | None
) -> PhotographedDrawDowns:
    """Measure heap and wedges of draw-downs, one on each picture.

    Parameters
    ----------
    paths : sequence of Path
        The pictures.
    diameters : float, optional
        Inner width of the box in particle diameters.
    overlays : Path, optional
        Folder for pictures with what was found drawn on them.

    Raises
    ------
    InputError
        A picture cannot be read.
    NotMeasurableError
        None can be measured, and why.
    """
    pictures, refused = measure_each(
        paths,
        lambda one: measure_draw_down(one, diameters),
        partial(write_overlay, draw=_draw),
        overlays,
    )
    responses: dict[str, Response] = {}
    parts: dict[str, dict[str, float]] = {}
    for name in ("shear_angle", "angle_of_repose"):
        some = [one for one in pictures if name in one.angles]
        if some:
            responses[name], parts[name] = mean_of_repeats(
                [one.angles[name] for one in some], [one.parts[name] for one in some], "flanks"
            )
    return PhotographedDrawDowns(responses, parts, tuple(pictures), refused)


def _draw(draw: ImageDraw.ImageDraw, found: DrawDownInPicture, width: int) -> str:
    """Draw heap, wedges and flanks; return the angles in words."""
    for mask in found.masks:
        draw_line(draw, contour_of(mask), OUTLINE, width, closed=True)
    for line in found.lines:
        draw_line(draw, line, FLANK, 2 * width)
    words = [f"{name.replace('_', ' ')} {angle:.1f}°" for name, angle in found.angles.items()]
    return ", ".join(words) + (f"; no shear angle: {found.no_wedges}" if found.no_wedges else "")
