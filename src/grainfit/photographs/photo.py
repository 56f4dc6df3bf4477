"""Angles of repose of heaps that were photographed, for the targets of a calibration."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Protocol, get_args, overload

import numpy as np

from grainfit.errors import Fault, InputError
from grainfit.evaluation import Response
from grainfit.messages import Message
from grainfit.one_line import OneLine
from grainfit.photographs import messages
from grainfit.photographs.by_hand import ByHand
from grainfit.photographs.draw_down_photo import PhotographedDrawDowns, photo_draw_downs
from grainfit.photographs.drum import DrumSize
from grainfit.photographs.drum_photo import PhotographedDrum, photo_drum
from grainfit.photographs.heap import HeapInPicture, measure_heap
from grainfit.photographs.kept_list import hash_of
from grainfit.photographs.overlay import draw_overlay
from grainfit.photographs.pictures import Picture, is_picture, opencv
from grainfit.photographs.several import measure_each, with_sources
from grainfit.photographs.slope import Points
from grainfit.photographs.slope_photo import PhotographedSlopes, photo_slopes
from grainfit.photographs.videos import is_video
from grainfit.tables import Summary, TextTable
from grainfit.units import UnitError, to_unit

#: Scatter of the flanks of one heap before any is seen, degrees, and how many flanks it counts as.
_FLANKS, _COUNTS_AS = 1.2, 2
#: Any number of pictures of one heap shows six independent flanks (as of simulated silhouettes).
_INDEPENDENT_FLANKS = 6

Photographed = Literal["heap", "funnel", "draw_down", "drum", "slope"]
Heaps = Literal["heap", "funnel"]
PathLike = str | Path


@dataclass(frozen=True)
class PhotographedHeaps(Summary, OneLine):
    """What was measured on pictures of heaps.

    Parameters
    ----------
    angle_of_repose : Response
        Mean of the heaps and its standard uncertainty, degrees.
    heaps : tuple of tuple of HeapInPicture
        Measured pictures of each heap.
    parts : dict
        Standard uncertainties of the mean by their source, degrees.
    refused : dict
        Reason of each picture that was not measured.
    """

    angle_of_repose: Response
    heaps: tuple[tuple[HeapInPicture, ...], ...]
    parts: dict[str, float]
    refused: dict[Path, str]

    @property
    def target(self) -> str:
        """Line of a calibration file."""
        value, error = self.angle_of_repose.value, self.angle_of_repose.standard_error
        return (
            f'targets.angle_of_repose = {{ value = "{value:.2f} deg", '
            f'uncertainty = "{error:.2f} deg" }}'
        )

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return a table of the pictures, what is refused, and the result."""
        rows = tuple(
            (
                str(found.picture.path.name),
                str(number + 1),
                f"{found.angle:.2f} ± {found.uncertainty:.2f}",
                f"{found.view.left.angle:.1f}" if found.view.left else "–",
                f"{found.view.right.angle:.1f}" if found.view.right else "–",
                f"{found.elevation:.1f} ± {found.elevation_error:.1f}",
                found.seen_by,
            )
            for number, heap in enumerate(self.heaps)
            for found in heap
        )
        headings = ("picture", "heap", "angle, °", "left, °", "right, °", "camera above, °", "seen")
        table = TextTable(headings, rows)
        lines: list[str | TextTable] = [table]
        lines += [messages.REFUSED(path=path, reason=why) for path, why in self.refused.items()]
        lines.append(f"angle of repose: {with_sources(self.angle_of_repose, self.parts)}")
        if len(self.heaps) == 1:
            lines.append(messages.ONE_HEAP())
        return (*lines, self.target)


@overload
def photo(
    pictures: PathLike | Sequence[PathLike | Sequence[PathLike]],
    test: Heaps = ...,
    *,
    diameter: str | float | None = ...,
    plate: str | float | None = ...,
    elevation: str | float | None = ...,
    points: Sequence[tuple[float, float]] | None = ...,
    rectangle: tuple[str | float, str | float] | None = ...,
    overlays: PathLike | None = ...,
) -> PhotographedHeaps: ...


@overload
def photo(
    pictures: PathLike | Sequence[PathLike | Sequence[PathLike]],
    test: Literal["draw_down"],
    *,
    diameter: str | float | None = ...,
    box: str | float | None = ...,
    overlays: PathLike | None = ...,
) -> PhotographedDrawDowns: ...


