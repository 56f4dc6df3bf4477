"""Copies of photographs with what was found drawn on them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image, ImageDraw

from grainfit.arrays import Array
from grainfit.measurement.sheet import FLANK, font, save_picture
from grainfit.photographs.heap import HeapInPicture
from grainfit.photographs.pictures import Picture

OUTLINE, PLATE, _PAPER = "#56b4e9", "#f0e442", "#1f2933"
Found = TypeVar("Found")
#: Lengths of a scale bar, m.
_BARS = [factor * 10.0**power for power in range(-4, 1) for factor in (1, 2, 5)]


def draw_overlay(folder: Path, picture: Picture, found: HeapInPicture | str) -> Path:
    """Write a picture with outline, plate, flanks, scale and angle, as of `write_overlay`."""
    return write_overlay(folder, picture, found, _draw)


def write_overlay(
    folder: Path,
    picture: Picture,
    found: Found | str,
    draw: Callable[[ImageDraw.ImageDraw, Found, int], str],
) -> Path:
    """Write a PNG of a picture with what was found drawn on it, or with why nothing was measured.

    It has the name of the picture, with ``_measured`` or ``_refused``; its path is returned.

    Parameters
    ----------
    folder : Path
        Where it is written.
    picture : Picture
        The picture.
    found : object or str
        What was found, or why nothing was measured.
    draw : callable
        Draws what was found with lines of a width, and returns the text below the picture.
    """
    image = Image.fromarray(picture.colours)
    measured, refused = overlay_places(folder, picture.path)
    if isinstance(found, str):
        text, place = f"not measured: {found}", refused
    else:
        text = draw(ImageDraw.Draw(image), found, max(2, image.width // 400))
        place = measured
    return write_page(image, text, place)


def overlay_places(folder: Path, picture: Path) -> tuple[Path, Path]:
    """Return where the overlay of a picture is written: of a measured one, and of a refused one."""
    return folder / f"{picture.stem}_measured.png", folder / f"{picture.stem}_refused.png"


def write_page(image: Image.Image, text: str, path: Path) -> Path:
    """Write a PNG of a picture with a text below it; return its path."""
    size = max(14, image.width // 45)
    lines = _wrapped(ImageDraw.Draw(image), text, image.width - size, size)
    page = Image.new("RGB", (image.width, image.height + round(1.3 * size * len(lines)) + size))
    page.paste(_PAPER, (0, 0, *page.size))
    page.paste(image, (0, 0))
    draw = ImageDraw.Draw(page)
    for number, line in enumerate(lines):
        place = (size / 2, image.height + size / 2 + 1.3 * size * number)
        draw.text(place, line, fill="#ffffff", font=font(size))
    path.parent.mkdir(parents=True, exist_ok=True)
    save_picture(page, path)
    return path


def _draw(draw: ImageDraw.ImageDraw, found: HeapInPicture, width: int) -> str:
    size = max(14, draw.im.size[0] // 45)
    draw_line(draw, found.outline, OUTLINE, width, closed=True)
    left, right, ground = found.drawn
    if found.plate is not None:
        draw_line(draw, found.plate.edge, PLATE, width, closed=True)
    draw_line(draw, ground, PLATE, width)
    for flank, points, anchor in ((found.view.left, left, "rs"), (found.view.right, right, "ls")):
        if flank is None:
            continue
        draw_line(draw, points, FLANK, 2 * width)
        aside = -size if anchor == "rs" else size
        place = (float(points[:, 0].mean()) + aside, float(points[:, 1].mean()) - size)
        draw.text(
            place,
            f"{flank.angle:.1f}°",
            fill=FLANK,
            font=font(2 * size),
            anchor=anchor,
            stroke_width=2,
            stroke_fill="#ffffff",
        )
    if found.scale is not None:
        shown = draw.im.size[0] * found.scale / 5
        bar = max(length for length in _BARS if length <= max(shown, _BARS[0]))
        row = draw.im.size[1] - 1.5 * size
        points = np.array([[size, row], [size + bar / found.scale, row]])
        draw_line(draw, points, "#ffffff", 3 * width)
        draw.text(
            (size, row - size / 3),
            f"{1000 * bar:g} mm",
            fill="#ffffff",
            font=font(size),
            anchor="ls",
            stroke_width=2,
            stroke_fill=_PAPER,
        )
    return (
        f"{found.angle:.1f}° ± {found.uncertainty:.1f}°, camera {found.elevation:.1f}° above "
        f"({found.seen_by})"
    )


def draw_line(
    draw: ImageDraw.ImageDraw, points: Array, colour: str, width: int, *, closed: bool = False
) -> None:
    """Draw a line along points of a picture."""
    places = [(float(x), float(y)) for x, y in points]
    draw.line(places + places[:1] if closed else places, fill=colour, width=width)


def _wrapped(draw: ImageDraw.ImageDraw, text: str, width: float, size: int) -> list[str]:
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and draw.textlength(longer, font=font(size)) > width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines
