"""What is drawn on a picture by hand, and four points where there is no marker sheet."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.cli.app import app
from grainfit.photographs import messages
from grainfit.photographs.by_hand import ByHand, by_hand_path, write_by_hand
from tests.photographs.drawn_pictures import cone
from tests.photographs.rendered_pictures import Shot, _camera, save, true_angle

#: Half the sides of a level rectangle at the height of the plate, m.
HALVES = (0.30, 0.25)


@pytest.fixture(scope="module")
def shot() -> Shot:
    """A heap on a plate that looks like its table."""
    table = (0.2, 0.22, 0.25)
    return Shot(cone(33.0, 9.0, 1), elevation=14.0, roll=3.0, distance=1.2, table=table)


@pytest.fixture
def picture(shot: Shot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A picture of it."""
    path = tmp_path_factory.mktemp("heap") / "heap.jpg"
    save(shot, path, exif=True)
    return path


def seen(shot: Shot, places: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return columns and rows of places at the height of the plate, m."""
    place, axes = _camera(shot)
    width, height = shot.size
    found = (np.array([(x, y, 0.0) for x, y in places]) - place) @ axes.T
    across = shot.focal_px * found[:, :2] / found[:, 2:]
    middle = (width / 2 - 0.5, height / 2 - 0.5)
    return [(float(x), float(y)) for x, y in across + middle]


def rectangle(shot: Shot) -> list[tuple[float, float]]:
    x, y = HALVES
    return seen(shot, [(-x, y), (x, -y), (x, y), (-x, -y)])


def test_four_points_tell_elevation_angle_and_lengths(shot: Shot, picture: Path) -> None:
    with pytest.raises(gf.NotMeasurableError):
        gf.photo(picture)  # neither plate nor marker sheet: the elevation is too uncertain

    points, sides = rectangle(shot), (2 * HALVES[1], "60 cm")
    [[found]] = gf.photo(picture, points=points, rectangle=sides).heaps

    assert found.seen_by == "by four points, four points drawn by hand"
    assert found.elevation == pytest.approx(shot.elevation, abs=0.3)
    assert found.roll == pytest.approx(-shot.roll, abs=0.3)
    assert found.angle == pytest.approx(true_angle(shot), abs=2 * found.uncertainty)
    assert found.scale is not None
    width = np.ptp(shot.particles.positions[:, 0]) + shot.particles.diameter
    # The pixel is that at the apex; the foot is farther from the camera.
    height = float((shot.particles.positions[:, 2] + shot.particles.radii).max())
    farther = 1 + height * np.sin(np.radians(shot.elevation)) / shot.distance
    assert np.ptp(found.outline[:, 0]) * found.scale * farther == pytest.approx(width, rel=0.03)
    given = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    done = CliRunner().invoke(
        app, ["photo", str(picture), "--points", given, "--overlays", str(picture.parent)]
    )
    assert done.exit_code == 0, done.output
    assert "four points" in done.output


def test_points_of_no_level_rectangle_are_refused(shot: Shot, picture: Path) -> None:
    points = rectangle(shot)
    with pytest.raises(gf.NotMeasurableError) as error:
        gf.photo(picture, points=[*points[:3], points[2]])
    assert messages.NO_RECTANGLE.is_in(str(error.value))
    # A parallelogram on the table: its corners are not at right angles.
    with pytest.raises(gf.NotMeasurableError) as error:
        gf.photo(picture, points=seen(shot, [(-0.3, -0.2), (0.1, -0.2), (0.3, 0.2), (-0.1, 0.2)]))
    assert messages.NOT_LEVEL.is_in(str(error.value))
    with pytest.raises(gf.NotMeasurableError) as error:
        gf.photo(picture, points=points, rectangle=("30 cm", "60 cm"))
    assert messages.OTHER_SHAPE.is_in(str(error.value))
    with pytest.raises(gf.InputError, match="points"):
        gf.photo(picture, points=points[:3])
    other = picture.with_name("other.jpg")
    other.write_bytes(picture.read_bytes() + b"another picture")
    with pytest.raises(gf.InputError, match="points"):
        gf.photo([picture, other], points=points)
    with pytest.raises(gf.InputError, match="rectangle"):
        gf.photo(picture, points=points, rectangle="60 cm")  # type: ignore[arg-type]


def test_what_is_drawn_by_hand_is_used_again_and_said(shot: Shot, picture: Path) -> None:
    turns = np.linspace(0, 2 * np.pi, 720)
    edge = seen(shot, list(zip(0.33 * np.cos(turns), 0.33 * np.sin(turns), strict=True)))
    # The ends as one sees them, and the nearest place along the roll.
    front = max(edge, key=lambda at: at[1] - at[0] * np.tan(np.radians(shot.roll)))
    drawn = ByHand(plate=(min(edge), max(edge), front), axis=tuple(seen(shot, [(0.0, 0.0)])))

    write_by_hand(picture, drawn)

    [[found]] = gf.photo(picture).heaps
    assert found.seen_by == "by the plate, plate line, axis drawn by hand"
    assert found.elevation == pytest.approx(shot.elevation, abs=1.0)
    assert found.angle == pytest.approx(true_angle(shot), abs=1.0)
    write_by_hand(picture, ByHand())
    assert not by_hand_path(picture).exists()


def test_what_was_drawn_on_another_picture_is_refused(picture: Path) -> None:
    path = write_by_hand(picture, ByHand(axis=((400.0, 200.0),)))
    kept = json.loads(path.read_text())

    path.write_text(json.dumps({**kept, "picture_sha256": "0"}))
    with pytest.raises(gf.InputError) as error:
        gf.photo(picture)
    assert messages.OTHER_PICTURE.is_in(str(error.value))
    path.write_text(json.dumps({**kept, "axis": [[1, 2], [3, 4]]}))
    with pytest.raises(gf.InputError) as error:
        gf.photo(picture)
    assert messages.DAMAGED.is_in(str(error.value))
