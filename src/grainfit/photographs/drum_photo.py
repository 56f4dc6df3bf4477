"""Dynamic angles of repose of drums that were photographed or filmed, for the targets of a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.one_line import OneLine
from grainfit.photographs import messages
from grainfit.photographs.drum import (
    DrumSeries,
    DrumSize,
    DrumStill,
    measure_still,
    measure_stills,
    measure_video,
)
from grainfit.photographs.drum_overlay import draw_drum_overlay, draw_refused
from grainfit.photographs.pictures import read_picture
from grainfit.photographs.videos import Video, is_video
from grainfit.tables import Summary, TextTable

#: Standard uncertainty of the camera's being level, degrees: by default, by the marker sheet, and
#: where the drum was filmed turning both ways.
_LEVEL, _BY_SHEET, _BOTH_WAYS = 0.5, 0.2, 0.1
#: Standard uncertainties of angles by pixels, lens, compression and circle, degrees: what is left
#: of the errors on the first rendered videos of `benchmarks/photographed_drums.py`.
_PICTURE = {"dynamic_angle": 0.6, "surface_angle": 0.9, "upper_angle": 1.0, "lower_angle": 1.2}

Found = TypeVar("Found")


@dataclass(frozen=True)
class PhotographedDrum(Summary, OneLine):
    """What was measured on videos and stills of a turning drum.

    Parameters
    ----------
    responses : dict
        The angles of the drum test by their names, with their standard uncertainties, degrees.
    parts : dict
        Standard uncertainties of each angle by their source, degrees.
    series : tuple of DrumSeries
        What was found in each video, and in the stills.
    diameter : float or None
        Of the drum, m; None where it is not known.
    refused : dict
        Reason of each video or picture that was not measured.
    """

    responses: dict[str, Response]
    parts: dict[str, dict[str, float]]
    series: tuple[DrumSeries, ...]
    diameter: float | None
    refused: dict[Path, str]

    @property
    def dynamic_angle(self) -> Response:
        """Inclination of the bed by its centre, degrees."""
        return self.responses["dynamic_angle"]

    @property
    def fill_level(self) -> float:
        """Share of the drum that the bed takes."""
        return float(np.mean([one.fill_level for one in self.series]))

    @property
    def rotational_speed(self) -> Response | None:
        """Mean over the videos in which a mark is seen, rad/s; None without any."""
        return speed_of(self.series)

    @property
    def target(self) -> str:
        """Line of a calibration file."""
        return self._line("dynamic_angle")

    def _line(self, name: str) -> str:
        found = self.responses[name]
        return (
            f'targets.{name} = {{ value = "{found.value:.2f} deg", '
            f'uncertainty = "{found.standard_error:.2f} deg" }}'
        )

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return a table of the angles, what is refused, and lines for a calibration file."""
        rows = tuple(
            (
                name.replace("_", " "),
                f"{found.value:.2f} ± {found.standard_error:.2f}",
                ", ".join(f"{source} {part:.2f}" for source, part in self.parts[name].items()),
            )
            for name, found in self.responses.items()
        )
        lines: list[str | TextTable] = [TextTable(("angle", "mean, °", "by source, °"), rows)]
        lines += [messages.REFUSED(path=path, reason=why) for path, why in self.refused.items()]
        if _of_level(self.parts) >= _LEVEL:
            lines.append(messages.LEVEL(error=_of_level(self.parts)))
        if "perspective" in self.parts["dynamic_angle"]:
            lines.append(messages.PERSPECTIVE())
        speed = self.rotational_speed
        if speed is None:
            lines.append(messages.NO_MARK())
        lines += [self._line(name) for name in self.responses]
        if self.diameter is not None:
            lines.append(f'drum_radius = "{500 * self.diameter:.4g} mm"')
        if speed is not None:
            lines.append(f'rotational_speed = "{30 / math.pi * speed.value:.4g} rpm"')
        return (*lines, f"fill_level = {self.fill_level:.2f}")


def speed_of(series: Sequence[DrumSeries]) -> Response | None:
    """Return the mean speed of videos in which a mark is seen, rad/s; None without any."""
    known = [one.speed for one in series if one.speed is not None]
    if not known:
        return None
    error = math.sqrt(sum(speed.standard_error**2 for speed in known)) / len(known)
    return Response(float(np.mean([speed.value for speed in known])), error)


def photo_drum(
    groups: Sequence[Sequence[Path]],
    size: DrumSize | None,
    level: float | None,
    overlays: Path | None,
) -> PhotographedDrum:
    """Measure the angles of a turning drum.

    Parameters
    ----------
    groups : sequence of sequence of Path
        Videos, and stills; all single stills, and those of a folder, are of one series.
    size : DrumSize or None
        Of the drum, where it is known.
    level : float or None
        Standard uncertainty of the camera's being level, degrees.
    overlays : Path or None
        Folder for pictures with what was found drawn on them.

    Raises
    ------
    NotMeasurableError
        Nothing can be measured, and why.
    """
    series, refused = measure_series(groups, size or DrumSize())
    if overlays is not None:
        draw_overlays(overlays, series, refused)
    if not series:
        reasons = "\n".join(messages.REFUSED(path=p, reason=why) for p, why in refused.items())
        raise NotMeasurableError(
            messages.ALL_REFUSED(reasons=reasons) if len(refused) > 1 else reasons
        )
    responses, parts = mean_of_series(series, level)
    diameter = None if size is None else 2 * size.radius
    return PhotographedDrum(responses, parts, tuple(series), diameter, refused)