@overload
def photo(
    pictures: PathLike | Sequence[PathLike | Sequence[PathLike]],
    test: Literal["slope"],
    *,
    level: str | float | None = ...,
    reference: Points | None = ...,
    overlays: PathLike | None = ...,
) -> PhotographedSlopes: ...


@overload
def photo(
    pictures: PathLike | Sequence[PathLike | Sequence[PathLike]],
    test: Literal["drum"],
    *,
    drum: str | float | None = ...,
    distance: str | float | None = ...,
    length: str | float | None = ...,
    level: str | float | None = ...,
    overlays: PathLike | None = ...,
) -> PhotographedDrum: ...


def photo(
    pictures: PathLike | Sequence[PathLike | Sequence[PathLike]],
    test: Photographed = "heap",
    *,
    diameter: str | float | None = None,
    plate: str | float | None = None,
    elevation: str | float | None = None,
    box: str | float | None = None,
    drum: str | float | None = None,
    distance: str | float | None = None,
    length: str | float | None = None,
    level: str | float | None = None,
    points: Sequence[tuple[float, float]] | None = None,
    rectangle: tuple[str | float, str | float] | None = None,
    reference: Points | None = None,
    overlays: PathLike | None = None,
) -> PhotographedHeaps | PhotographedDrawDowns | PhotographedDrum | PhotographedSlopes:
    """Measure angles on photographs and videos, by the code that measures simulated tests.

    What was drawn on a picture by hand (``grainfit photo --edit PICTURE``) is taken from the file
    beside it.

    Parameters
    ----------
    pictures : path, or sequence of these and of sequences
        JPEG, HEIC, PNG, BMP or TIFF. Each picture shows a heap of its own; those of a folder or of
        a sequence within the sequence show one heap. Of a drum: videos, or at least five stills. Of
        a slope or a draw-down each picture is a repeat.
    test : {"heap", "funnel", "draw_down", "drum", "slope"}
        What is photographed; heaps of both kinds are measured alike. A slope is an inclined plane
        or bed.
    diameter : str or float, optional
        Of the particles, such as ``"3 mm"``, or in m; by the roughness of the outline if not given.
    plate : str or float, optional
        Diameter of the round plate below the heap: the known length.
    elevation : str or float, optional
        Of the camera above the horizontal, such as ``"5 deg"``, or in degrees; by the edge of the
        plate or by the foot of the heap if not given.
    box : str or float, optional
        Inner width of the box of a draw-down: with `diameter`, how large the particles appear.
    drum : str or float, optional
        Inner diameter of the drum; alone, the angles do not need it.
    distance, length : str or float, optional
        Of the camera before the front of the drum, and of the drum along its axis: with the
        diameter they tell how perspective flattens the bed.
    level : str or float, optional
        Standard uncertainty of how level the camera before a drum or a slope is; 0.5 degrees if
        neither the marker sheet, a reference line, nor a drum that turns the other way tells it.
    points : sequence of four pairs of float, optional
        Corners of a level rectangle in the picture, in any order: columns and rows, pixels. They
        tell the elevation and the roll where there is no marker sheet. For one picture.
    rectangle : pair of str or float, optional
        Sides of that rectangle, such as ``("297 mm", "210 mm")``, or in m: the known length.
    reference : pair of pairs of float, optional
        Two points of a level line in a picture of a slope: columns and rows, pixels.
    overlays : path, optional
        Folder for a copy of every picture with what was found drawn on it.

    Returns
    -------
    PhotographedHeaps, PhotographedDrawDowns, PhotographedDrum or PhotographedSlopes
        Mean and standard uncertainty, and what was found on each picture.

    Raises
    ------
    InputError
        A picture cannot be read, or the extra ``photos`` is not installed.
    NotMeasurableError
        No picture can be measured, and why.
    """
    opencv()
    if test not in get_args(Photographed):
        raise InputError(messages.OTHER_TEST.fault("test", test=test))
    of_heap = {
        "diameter": diameter,
        "plate": plate,
        "elevation": elevation,
        "points": points,
        "rectangle": rectangle,
    }
    of_drum = {"drum": drum, "distance": distance, "length": length}
    folder = None if overlays is None else Path(overlays)
    angle = _number("level", level, "deg")
    if test == "drum":
        _require_none({**of_heap, "reference": reference}, messages.NOT_OF_DRUM)
        size = drum_size(drum, distance, length)
        return photo_drum(_groups(pictures), size, angle, folder)
    if test == "draw_down":
        others = {**of_heap, **of_drum, "level": level, "reference": reference, "diameter": None}
        _require_none(others, messages.NOT_OF_DRAW_DOWN)
        paths = [path for group in _groups(pictures) for path in group]
        return photo_draw_downs(paths, _ratio(box, diameter), folder)
    _require_none({"box": box}, messages.BOX_ONLY)
    if test == "slope":
        _require_none({**of_heap, **of_drum}, messages.NOT_OF_SLOPE)
        paths = [path for group in _groups(pictures) for path in group]
        if reference is not None and len(paths) > 1:
            raise InputError(messages.ONE_PICTURE.fault("reference"))
        return photo_slopes(paths, reference, angle, folder)
    _require_none({**of_drum, "level": level}, messages.DRUM_ONLY)
    _require_none({"reference": reference}, messages.SLOPE_ONLY)
    known = known_of(diameter, plate, elevation, rectangle)
    return _photo_heaps(pictures, known, points, overlays)


