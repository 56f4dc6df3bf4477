"""A photographed heap or drum and a simulated one at one scale, as data of drawings.

Both outlines are those that are measured: the averaged outline of the picture, and that which the
bulk test makes of the responses of a run. In drawings the axis is at x = 0; at y = 0 is the plate,
or the axis of a drum; heights are negative.
"""

from __future__ import annotations

import base64
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.view import CanBePhotographed, SeenOutline
from grainfit.evaluation import Measured, names_of_tests, scalars
from grainfit.files import read_within
from grainfit.formatting import number, plain, unit_for_people, with_unit
from grainfit.measurement.drawing import Drawing, simplified
from grainfit.photographs.kept import KeptPicture
from grainfit.photographs.kept_list import KeptPictures, kept_pictures
from grainfit.report.sections.particles.shown_runs import (
    ShownRun,
    first_readable,
    recreated,
    runs_to_show,
    shown_response,
    shown_runs,
    shown_target,
)
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Most pictures of a test that are shown.
_MOST_PICTURES = 12
#: Largest file of a copy.
_LARGEST_COPY = 2_000_000
_JPEG = b"\xff\xd8\xff"
#: Width of a drawing, in its units; largest deviation of a drawn outline in these.
_WIDTH, _TOLERANCE = 1000.0, 1.0
#: Room around the heap, relative to half of its width and to its height.
_BESIDE, _ABOVE, _BELOW = 1.12, 1.2, 0.15
#: Lengths of a scale bar, m, and its largest share of the drawing.
_BARS = [factor * 10.0**power for power in range(-5, 2) for factor in (1, 2, 5)]
_LONGEST_BAR = 0.25
#: Heaps whose sizes differ by less, relative, are drawn over each other at one scale.
_ALIKE = 0.1


@dataclass(frozen=True)
class Outline(SeenOutline):
    """Outline of a heap, or the surface in a drum, to be drawn."""

    @property
    def area(self) -> float:
        """Area below it, m²."""
        return float(np.trapezoid(self.heights, self.x))

    @property
    def half_width(self) -> float:
        """Largest distance from the axis at which there is a heap, or the drum."""
        if self.drum_radius:
            return self.drum_radius
        above = self.x[self.heights > 0]
        return float(np.abs(above).max()) if len(above) else 0.0

    def times(self, factor: float) -> Outline:
        """Return it enlarged."""
        return Outline(self.x * factor, self.heights * factor, self.drum_radius * factor)

    def distance(self, other: Outline) -> float:
        """Return the mean vertical distance of another outline where this one is, m."""
        # In a drum, where both surfaces are.
        outside = math.nan if self.drum_radius else 0.0
        heights = np.interp(self.x, other.x, other.heights, left=outside, right=outside)
        return float(np.nanmean(np.abs(self.heights - heights)))

    def path(self, unit: float) -> str:
        """Return an SVG path; a unit of the drawing is so many m."""
        heights = self.heights / unit
        kept = simplified(heights, _TOLERANCE)
        return "M" + " L".join(f"{self.x[i] / unit:.1f},{-heights[i]:.1f}" for i in kept)


@dataclass(frozen=True)
class Frame:
    """What a drawing shows.

    Parameters
    ----------
    unit : float
        Length of a unit, m.
    half_width, top, bottom : float
        Extents from axis and plate, in units.
    bar : float
        Length of the scale bar, m; 0 without one.
    """

    unit: float
    half_width: float
    top: float
    bottom: float
    bar: float = 0.0

    @property
    def bar_words(self) -> str:
        """Length of the scale bar, for people."""
        return f"{number(1000 * self.bar, 3)} mm" if self.bar < 1 else f"{number(self.bar, 3)} m"

    @classmethod
    def around(cls, outlines: Iterable[Outline], *, has_scale: bool) -> Frame:
        """Return the frame that shows these outlines."""
        given = list(outlines)
        half = _BESIDE * max(one.half_width for one in given)
        high = max(float(one.heights.max()) for one in given)
        unit = 2 * half / _WIDTH
        if given[0].drum_radius:
            return cls(unit, _WIDTH / 2, _WIDTH / 2, _WIDTH / 2)
        bars = [bar for bar in _BARS if bar <= 2 * half * _LONGEST_BAR]
        return cls(
            unit,
            _WIDTH / 2,
            _ABOVE * high / unit,
            _BELOW * high / unit,
            bars[-1] if has_scale and bars else 0.0,
        )


