"""Pictures that are measured once: what was found on each is kept with the hash of its file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grainfit.arrays import Array
from grainfit.errors import NotMeasurableError
from grainfit.files import in_place_of, write_atomically
from grainfit.measurement.heap_size import averaged_outline
from grainfit.photographs import messages
from grainfit.photographs.by_hand import read_by_hand
from grainfit.photographs.heap import HeapInPicture, measure_heap
from grainfit.photographs.overlay import draw_overlay
from grainfit.photographs.pictures import opencv, read_picture
from grainfit.plain_data import read_plain

#: Folder of what is kept, in a work folder.
FOLDER = "photographs"
#: The code that decides what is measured on a picture, by its place in the package.
_CODE = (
    "photographs",
    "measurement/angle_of_repose.py",
    "measurement/silhouette.py",
    "measurement/heap_size.py",
    "measurement/dynamic_angles.py",
    "measurement/avalanches.py",
)
#: Points of an outline for each particle diameter; width of a kept copy, pixels.
_POINTS_PER_DIAMETER, COPY_WIDTH = 4, 720
#: What a kept copy shows beside the heap and above it, relative to its half width and its height.
_BESIDE, _ABOVE, _BELOW = 1.25, 1.3, 0.2


@dataclass(frozen=True)
class KnownOfPicture:
    """What is known of a picture before it is measured.

    Parameters
    ----------
    elevation : float, optional
        Of the camera above the horizontal, degrees.
    plate_diameter, diameter : float, optional
        Of the plate and of the particles, m.
    marker : bool
        Whether the marker sheet must be seen.
    """

    elevation: float | None = None
    plate_diameter: float | None = None
    diameter: float | None = None
    marker: bool = False


@dataclass(frozen=True)
class KeptPicture:
    """What is kept of one picture, or of a series. Lengths are in pixels of its working size.

    Parameters
    ----------
    name : str
        Of its files in the folder, without their endings.
    sha256 : str
        Hash of the original.
    version : str
        Of the code that measured it.
    refused : str
        Why it was not measured; empty if it was.
    angle : float
        Mean inclination of its flanks, degrees.
    parts : dict
        Standard uncertainties of the angle by their source, degrees.
    flanks : tuple of float
        Inclinations of the flanks, degrees.
    elevation, elevation_error : float
        Of the camera, degrees.
    seen_by : str
        What the elevation follows from.
    scale : float or None
        Length of a pixel, m; None without a known length.
    diameter, ground : float
        Particle diameter, and height above which the outline is that of the flanks.
    outline : tuple of tuple of float
        Horizontal distances from the axis, and heights of the averaged outline above the plate.
    shown : tuple of float
        Left, right, lower and upper end of the kept copy, which is upright, as from the side.
    drum_radius : float
        Of a drum about the origin, in whose middle distances and heights are zero; 0 of heaps.
    is_mirrored : bool
        Whether outline and copy are mirrored: the bed of a drum rises to the right in them.
    lines : tuple of tuple of float
        Lines at the angles in a drum: distances and heights of both ends.
    angles : dict
        Angles that all pictures of a drum tell together, with their standard uncertainties.
    frames : int
        Frames or stills that were measured together; the first one is shown.
    file : str
        The picture or the video, as the calibration file names it.
    """

    name: str
    sha256: str
    version: str
    refused: str = ""
    angle: float = 0.0
    parts: Mapping[str, float] = field(default_factory=dict)
    flanks: tuple[float, ...] = ()
    elevation: float = 0.0
    elevation_error: float = 0.0
    seen_by: str = ""
    scale: float | None = None
    diameter: float = 0.0
    ground: float = 0.0
    outline: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    shown: tuple[float, ...] = ()
    drum_radius: float = 0.0
    is_mirrored: bool = False
    lines: tuple[tuple[float, float, float, float], ...] = ()
    angles: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    frames: int = 1
    file: str = ""

    @property
    def uncertainty(self) -> float:
        """Standard uncertainty of the angle of these flanks, degrees."""
        return float(np.sqrt(sum(part**2 for part in self.parts.values())))

    @classmethod
    def from_plain(cls, data: Any) -> KeptPicture:
        """Return the picture of plain data; raise ValueError if they are damaged."""
        found: KeptPicture = read_plain(cls, data)
        if not (found.refused or found.outline[0]):
            raise ValueError("it is neither measured nor refused")
        return found


def measure_once(
    path: Path, known: KnownOfPicture, folder: Path, *, keep_version: bool = False
) -> KeptPicture:
    """Return what is on a picture: as it was kept, or else measured now, and kept.

    Parameters
    ----------
    path : Path
        The picture.
    known : KnownOfPicture
        What is known of it.
    folder : Path
        Where what was found is kept, with an overlay and an upright copy.
    keep_version : bool
        Take what another version of the code has measured, too: a calibration rests on it.

    Raises
    ------
    InputError
        It cannot be read.
    OSError
        What was found cannot be written.
    """
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    # With what is drawn on it by hand, a picture is another one.
    drawn = read_by_hand(path).to_plain()
    what = [digest, asdict(known), *([drawn] if drawn else [])]
    key = hashlib.sha256(json.dumps(what).encode()).hexdigest()[:12]
    name = f"{path.stem}_{key}"
    kept = _read(folder / f"{name}.json", digest)
    if kept is not None and (keep_version or kept.version == version_of_code()):
        return kept
    picture = read_picture(path)
    found: HeapInPicture | str
    try:
        found = measure_heap(picture, known.elevation, known.plate_diameter, known.diameter)
        if known.marker and not found.seen_by.startswith("by the marker sheet"):
            found = messages.NO_MARKER()
    except NotMeasurableError as error:
        found = str(error)
    folder.mkdir(parents=True, exist_ok=True)
    draw_overlay(folder, replace(picture, path=Path(f"{name}.png")), found)
    kept = KeptPicture(name, digest, version_of_code())
    kept = replace(kept, refused=found) if isinstance(found, str) else _keep(kept, found, folder)
    write_atomically(folder / f"{name}.json", json.dumps(asdict(kept)))
    return kept


def _read(path: Path, digest: str) -> KeptPicture | None:
    """Return what was kept; None if there is nothing, or if it is damaged."""
    try:
        found = KeptPicture.from_plain(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return None
    return found if found.sha256 == digest else None


@cache
def version_of_code() -> str:
    """Return the hash of the code that decides what is measured on a picture."""
    package = Path(str(files("grainfit")))
    digest = hashlib.sha256(opencv().__version__.encode())
    for part in _CODE:
        place = package / part
        for path in sorted(place.glob("*.py")) if place.is_dir() else [place]:
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _keep(kept: KeptPicture, found: HeapInPicture, folder: Path) -> KeptPicture:
    """Add what was measured, and write the upright copy."""
    across = found.silhouette.columns
    silhouette, low = found.silhouette, 0.0
    if found.height is not None and found.scale:
        # By the plane of the plate: particles at the foot are half hidden in their shadows.
        low = found.height / found.scale - float(np.nanmax(silhouette.outline()))
        silhouette = replace(silhouette, bottom=silhouette.bottom + low)
    heights = averaged_outline(silhouette, found.diameter)
    columns = found.diameter / silhouette.pixel_size
    every = max(1, int(columns / _POINTS_PER_DIAMETER))
    heap = np.flatnonzero(heights > 0)[::every]
    width, top = _BESIDE * float(np.abs(across[heap]).max()), float(heights.max())
    shown = (-width, width, -_BELOW * top, _ABOVE * top)
    write_copy(_upright(found, shown, low), folder, kept.name)
    return replace(
        kept,
        angle=found.angle,
        parts=found.parts,
        flanks=found.flanks,
        elevation=found.elevation,
        elevation_error=found.elevation_error,
        seen_by=found.seen_by,
        scale=found.scale,
        diameter=found.diameter,
        ground=found.ground + low,
        outline=(rounded(across[heap]), rounded(heights[heap])),
        shown=rounded(np.array(shown)),
    )


def write_copy(colours: Any, folder: Path, name: str) -> None:
    """Write an upright copy of a picture."""
    with in_place_of(folder / f"{name}.jpg") as place:
        Image.fromarray(colours).save(place, "JPEG", quality=85)


def rounded(values: Array) -> tuple[float, ...]:
    """Return values as they are kept."""
    return tuple(np.round(values, 2).tolist())


def _upright(found: HeapInPicture, shown: tuple[float, float, float, float], low: float) -> Any:
    """Return a part of the picture as from the side, heights stretched as the outline was."""
    left, right, lower, upper = shown
    rows = max(1, round(COPY_WIDTH * (upper - lower) / (right - left)))
    across, heights = np.meshgrid(
        np.linspace(left, right, COPY_WIDTH), np.linspace(upper - low, lower - low, rows)
    )
    places = found.back(np.column_stack([across.ravel(), heights.ravel()])).astype(np.float32)
    columns, lines = places.T.reshape(2, rows, COPY_WIDTH)
    cv2 = opencv()
    border = cv2.BORDER_REPLICATE
    return cv2.remap(found.picture.colours, columns, lines, cv2.INTER_LINEAR, borderMode=border)
