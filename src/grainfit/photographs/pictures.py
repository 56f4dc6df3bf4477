"""Pictures of a camera or a telephone: read, turned upright, with their focal length."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageOps, UnidentifiedImageError

from grainfit.errors import InputError
from grainfit.extras import import_extra
from grainfit.photographs import messages
from grainfit.photographs.by_hand import NOTHING_DRAWN, ByHand, read_by_hand

#: Formats, by the ends of their names.
SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".heic", ".heif")
#: A picture is worked on in this length of its longer side, pixels.
WORKING_LENGTH = 1600
#: Diagonal of the film for which equivalent focal lengths are stated, mm.
_FILM_DIAGONAL = math.hypot(36.0, 24.0)
#: Brightest value of 8 bits.
_WHITE = 255
#: Equivalent focal lengths of cameras, mm.
_FOCAL_LENGTHS = (8.0, 2000.0)


@dataclass(frozen=True)
class Picture:
    """A picture in its working size.

    Parameters
    ----------
    path : Path
        Its file.
    colours : ndarray of uint8 of shape (rows, columns, 3)
        Red, green and blue.
    focal : float or None
        Focal length, pixels; None where the file does not tell it.
    by_hand : ByHand
        What was drawn on it, in this size.
    reduced : float
        Its size over that of the file.
    """

    path: Path
    colours: NDArray[np.uint8]
    focal: float | None
    by_hand: ByHand = NOTHING_DRAWN
    reduced: float = 1.0

    @property
    def middle(self) -> tuple[float, float]:
        """Where the optical axis is: column and row."""
        rows, columns = self.colours.shape[:2]
        return ((columns - 1) / 2, (rows - 1) / 2)


def opencv() -> Any:
    """Return OpenCV, which the extra ``photos`` installs."""
    return import_extra("cv2", "photos", "a measurement on photographs")


def is_picture(path: Path) -> bool:
    """Return whether a file is a picture, by the end of its name."""
    return path.suffix.lower() in SUFFIXES


def read_picture(path: Path) -> Picture:
    """Read a picture, upright as its EXIF data say, and reduce it to the working size.

    What was drawn on it by hand is in a file beside it.

    Raises
    ------
    InputError
        It cannot be read, or needs the extra ``photos``; what was drawn is of another picture.
    """
    cv2 = opencv()
    if path.suffix.lower() in (".heic", ".heif"):
        import_extra("pillow_heif", "photos", "a HEIC picture").register_heif_opener()
    try:
        with Image.open(path) as image:
            focal = _focal_length(image)
            upright = _eight_bits(ImageOps.exif_transpose(image)).convert("RGB")
    except FileNotFoundError:
        raise InputError(messages.NO_FILE.fault("", path=path)) from None
    except (UnidentifiedImageError, OSError, ValueError, Image.DecompressionBombError) as error:
        raise InputError(messages.UNREADABLE.fault("", path=path, reason=error)) from error
    colours = np.asarray(upright)
    rows, columns = colours.shape[:2]
    factor = min(WORKING_LENGTH / max(rows, columns), 1.0)
    if factor < 1:
        size = (round(columns * factor), round(rows * factor))
        colours = cv2.resize(colours, size, interpolation=cv2.INTER_AREA)
    if focal is not None:
        focal *= math.hypot(*colours.shape[:2]) / _FILM_DIAGONAL
    drawn = read_by_hand(path).scaled(factor)
    return Picture(path, colours, focal, drawn, factor)


def _eight_bits(image: Image.Image) -> Image.Image:
    """Return a picture of 16 bits, of cameras in laboratories, with the 8 that Pillow converts."""
    if not image.mode.startswith("I"):
        return image
    values = np.asarray(image)
    return Image.fromarray((values // 257 if values.max() > _WHITE else values).astype(np.uint8))


def _focal_length(image: Image.Image) -> float | None:
    """Return the focal length that EXIF data state for film of 35 mm, mm."""
    tags = image.getexif().get_ifd(ExifTags.IFD.Exif)
    try:
        found = float(tags.get(ExifTags.Base.FocalLengthIn35mmFilm, 0))
    except (TypeError, ValueError):
        return None
    return found if _FOCAL_LENGTHS[0] <= found <= _FOCAL_LENGTHS[1] else None
