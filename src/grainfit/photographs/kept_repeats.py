"""Draw-downs and slopes that are measured once: what was found is kept with their hashes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.photographs.draw_down_photo import photo_draw_downs
from grainfit.photographs.kept import version_of_code
from grainfit.photographs.kept_folder import kept_once
from grainfit.photographs.slope_photo import photo_slopes

#: Name of the inclination of a slope among the angles.
SLOPE = "slope"


@dataclass(frozen=True)
class KeptRepeats:
    """What is kept of pictures of one test, each of which is a repeat.

    Parameters
    ----------
    name : str
        Of its folder.
    version : str
        Of the code that measured it.
    angles : dict
        Means with their standard uncertainties, degrees; empty if nothing could be measured.
    parts : dict
        Standard uncertainties of each by their source, degrees.
    pictures : dict
        Angles of each picture, degrees, by the hash of the file.
    refused : dict
        Why others were not measured, or why one of their angles was not, by the hash of the file.
    """

    name: str
    version: str
    angles: Mapping[str, tuple[float, float]]
    parts: Mapping[str, Mapping[str, float]]
    pictures: Mapping[str, Mapping[str, float]]
    refused: Mapping[str, str]


def draw_downs_once(
    hashes: Mapping[Path, str], folder: Path, diameters: float | None, *, keep_version: bool = False
) -> KeptRepeats:
    """Return what is on pictures of draw-downs: as it was kept, or else measured now, and kept.

    Parameters
    ----------
    hashes : mapping of Path to str
        The pictures with their SHA-256.
    folder : Path
        Where what was found is kept, with the overlays.
    diameters : float, optional
        Inner width of the box in particle diameters.
    keep_version : bool
        Take what another version of the code has measured, too: a calibration rests on it.

    Raises
    ------
    InputError
        A picture cannot be read.
    OSError
        What was found cannot be written.
    """

    def measured(overlays: Path) -> _Measured:
        found = photo_draw_downs(list(hashes), diameters, overlays)
        unseen = {one.picture.path: one.no_wedges for one in found.pictures if one.no_wedges}
        pictures = {one.picture.path: one.angles for one in found.pictures}
        return found.responses, found.parts, pictures, {**unseen, **found.refused}

    return _once(hashes, folder, ["draw_down", diameters], measured, keep_version)


def slopes_once(
    hashes: Mapping[Path, str], folder: Path, level: float | None, *, keep_version: bool = False
) -> KeptRepeats:
    """Return what is on pictures of slopes: as it was kept, or else measured now, and kept.

    Parameters
    ----------
    hashes : mapping of Path to str
        The pictures with their SHA-256.
    folder : Path
        Where what was found is kept, with the overlays.
    level : float, optional
        Standard uncertainty of how level the camera is, degrees.
    keep_version : bool
        Take what another version of the code has measured, too: a calibration rests on it.

    Raises
    ------
    InputError
        A picture cannot be read.
    OSError
        What was found cannot be written.
    """

    def measured(overlays: Path) -> _Measured:
        found = photo_slopes(list(hashes), None, level, overlays)
        pictures = {one.picture.path: {SLOPE: one.angle} for one in found.slopes}
        return {SLOPE: found.angle}, {SLOPE: found.parts}, pictures, found.refused

    return _once(hashes, folder, [SLOPE, level], measured, keep_version)


_Measured = tuple[
    Mapping[str, Response],
    Mapping[str, Mapping[str, float]],
    Mapping[Path, Mapping[str, float]],
    Mapping[Path, str],
]


def _once(
    hashes: Mapping[Path, str],
    folder: Path,
    known: Sequence[object],
    measure: Callable[[Path], _Measured],
    keep_version: bool,
) -> KeptRepeats:
    def measured(name: str) -> KeptRepeats:
        (folder / name).mkdir(parents=True, exist_ok=True)
        try:
            angles, parts, pictures, refused = measure(folder / name)
        except NotMeasurableError as error:
            return KeptRepeats(name, version_of_code(), {}, {}, {}, {"": str(error)})
        return KeptRepeats(
            name,
            version_of_code(),
            {name: (found.value, found.standard_error) for name, found in angles.items()},
            parts,
            {hashes[path]: found for path, found in pictures.items()},
            {hashes[path]: why for path, why in refused.items()},
        )

    stem, what = next(iter(hashes)).stem, [*hashes.values(), *known]
    return kept_once(folder, stem, what, KeptRepeats, measured, keep_version=keep_version)
