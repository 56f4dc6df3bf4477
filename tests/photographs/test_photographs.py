"""Heaps on photographs: rendered pictures whose angle is known, and pictures to refuse."""

from __future__ import annotations

import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import grainfit as gf
from grainfit.cli.app import app
from grainfit.errors import NotMeasurableError
from grainfit.photographs import messages
from grainfit.photographs.camera import apparent_angle, true_angle, up_from
from grainfit.photographs.heap import _unsure_elevation
from grainfit.photographs.pictures import read_picture
from grainfit.photographs.plate import Rim
from tests.photographs.drawn_pictures import cone, unusable, usable
from tests.photographs.rendered_pictures import Shot, save
from tests.photographs.rendered_pictures import true_angle as angle_in_view

ANGLES = (18.0, 25.0, 33.0, 41.0)
HEIGHT = 10.0


@pytest.fixture(scope="module")
def pale(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Shot]:
    """A heap of 25 degrees on a plate, seen from 6 degrees above."""
    particles = cone(25.0, HEIGHT, 1)
    shot = Shot(particles, elevation=6.0, roll=3.0, distance=1.1, plate_radius=0.31)
    path = tmp_path_factory.mktemp("pale") / "heap.jpg"
    save(shot, path, exif=True)
    return path, shot


def test_a_cone_seen_from_above_is_corrected_in_closed_form() -> None:
    # The normal of the generator in view is at right angles to the line of sight.
    angle, e = math.radians(25), math.radians(12)
    behind = math.asin(math.tan(e) / math.tan(angle))
    down = np.array([math.cos(behind), math.sin(behind), -math.tan(angle)])
    up_in_picture = np.array([0, math.sin(e), math.cos(e)])
    seen = math.degrees(math.atan(-(down @ up_in_picture) / down[0]))

    assert apparent_angle(25, 12) == pytest.approx(seen)
    assert true_angle(seen, 12) == pytest.approx(25)
    assert math.isnan(apparent_angle(25, 25))


@pytest.mark.parametrize(
    ("good", "bad"), [(12, 3), pytest.param(24, 6, marks=pytest.mark.thorough)]
)
def test_pictures_are_measured_or_refused_and_never_wrong_in_silence(
    good: int, bad: int, tmp_path: Path
) -> None:
    errors, covered = [], []
    for number in range(good):
        shot = usable(number, angles=ANGLES, height=HEIGHT)
        path = tmp_path / f"{number}.jpg"
        save(shot, path, exif=True)
        try:
            found = gf.photo(path).heaps[0][0]
        except gf.NotMeasurableError:
            continue
        errors.append(found.angle - angle_in_view(shot))
        covered.append(abs(errors[-1]) < 2 * found.uncertainty)
    refused = 0
    for number in range(bad):
        path = tmp_path / f"unusable_{number}.jpg"
        save(unusable(number, angles=ANGLES, height=HEIGHT), path, exif=True)
        try:
            gf.photo(path)
        except gf.NotMeasurableError:
            refused += 1

    assert refused == bad
    assert len(errors) >= 3 / 4 * good
    assert np.abs(errors).max() < 1.2
    assert np.sqrt(np.mean(np.square(errors))) < 0.5
    assert abs(np.mean(errors)) < 0.25
    assert np.mean(covered) > 0.8


def test_a_picture_from_far_above_does_not_read_a_flat_heap(tmp_path: Path) -> None:
    # 25 degrees seen from 20 degrees above appear as 15.
    shot = Shot(cone(25.0, HEIGHT, 1), elevation=20.0, distance=1.1, plate_radius=0.31)
    save(shot, tmp_path / "high.jpg", exif=True)

    with pytest.raises(gf.NotMeasurableError) as error:
        gf.photo(tmp_path / "high.jpg")

    said = str(error.value)
    assert messages.TOO_HIGH.is_in(said) or messages.FROM_ABOVE.is_in(said)


def test_an_elevation_that_the_foot_contradicts_is_refused(pale: tuple[Path, Shot]) -> None:
    with pytest.raises(gf.NotMeasurableError) as error:
        gf.photo(pale[0], elevation="0 deg")

    assert messages.ELEVATIONS_DISAGREE.is_in(str(error.value))


@pytest.mark.parametrize("suffix", ["png", "tif", "heic"])
def test_formats_of_cameras_and_telephones(
    pale: tuple[Path, Shot], tmp_path: Path, suffix: str
) -> None:
    if suffix == "heic":
        pytest.importorskip("pillow_heif").register_heif_opener()
    path = tmp_path / f"heap.{suffix}"
    Image.open(pale[0]).save(path)

    assert gf.photo(path).angle_of_repose.value == pytest.approx(angle_in_view(pale[1]), abs=0.6)


def test_a_picture_that_was_taken_upright_is_turned_as_its_exif_data_say(
    pale: tuple[Path, Shot], tmp_path: Path
) -> None:
    with Image.open(pale[0]) as image:
        tags = image.getexif()
        tags[0x0112] = 6  # to be turned clockwise
        turned = image.transpose(Image.Transpose.ROTATE_90)
        turned.save(tmp_path / "turned.jpg", exif=tags, quality=97)

    upright = gf.photo(pale[0]).angle_of_repose.value
    assert gf.photo(tmp_path / "turned.jpg").angle_of_repose.value == pytest.approx(
        upright, abs=0.2
    )


def test_plate_and_particles_give_lengths(pale: tuple[Path, Shot]) -> None:
    found = gf.photo(pale[0], plate="620 mm", diameter="10 mm").heaps[0][0]

    assert found.scale is not None
    width = 800 * found.scale  # of the picture, at the heap
    assert width == pytest.approx(1.1, rel=0.05)
    assert found.diameter * found.scale == pytest.approx(0.010)
    with pytest.raises(gf.InputError, match="plate"):
        gf.photo(pale[0], diameter="10 mm")