def measure_series(
    groups: Sequence[Sequence[Path]], size: DrumSize, *, marker: bool = False
) -> tuple[list[DrumSeries], dict[Path, str]]:
    """Measure every video, and the stills; return also why others were not measured.

    Parameters
    ----------
    groups : sequence of sequence of Path
        As of `photo_drum`.
    size : DrumSize
        Of the drum.
    marker : bool
        Whether the marker sheet must be seen.

    Raises
    ------
    InputError
        A file cannot be read.
    """
    refused: dict[Path, str] = {}
    series: list[DrumSeries] = []

    def kept(path: Path, measure: Callable[[], DrumSeries]) -> None:
        try:
            found = measure()
        except NotMeasurableError as error:
            refused[path] = str(error)
            return
        if marker and not found.by_sheet:
            refused[path] = messages.NO_MARKER()
        else:
            series.append(found)

    single = [group[0] for group in groups if len(group) == 1]
    for path in filter(is_video, [path for group in groups for path in group]):
        video = Video(path)
        kept(path, lambda video=video: measure_video(video, size))  # type: ignore[misc]
    of_one = [[path for path in single if not is_video(path)]]
    of_one += [[path for path in group if not is_video(path)] for group in groups if group[1:]]
    for paths in filter(None, of_one):
        for way in _by_way(_stills(paths, refused), lambda one: one.turn > 0):
            kept(way[0].path, lambda way=way: measure_stills(way, size))  # type: ignore[misc]
    return series, refused


def draw_overlays(folder: Path, series: Sequence[DrumSeries], refused: Mapping[Path, str]) -> None:
    """Write a picture of each series with what was found, and of each refused file with why."""
    for one in series:
        draw_drum_overlay(folder, one)
    for path, why in refused.items():
        draw_refused(folder, path, why)


def mean_of_series(
    series: Sequence[DrumSeries], level: float | None
) -> tuple[dict[str, Response], dict[str, dict[str, float]]]:
    """Return the angles with their standard uncertainties, and these by their source, degrees."""
    parts = {name: _parts(name, series, level) for name in series[0].responses}
    responses = {
        name: Response(_mean(name, series), math.sqrt(sum(part**2 for part in found.values())))
        for name, found in parts.items()
    }
    return responses, parts


def _stills(paths: Sequence[Path], refused: dict[Path, str]) -> list[DrumStill]:
    found = []
    for path in paths:
        picture = read_picture(path)
        try:
            found.append(measure_still(path, picture.colours, picture.focal))
        except NotMeasurableError as error:
            refused[path] = str(error)
    return found


def _by_way(found: Sequence[Found], rises_right: Callable[[Found], bool]) -> list[list[Found]]:
    """Return what was found of each way in which the drum turns."""
    ways = [[one for one in found if rises_right(one) == right] for right in (True, False)]
    return [way for way in ways if way]


def _ways(series: Sequence[DrumSeries]) -> list[list[DrumSeries]]:
    return _by_way(series, lambda one: one.rises_right)


def _mean(name: str, series: Sequence[DrumSeries]) -> float:
    """Return the mean of both ways: a camera that is not level adds to one what the other lacks."""
    means = [np.mean([one.responses[name].value for one in way]) for way in _ways(series)]
    return float(np.mean(means))


def _parts(name: str, series: Sequence[DrumSeries], level: float | None) -> dict[str, float]:
    ways = _ways(series)
    square = 0.0
    for way in ways:
        values = [one.responses[name].value for one in way]
        errors = [one.responses[name].standard_error for one in way]
        within = math.hypot(*errors) / len(way)
        between = float(np.std(values, ddof=1)) / math.sqrt(len(way)) if len(way) > 1 else 0.0
        square += max(within, between) ** 2
    parts = {"over time": math.sqrt(square) / len(ways)}
    for source in series[0].unsure[name]:
        parts[source] = float(np.mean([one.unsure[name][source] for one in series]))
    if all(one.by_sheet for one in series):
        parts["level"] = _BY_SHEET
    elif len(ways) == 2 and not any(one.by_sheet for one in series):
        parts["level"] = _BOTH_WAYS
    else:
        parts["level"] = _LEVEL if level is None else level
    return {**parts, "picture": _PICTURE[name]}


def _of_level(parts: dict[str, dict[str, float]]) -> float:
    return next(iter(parts.values()))["level"]
