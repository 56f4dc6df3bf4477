"""The printed sheet of markers: its PDF, and what it tells in a picture."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypdfium2
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.cli.app import app
from grainfit.photographs import marker
from grainfit.photographs.pictures import opencv, read_picture
from tests.photographs.drawn_pictures import cone
from tests.photographs.rendered_pictures import Sheet, Shot, save, true_angle

PIXELS = 2000


def _printed() -> Sheet:
    """Return the sheet as it comes from the printer, before the heap on the table."""
    cv2 = opencv()
    image = np.full((round(PIXELS * marker.HEIGHT / marker.WIDTH), PIXELS), 255, np.uint8)
    scale = PIXELS / marker.WIDTH
    for number in marker.MARKERS:
        places = marker._corners(number)[:, :2] + [marker.WIDTH / 2, marker.HEIGHT / 2]
        left, top = round(places[0, 0] * scale), round((marker.HEIGHT - places[0, 1]) * scale)
        side = round(marker.SIDE * scale)
        one = cv2.aruco.generateImageMarker(marker._dictionary(), number, side)
        image[top : top + side, left : left + side] = one
    corner = (-marker.WIDTH / 2, -0.62, 0.001)
    return Sheet(image, marker.WIDTH, corner, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def _shot(elevation: float, roll: float = 2.0) -> Shot:
    particles = cone(33.0, 10.0, 1)
    return Shot(
        particles,
        elevation=elevation,
        roll=roll,
        distance=1.4,
        focal=1.1,
        size=(1600, 1200),
        aim=(0.0, -0.05),
        sheet=_printed(),
    )


# From 20 degrees above, two of the four markers are in the picture.
@pytest.mark.parametrize(("elevation", "roll"), [(14.0, 2.0), (20.0, -4.0)])
def test_the_sheet_tells_elevation_angle_and_lengths(
    tmp_path: Path, elevation: float, roll: float
) -> None:
    shot, path = _shot(elevation, roll), tmp_path / "heap.jpg"
    save(shot, path, exif=True)

    [[found]] = gf.photo(path).heaps

    assert found.seen_by == "by the marker sheet"
    assert found.elevation == pytest.approx(elevation, abs=2.5 * found.elevation_error)
    assert found.angle == pytest.approx(true_angle(shot), abs=2.5 * found.uncertainty)
    assert found.uncertainty < 0.6
    assert found.scale is not None
    radius = np.hypot(*shot.particles.positions[:, :2].T).max() + shot.particles.radii.max()
    # The length of a pixel is that at the apex, which is nearer than the foot.
    top = shot.particles.positions[:, 2].max()
    farther = 1 + top * np.sin(np.radians(elevation)) / shot.distance
    width = 2 * radius / farther
    assert np.ptp(found.outline[:, 0]) * found.scale == pytest.approx(width, rel=0.03)


def test_a_sheet_that_is_bent_or_cut_tells_nothing(tmp_path: Path) -> None:
    sheet = _printed()
    hidden = sheet.image.copy()
    hidden[:, PIXELS // 2 :] = 255
    hidden[: len(hidden) // 2] = 255
    path = tmp_path / "heap.jpg"
    save(replace(_shot(14.0), sheet=replace(sheet, image=hidden)), path, exif=True)
    picture = read_picture(path)
    rows, columns = picture.colours.shape[:2]
    middle = ((columns - 1) / 2, (rows - 1) / 2)

    assert picture.focal is not None
    assert marker.find_marker_sheet(picture.colours, picture.focal, middle) is None


def test_the_sheet_is_a_page_of_paper(tmp_path: Path) -> None:
    path = tmp_path / "marker sheet.pdf"

    found = CliRunner().invoke(app, ["photo", "--marker", str(path)])

    assert found.exit_code == 0, found.output
    with closing(pypdfium2.PdfDocument(path)) as document:
        [page] = document
        assert page.get_size() == pytest.approx((841.890, 595.276), abs=1e-3)
        # Seen from straight above.
        seen = np.array(page.render(scale=2).to_pil().convert("RGB"))
        words = page.get_textpage().get_text_range()
    assert "print at 100 %" in words
    rows, columns = seen.shape[:2]
    sheet = marker.find_marker_sheet(seen, 10.0 * columns, ((columns - 1) / 2, (rows - 1) / 2))
    assert sheet is not None
    assert sheet.elevation == pytest.approx(90, abs=2)
    # The camera is ten widths of the paper away: lengths are as printed.
    assert sheet.height == pytest.approx(10 * marker.WIDTH, rel=0.01)


def test_no_picture_and_no_marker_is_said() -> None:
    found = CliRunner().invoke(app, ["photo"])

    assert isinstance(found.exception, gf.InputError)
    assert "--marker" in str(found.exception)