def test_particles_as_large_as_their_heap_are_refused(pale: tuple[Path, Shot]) -> None:
    with pytest.raises(NotMeasurableError) as caught:
        gf.photo(pale[0], plate="620 mm", diameter="400 mm")
    assert messages.COARSE.is_in(str(caught.value))


def test_pictures_in_a_folder_show_one_heap(pale: tuple[Path, Shot], tmp_path: Path) -> None:
    (tmp_path / "one").mkdir()
    for azimuth in (20, 80, 140):
        save(replace(pale[1], azimuth=azimuth), tmp_path / "one" / f"{azimuth}.jpg", exif=True)
    one = gf.photo(tmp_path / "one")
    single = gf.photo(pale[0])

    assert [len(heap) for heap in one.heaps] == [3]
    assert one.angle_of_repose.standard_error < single.angle_of_repose.standard_error
    assert len(gf.photo([tmp_path / "one", pale[0]]).heaps) == 2


def test_the_command_prints_a_target_and_leaves_overlays(
    pale: tuple[Path, Shot], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(pale[0], "heap.jpg")
    Image.new("RGB", (640, 480), (90, 90, 90)).save("blank.png")
    done = CliRunner().invoke(app, ["photo", "heap.jpg", "blank.png"])

    assert done.exit_code == 0, done.output
    assert messages.NO_HEAP.is_in(done.output)
    line = next(row for row in done.output.splitlines() if row.startswith("targets."))
    assert 'value = "2' in line
    assert 'uncertainty = "' in line
    assert Image.open("overlays/heap_measured.png").size[0] == 800
    assert Path("overlays/blank_refused.png").is_file()
    refused = CliRunner().invoke(app, ["photo", "blank.png"])
    assert isinstance(refused.exception, gf.NotMeasurableError)


def test_what_is_no_picture_is_named(tmp_path: Path) -> None:
    (tmp_path / "notes.jpg").write_text("no picture")

    with pytest.raises(gf.InputError) as error:
        gf.photo(tmp_path / "notes.jpg")
    assert messages.UNREADABLE.is_in(str(error.value))
    with pytest.raises(gf.InputError) as error:
        gf.photo(tmp_path / "none.jpg")
    assert messages.NO_FILE.is_in(str(error.value))


# Upper and lower edge of the side of a plate are alike from here, and its far edge is faint.
@pytest.mark.parametrize("number", [14, 16])
def test_the_upper_edge_of_a_plate_is_found_and_not_the_lower_one(
    tmp_path: Path, number: int
) -> None:
    shot, path = usable(number), tmp_path / "heap.jpg"
    save(shot, path, exif=True)

    found = gf.photo(path).heaps[0][0]

    assert found.seen_by == "by the plate"
    assert found.elevation == pytest.approx(shot.elevation, abs=0.4)
    assert found.angle == pytest.approx(angle_in_view(shot), abs=0.5)


def test_a_plate_that_is_hidden_by_its_heap_tells_the_elevation() -> None:
    focal, middle = 1400.0, (480.0, 360.0)
    towards = np.array([0.02, 0.15, 1.0]) / math.hypot(0.02, 0.15, 1.0)
    up = up_from(math.radians(10.0), math.radians(2.0), towards)
    across = np.cross(towards, up) / np.linalg.norm(np.cross(towards, up))
    # A camera that is near; the back is behind the heap.
    turn = np.radians(np.r_[0.0:60.0:3.0, 120.0:360.0:3.0])
    circle = np.outer(np.cos(turn), across) + np.outer(np.sin(turn), np.cross(up, across))
    seen = towards + 0.35 * circle
    points = seen[:, :2] / seen[:, 2:] * focal + np.array(middle)

    plate = Rim(points, points, 490.0).plate(focal, middle)

    assert plate.elevation == pytest.approx(10.0, abs=0.05)
    assert plate.error < 0.3


def test_particles_that_classes_of_colours_miss_belong_to_the_heap(tmp_path: Path) -> None:
    # Dark beads on a dark side of their heap: the angle was 1.1 degrees too small.
    shot, path = usable(56), tmp_path / "heap.jpg"
    save(shot, path, exif=True)

    assert gf.photo(path).heaps[0][0].angle == pytest.approx(angle_in_view(shot), abs=0.6)


def test_a_camera_below_the_apex_is_as_sure_as_one_above() -> None:
    """At the height of the plate it is 8 degrees below the apex of a near heap."""
    below, above = (_unsure_elevation(30.0, elevation, 0.5) for elevation in (-8.2, 8.2))

    assert below == above < 0.2


def test_a_picture_of_16_bits_is_read_as_that_of_8(pale: tuple[Path, Shot]) -> None:
    with Image.open(pale[0]) as image:
        grey = image.convert("L")
    folder = pale[0].parent
    grey.save(folder / "eight.png")
    Image.fromarray(np.asarray(grey).astype(np.uint16) * 257).save(folder / "sixteen.png")

    eight, sixteen = (read_picture(folder / f"{name}.png") for name in ("eight", "sixteen"))

    np.testing.assert_array_equal(eight.colours, sixteen.colours)


def test_one_picture_given_twice_is_not_two_heaps(pale: tuple[Path, Shot]) -> None:
    copy = pale[0].with_name("it's a copy.jpg")
    shutil.copy(pale[0], copy)
    with pytest.raises(gf.InputError) as refused:
        gf.photo([pale[0], copy])
    assert messages.SAME_PICTURE.is_in(str(refused.value), file=str(copy), other=str(pale[0]))