@dataclass(frozen=True)
class ComparedPicture:
    """A picture with its outline, and that of the simulated heap over it.

    Parameters
    ----------
    file, angle : str
        Its name, and the angle of its flanks with its standard uncertainty.
    heap : int
        Number of its heap.
    image : str
        Address of the kept copy; empty if that is gone.
    place : tuple of float
        Left, upper, width and height of the copy, units of the frame.
    frame : Frame
        What its drawing shows.
    measured, simulated : str
        SVG paths of the outlines; the simulated one is empty without a run.
    apart : str
        Mean distance of the outlines; empty where they are not at one scale.
    lines : sequence of tuple of float
        Both ends of lines at the angles in a drum.
    is_mirrored : bool
        Whether the picture is mirrored.
    frames : int
        Frames or stills that tell the outline; the first is shown.
    """

    file: str
    angle: str
    heap: int
    image: str
    place: tuple[float, float, float, float]
    frame: Frame
    measured: str
    simulated: str
    apart: str
    lines: Sequence[tuple[float, ...]] = ()
    is_mirrored: bool = False
    frames: int = 1


@dataclass(frozen=True)
class Comparison:
    """Photographs of one test beside its simulated heap, or drum.

    Parameters
    ----------
    title : str
        Name of the test; empty of a single one.
    results : sequence of str
        What the photographs tell: response, value and uncertainty.
    words, simulated : str
        Which run is shown, and its response; empty without one.
    run : str
        Its identity.
    chosen : ComparedPicture
        The picture whose angle is nearest to the mean, in the frame of both heaps.
    pictures : sequence of ComparedPicture
        All pictures, at most twelve.
    left_out : int
        Further ones.
    drawing : Drawing or None
        The simulated heap or bed; None if its particles are gone.
    outline : str
        SVG path of the outline of the simulated heap in the frame of both.
    has_scale : bool
        Whether the length of a pixel is known of the chosen picture.
    is_scaled : bool
        Whether outlines over each other are enlarged to the same area.
    relative_size : str
        Width of the simulated heap over that of the photographed one, where they differ.
    refused : sequence of (str, str)
        Pictures that were not measured, and why.
    folder : Path
        Where copies and overlays are.
    fitted : sequence of tuple of float
        Both ends of lines at the angles in the simulated drum.
    drum : str
        Diameter of the simulated drum; empty of a heap.
    drum_radius : float
        Of both drums, units of the drawing; 0 of a heap.
    angles : sequence of (str, str, str)
        Angles in a drum: name, photographed and simulated.
    changed, gone : sequence of str
        Originals that are others now, and that are not there any more.
    """

    title: str
    results: Sequence[str]
    words: str
    simulated: str
    run: str
    chosen: ComparedPicture
    pictures: Sequence[ComparedPicture]
    left_out: int
    drawing: Drawing | None
    outline: str
    has_scale: bool
    is_scaled: bool
    relative_size: str
    refused: Sequence[tuple[str, str]]
    folder: Path
    fitted: Sequence[tuple[float, ...]]
    drum: str
    drum_radius: float
    angles: Sequence[tuple[str, str, str]]
    changed: Sequence[str]
    gone: Sequence[str]


def compared(reading: SavedCalibration) -> list[Comparison]:
    """Return the photographs of every test beside its simulated heap; empty without any."""
    kept = kept_pictures(reading.folder)
    if kept is None:
        return []
    runs = shown_runs(reading.evaluations, reading.records, reading.folder)
    found = [_comparison(reading, kept, test, _runs_of(test, runs)) for test in _tests(kept)]
    return [one for one in found if one is not None]


def _tests(kept: KeptPictures) -> list[str]:
    """Return the names of the tests that pictures tell of; "" of a single test."""
    return list(dict.fromkeys(one.response.rpartition(".")[0] for one in kept.targets))


def _runs_of(test: str, runs: Mapping[str, list[ShownRun]]) -> list[ShownRun]:
    if not test and len(names_of_tests(runs)) == 1:
        return next(iter(runs.values()))
    return runs.get(test, [])


