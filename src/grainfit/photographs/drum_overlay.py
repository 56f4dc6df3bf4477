"""Pictures of drums with what was found drawn on them."""

from __future__ import annotations

from pathlib import Path

from PIL import Image, ImageDraw

from grainfit.measurement.sheet import FLANK
from grainfit.photographs.drum import DrumSeries
from grainfit.photographs.overlay import OUTLINE, PLATE, draw_line, overlay_places, write_page
from grainfit.photographs.pictures import read_picture
from grainfit.photographs.videos import Video, is_video

#: Lines that are drawn.
_DRAWN = ("upper_angle", "lower_angle")


def draw_drum_overlay(folder: Path, found: DrumSeries) -> Path:
    """Write a PNG of a frame with the drum, the mean surface, and the lines fitted to it.

    It has the name of the video or of the first still, with ``_measured``; its path is returned.
    """
    image = Image.fromarray(found.shown)
    draw = ImageDraw.Draw(image)
    width = max(2, image.width // 400)
    draw_line(draw, found.circle.edge(), PLATE, width, closed=True)
    draw_line(draw, found.drawn(found.angles.surface.places()), OUTLINE, width)
    flanks = found.angles.flanks()
    for name in _DRAWN:
        draw_line(draw, found.drawn([flanks[name].start, flanks[name].end]), FLANK, 2 * width)
    said = [
        f"{name.replace('_', ' ')} {value.value:.1f}° ± {value.standard_error:.1f}°"
        for name, value in found.responses.items()
    ]
    count = len(found.angles.bed.heights)
    text = f"{', '.join(said)} (± standard error over time); {count} frames, the first is shown"
    measured, _ = overlay_places(folder, found.path)
    return write_page(image, text, measured)


def draw_refused(folder: Path, path: Path, reason: str) -> None:
    """Write a PNG of a picture, or of the first frame of a video, with why it is not measured."""
    colours = Video(path).some(1)[0] if is_video(path) else read_picture(path).colours
    _, refused = overlay_places(folder, path)
    write_page(Image.fromarray(colours), f"not measured: {reason}", refused)