def _ratio(box: str | float | None, diameter: str | float | None) -> float | None:
    """Return the width of a box in particle diameters; None without both."""
    width, particle = _number("box", box, "m"), _number("diameter", diameter, "m")
    if width is None and particle is None:
        return None
    if width is None or particle is None:
        raise InputError(messages.BOX_AND_DIAMETER.fault("diameter" if width is None else "box"))
    return width / particle


def drum_size(
    drum: str | float | None, distance: str | float | None, length: str | float | None
) -> DrumSize | None:
    """Return the lengths of a drum, given as `photo` takes them, m; None without any.

    Raises
    ------
    InputError
        One is impossible, or of no use without the others.
    """
    radius = None if drum is None else _number("drum", drum, "m")
    for key, given in (("distance", distance), ("length", length)):
        if given is not None and None in (drum, distance, length):
            raise InputError(messages.WHOLE_DRUM.fault(key))
    if radius is None:
        return None
    return DrumSize(radius / 2, _number("distance", distance, "m"), _number("length", length, "m"))


def _require_none(options: Mapping[str, object], said: Message) -> None:
    for key, value in options.items():
        if value is not None:
            raise InputError(said.fault(key))


def _photo_heaps(
    pictures: PathLike | Sequence[PathLike | Sequence[PathLike]],
    known: dict[str, Any],
    points: Sequence[tuple[float, float]] | None,
    overlays: PathLike | None,
) -> PhotographedHeaps:
    groups = _groups(pictures)
    if points is not None and sum(map(len, groups)) > 1:
        raise InputError(messages.ONE_PICTURE.fault("points"))
    measured, refused = measure_each(
        [path for group in groups for path in group],
        lambda one: measure_heap(one if points is None else with_points(one, points), **known),
        draw_overlay,
        None if overlays is None else Path(overlays),
    )
    found = iter(measured)
    heaps = [tuple(next(found) for path in group if path not in refused) for group in groups]
    heaps = [heap for heap in heaps if heap]
    response, parts = mean_of_heaps(heaps)
    return PhotographedHeaps(response, tuple(heaps), parts, refused)


def with_points(picture: Picture, points: Sequence[tuple[float, float]]) -> Picture:
    """Return a picture with the corners of a rectangle, pixels of its file.

    Raises
    ------
    InputError
        They are not four places.
    """
    try:
        given = ByHand.from_plain({"corners": [list(point) for point in points]})
    except (ValueError, TypeError):
        raise InputError(messages.NO_POINTS.fault("points", given=points)) from None
    corners = given.scaled(picture.reduced).corners
    return replace(picture, by_hand=replace(picture.by_hand, corners=corners))


def known_of(
    diameter: str | float | None = None,
    plate: str | float | None = None,
    elevation: str | float | None = None,
    rectangle: Sequence[str | float] | None = None,
) -> dict[str, Any]:
    """Return what is known of a picture as `measure_heap` takes it, in m and degrees.

    Raises
    ------
    InputError
        A value is impossible, or of no use.
    """
    known = {
        "elevation": _number("elevation", elevation, "deg"),
        "plate_diameter": _number("plate", plate, "m"),
        "diameter": _number("diameter", diameter, "m"),
    }
    sides = None if rectangle is None else _sides(rectangle)
    if known["diameter"] is not None and known["plate_diameter"] is None and sides is None:
        raise InputError(messages.NO_LENGTH.fault("diameter"))
    return {**known, "rectangle": sides}