def _comparison(
    reading: SavedCalibration, kept: KeptPictures, test: str, runs: list[ShownRun]
) -> Comparison | None:
    targets = [one for one in kept.targets if one.response.rpartition(".")[0] == test]
    heaps: dict[str, tuple[int, KeptPicture]] = {}
    for target in targets:
        for heap, of_heap in enumerate(target.heaps, 1):
            heaps |= {one.name: (heap, one) for one in of_heap if one.outline[0]}
    if not heaps:
        return None
    photographed = list(heaps.values())
    mean = float(np.mean([one.angle for _, one in photographed]))
    chosen = min(photographed, key=lambda one: abs(one[1].angle - mean))
    simulated = _simulated(reading, runs)
    has_profile = any(one.response.rpartition(".")[2] == "profile" for one in targets)
    states = {
        file: kept.state_of(file, digest)
        for target in targets
        for file, digest in target.hashes.items()
    }
    drawn = _Drawn(kept, simulated.outline)
    ratio = float(np.mean([drawn.relative_size(one) for _, one in photographed]))
    drawn = replace(drawn, is_scaled=not has_profile and abs(ratio - 1) >= _ALIKE)
    shown = [chosen, *(one for one in photographed if one is not chosen)][:_MOST_PICTURES]
    shown.sort(key=lambda one: (one[0], one[1].file))
    pictures = [drawn.compared(heap, picture) for heap, picture in shown]
    main, radius = drawn.beside(*chosen), simulated.outline and simulated.outline.drum_radius
    return Comparison(
        title=plain(test),
        results=list(dict.fromkeys(_result(one.result) for one in targets)),
        words=simulated.words,
        simulated=simulated.value,
        run=simulated.run,
        chosen=main,
        pictures=pictures,
        left_out=len(photographed) - len(shown),
        drawing=simulated.drawing,
        outline="" if simulated.outline is None else simulated.outline.path(main.frame.unit),
        has_scale=chosen[1].scale is not None,
        is_scaled=drawn.is_scaled,
        relative_size="" if abs(ratio - 1) < _ALIKE else number(ratio, 2),
        refused=list(_refused(one.refused for one in targets)),
        folder=kept.folder,
        fitted=simulated.lines(main.frame.unit),
        drum=f"{number(2000 * radius, 3)} mm" if radius else "",
        drum_radius=_WIDTH / 2 / _BESIDE if chosen[1].drum_radius else 0.0,
        angles=list(_angles(chosen[1], simulated.responses)),
        changed=[plain(file) for file, state in states.items() if state == "changed"],
        gone=[plain(file) for file, state in states.items() if state == "gone"],
    )


def _angles(
    picture: KeptPicture, simulated: Mapping[str, Measured]
) -> Iterator[tuple[str, str, str]]:
    of_run = scalars(simulated)
    for name, found in picture.angles.items():
        run = of_run.get(name)
        yield (
            plain(name.replace("_", " ")),
            f"{_with_error(*found, 2)}°",
            f"{_with_error(run.value, run.standard_error, 2)}°" if run else "",
        )


def _with_error(value: float, error: float, digits: int = 1) -> str:
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def _result(result: str) -> str:
    """Return what pictures tell, without the parts of the uncertainty."""
    shown = re.sub(r" \([^)]*\)", "", result)
    return plain(shown.replace(" deg", "°").replace("_", " ")).removesuffix(".") + "."


def _refused(of_targets: Iterable[Sequence[KeptPicture]]) -> Iterator[tuple[str, str]]:
    found = {one.file: one.refused for pictures in of_targets for one in pictures}
    yield from ((plain(file), plain(reason)) for file, reason in found.items())


@dataclass(frozen=True)
class _Simulated:
    """The run that is shown."""

    words: str = ""
    value: str = ""
    run: str = ""
    outline: Outline | None = None
    drawing: Drawing | None = None
    responses: Mapping[str, Measured] = field(default_factory=dict)

    def lines(self, unit: float) -> list[tuple[float, ...]]:
        """Return the fitted lines; a unit of the drawing is so many m."""
        if self.drawing is None or not self.drawing.pixel_size:
            return []
        scale = self.drawing.pixel_size / unit
        return [
            tuple(scale * end for end in (line.x1, line.y1, line.x2, line.y2))
            for line in self.drawing.fitted
        ]


def _simulated(reading: SavedCalibration, runs: list[ShownRun]) -> _Simulated:
    first = next(filter(None, map(_test, runs)), None)
    having = [run for run in runs if first and first.seen_outline(run.record.responses)]
    if not having:
        return _Simulated()
    candidates, words = runs_to_show(reading, having, shown_target(reading, having))
    readable = first_readable(candidates)
    run = readable[0] if readable else candidates[0]
    return _Simulated(
        f"{words}: run {run.number}",
        f"{shown_response(having)} {_with_unit(reading, run)}",
        run.record.identity,
        _outline(run),
        readable[1].before_camera() if readable else None,
        run.record.responses,
    )


