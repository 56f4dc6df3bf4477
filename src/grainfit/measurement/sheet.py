"""Sheets of pictures: panels below a title, fonts, colours, fitted flanks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from PIL.PngImagePlugin import PngInfo

from grainfit.measurement.angle_of_repose import Flank

#: Everything is drawn this much larger and then reduced, for smooth edges.
OVERSAMPLING = 2
_MARGIN = 24 * OVERSAMPLING
_GAP = 44 * OVERSAMPLING
_TITLE_SIZE = 30 * OVERSAMPLING
TEXT_SIZE = 17 * OVERSAMPLING
_COLUMNS = 2

PAPER = "#ffffff"
INK = "#1f2933"
QUIET_INK = "#616e7c"
# Vermilion: distinct from grey and all other colours in any kind of colour blindness
# (Okabe & Ito, Color Universal Design).
FLANK = "#d55e00"
#: From low to high, lighter and lighter (after cividis, Nuñez, Anderton & Renslow 2018).
_HEIGHTS = np.array(
    [[53, 85, 143], [93, 115, 150], [139, 141, 140], [194, 171, 112], [254, 232, 56]], dtype=float
)


def height_colour(share: float) -> NDArray[np.float64]:
    """Return the colour of a height, 0 to 255, by its share of the largest height."""
    place = min(max(share, 0.0), 1.0) * (len(_HEIGHTS) - 1)
    low = min(int(place), len(_HEIGHTS) - 2)
    found: NDArray[np.float64] = _HEIGHTS[low] + (place - low) * (_HEIGHTS[low + 1] - _HEIGHTS[low])
    return found


def draw_flank(
    draw: ImageDraw.ImageDraw,
    flank: Flank,
    start: tuple[float, float],
    end: tuple[float, float],
) -> None:
    """Draw a flank between its ends, the lower first, with its inclination beside it."""
    draw.line([start, end], fill=FLANK, width=3 * OVERSAMPLING)
    # Beside the middle of the line, on the outer and upper side, where the heap is not.
    outward = math.copysign(1.0, start[0] - end[0])
    middle = (start[0] + end[0]) / 2 + outward * TEXT_SIZE, (start[1] + end[1]) / 2 - TEXT_SIZE
    draw.text(
        middle,
        f"{flank.angle:.1f}°",
        fill=FLANK,
        font=font(TEXT_SIZE),
        anchor="ls" if outward > 0 else "rs",
    )


def sheet(title: str, subtitle: str, panels: list[Image.Image], panel_width: int) -> Image.Image:
    """Return a picture of panels below a title and a text that is wrapped, in its final size.

    Panels are oversampled, of one width, pixels; two are in a row.
    """
    columns = max(1, min(_COLUMNS, len(panels)))
    width = 2 * _MARGIN + columns * panel_width + (columns - 1) * _GAP
    lines = _wrapped(subtitle, width - 2 * _MARGIN)
    top = _MARGIN + round(1.5 * _TITLE_SIZE) + round(1.4 * TEXT_SIZE * len(lines)) + _MARGIN
    row_height = max((panel.height for panel in panels), default=0)
    rows = math.ceil(len(panels) / columns)
    page = Image.new("RGB", (width, top + rows * row_height + _MARGIN), PAPER)
    draw = ImageDraw.Draw(page)
    draw.text((_MARGIN, _MARGIN), title, fill=INK, font=font(_TITLE_SIZE))
    for number, line in enumerate(lines):
        place = (_MARGIN, _MARGIN + 1.5 * _TITLE_SIZE + 1.4 * TEXT_SIZE * number)
        draw.text(place, line, fill=QUIET_INK, font=font(TEXT_SIZE))
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        lowered = top + (row + 1) * row_height - panel.height
        page.paste(panel, (_MARGIN + column * (panel_width + _GAP), lowered))
    return page.reduce(OVERSAMPLING)


def _wrapped(text: str, width: float) -> list[str]:
    used = font(TEXT_SIZE)
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and used.getlength(longer) > width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def save_picture(picture: Image.Image, path: Path) -> None:
    """Write a PNG that says that grainfit made it: a command makes it again without a question."""
    about = PngInfo()
    about.add_text("Software", "grainfit")
    picture.save(path, "png", pnginfo=about)


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the font of all pictures in a size, pixels."""
    return ImageFont.load_default(size)