def _sides(given: Sequence[str | float]) -> tuple[float, float]:
    if isinstance(given, str) or len(given) != 2:
        raise InputError(messages.NO_SIDES.fault("rectangle", given=given))
    first, second = (_number("rectangle", one, "m") for one in given)
    assert first is not None
    assert second is not None
    return first, second


def _number(key: str, given: str | float | None, unit: str) -> float | None:
    if given is None:
        return None
    try:
        value = to_unit(given, unit) if isinstance(given, str) else float(given)
    except UnitError as error:
        raise InputError(Fault(key, str(error))) from None
    if not (math.isfinite(value) and (value > 0 or (unit == "deg" and value == 0))):
        raise InputError(messages.IMPOSSIBLE.fault(key, given=given))
    return value


def _groups(pictures: PathLike | Sequence[PathLike | Sequence[PathLike]]) -> list[list[Path]]:
    """Return the pictures of each heap."""
    given = [pictures] if isinstance(pictures, str | Path) else list(pictures)
    if not given:
        raise InputError(messages.NONE_GIVEN.fault("pictures"))
    groups = []
    for one in given:
        if not isinstance(one, str | Path):
            groups.append([Path(path) for path in one])
        else:
            groups.append(pictures_in(Path(one)))
    _require_once([path for group in groups for path in group])
    return groups


def pictures_in(path: Path) -> list[Path]:
    """Return the pictures and videos of a folder; a file as it is."""
    if not path.is_dir():
        return [path]
    found = sorted(one for one in path.iterdir() if is_picture(one) or is_video(one))
    if not found:
        raise InputError(messages.NO_PICTURES.fault("pictures", folder=path))
    return found


def _require_once(paths: Sequence[Path]) -> None:
    """Raise `InputError` for a picture that is there twice: it would count as two heaps."""
    seen: dict[str, Path] = {}
    for path in paths:
        # What cannot be read has no hash, and is named where it is measured.
        content = hash_of(path)
        if content and content in seen:
            same = {"file": path, "other": seen[content]}
            raise InputError(messages.SAME_PICTURE.fault("pictures", **same))
        seen[content] = path


class MeasuredPicture(Protocol):
    """The heap in one picture, as far as the mean of several needs it."""

    @property
    def angle(self) -> float:
        """Mean inclination of its flanks, degrees."""

    @property
    def flanks(self) -> tuple[float, ...]:
        """Inclinations of its flanks, degrees."""

    @property
    def parts(self) -> Mapping[str, float]:
        """Standard uncertainties by their source, degrees."""


def mean_of_heaps(
    heaps: Sequence[Sequence[MeasuredPicture]],
) -> tuple[Response, dict[str, float]]:
    """Return the mean of heaps, and its standard uncertainties: flanks, heaps and pictures.

    Parameters
    ----------
    heaps : sequence of sequence of MeasuredPicture
        Pictures of each heap.
    """
    means = [float(np.mean([found.angle for found in heap])) for heap in heaps]
    square, count = _COUNTS_AS * _FLANKS**2, float(_COUNTS_AS)
    for heap in heaps:
        flanks = [angle for found in heap for angle in found.flanks]
        square += float(np.sum((np.array(flanks) - np.mean(flanks)) ** 2))
        count += len(flanks) - 1
    flank = math.sqrt(square / count)
    shown = [min(2 * len(heap), _INDEPENDENT_FLANKS) for heap in heaps]
    of_flanks = flank * math.sqrt(sum(1 / n for n in shown)) / len(heaps)
    parts = {}
    if len(heaps) > 1:
        of_heaps = float(np.std(means, ddof=1)) / math.sqrt(len(heaps))
        parts["from heap to heap"] = max(of_heaps, of_flanks)
    else:
        parts["from flank to flank"] = of_flanks
    # What is wrong in one picture is wrong alike in others of the same camera and light.
    everything = [found for heap in heaps for found in heap]
    for name in sorted({name for found in everything for name in found.parts}):
        squares = [found.parts.get(name, 0.0) ** 2 for found in everything]
        parts[name] = math.sqrt(float(np.mean(squares)))
    error = math.sqrt(sum(part**2 for part in parts.values()))
    return Response(float(np.mean(means)), error), parts