def _test(run: ShownRun) -> CanBePhotographed | None:
    test = recreated(run)
    return test if isinstance(test, CanBePhotographed) else None


def _outline(run: ShownRun) -> Outline | None:
    test = _test(run)
    seen = test and test.seen_outline(run.record.responses)
    return Outline(seen.x, seen.heights, seen.drum_radius) if seen else None


def _with_unit(reading: SavedCalibration, run: ShownRun) -> str:
    target = shown_target(reading, [run])
    return with_unit(number(run.value, 3), unit_for_people(target.unit if target else "deg"))


@dataclass(frozen=True)
class _Drawn:
    """Draws pictures over or beside one simulated heap."""

    kept: KeptPictures
    simulated: Outline | None
    #: Whether the simulated outline is scaled to the area of that of a picture that it is over.
    is_scaled: bool = False

    def compared(self, heap: int, picture: KeptPicture) -> ComparedPicture:
        """Return a picture with the simulated outline over it."""
        photographed, pixel = self._photographed(picture)
        over = self.simulated
        if over is not None and self.is_scaled:
            over = over.times(math.sqrt(photographed.area / over.area))
        outlines = [photographed] if over is None else [photographed, over]
        frame = Frame.around(outlines, has_scale=picture.scale is not None)
        apart = ""
        if over is not None and picture.scale is not None and over is self.simulated:
            apart = f"{number(1000 * photographed.distance(over), 2)} mm"
        elif over is not None and over.drum_radius:
            share = photographed.distance(over) / (2 * over.drum_radius)
            apart = f"{number(100 * share, 2)} % of the drum's diameter"
        return self._picture(heap, picture, frame, pixel, photographed, over, apart)

    def beside(self, heap: int, picture: KeptPicture) -> ComparedPicture:
        """Return a picture in a frame that shows the simulated heap as well."""
        photographed, pixel = self._photographed(picture)
        outlines = [photographed] if self.simulated is None else [photographed, self.simulated]
        frame = Frame.around(outlines, has_scale=picture.scale is not None)
        return self._picture(heap, picture, frame, pixel, photographed, self.simulated, "")

    def relative_size(self, picture: KeptPicture) -> float:
        """Return how many times as wide the simulated heap is, by the areas of both."""
        photographed, _ = self._photographed(picture)
        if self.simulated is None or picture.drum_radius:
            return 1.0
        return math.sqrt(self.simulated.area / photographed.area)

    def _photographed(self, picture: KeptPicture) -> tuple[Outline, float]:
        """Return the outline of a picture, and the length of a pixel, m.

        Without a known length it has the area of the simulated one; drums are of one size.
        """
        across, heights = (np.asarray(values) for values in picture.outline)
        outline = Outline(across, heights, picture.drum_radius)
        pixel = picture.scale
        if picture.drum_radius:
            pixel = (self.simulated.drum_radius if self.simulated else 1.0) / picture.drum_radius
        elif pixel is None:
            pixel = math.sqrt(self.simulated.area / outline.area) if self.simulated else 1.0
        return outline.times(pixel), pixel

    def _picture(
        self,
        heap: int,
        picture: KeptPicture,
        frame: Frame,
        pixel: float,
        photographed: Outline,
        over: Outline | None,
        apart: str,
    ) -> ComparedPicture:
        scale = pixel / frame.unit
        left, right, lower, upper = (edge * pixel / frame.unit for edge in picture.shown)
        return ComparedPicture(
            file=plain(picture.file),
            angle=f"{_with_error(picture.angle, picture.uncertainty)}°",
            heap=heap,
            image=_image(self.kept.copy_of(picture)),
            place=(left, -upper, right - left, upper - lower),
            frame=frame,
            measured=photographed.path(frame.unit),
            simulated="" if over is None else over.path(frame.unit),
            apart=apart,
            lines=[
                (scale * x1, -scale * y1, scale * x2, -scale * y2)
                for x1, y1, x2, y2 in picture.lines
            ],
            is_mirrored=picture.is_mirrored,
            frames=picture.frames,
        )


def _image(path: Path) -> str:
    """Return the address of a kept copy in a page; empty if it is gone or no picture."""
    try:
        content = read_within(path, _LARGEST_COPY)
    except OSError:
        return ""
    if not content.startswith(_JPEG):
        return ""
    return f"data:image/jpeg;base64,{base64.b64encode(content).decode('ascii')}"
