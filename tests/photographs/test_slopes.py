"""Inclined planes and beds on pictures: drawn ones whose angle is known, and ones to refuse."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageFilter
from typer.testing import CliRunner

import grainfit as gf
from grainfit.calibration_file import messages as file_messages
from grainfit.cli.app import app
from grainfit.photographs import messages
from tests.beads_file import BEADS

WIDTH, HEIGHT = 800, 600
#: Row of the table at the left edge of the picture.
TABLE = 0.85 * HEIGHT


def plane(
    angle: float, roll: float = 0.0, seed: int = 0, second: float | None = None
) -> Image.Image:
    """Draw a thin plate on a table with beads on it, rolled counterclockwise, degrees."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (2 * WIDTH, 2 * HEIGHT), (40, 60, 80))
    draw = ImageDraw.Draw(image)
    drop = math.tan(math.radians(roll)) * 2 * WIDTH
    table = [
        (0, 2 * TABLE),
        (2 * WIDTH, 2 * TABLE - drop),
        (2 * WIDTH, 2 * HEIGHT),
        (0, 2 * HEIGHT),
    ]
    draw.polygon(table, fill=(110, 90, 70))
    for inclination, start in ((angle, (0.15, 0.75)), (second, (0.1, 0.35))):
        if inclination is None:
            continue
        a = math.radians(inclination + roll)
        along = np.array([math.cos(a), -math.sin(a)])
        upward = np.array([-math.sin(a), -math.cos(a)])
        foot, length = 2 * np.array(start) * (WIDTH, HEIGHT), 1.4 * WIDTH
        corners = [foot, foot + length * along, foot + length * along + 24 * upward]
        draw.polygon([tuple(one) for one in (*corners, foot + 24 * upward)], fill=(150, 150, 160))
    for place, above, shade in rng.uniform((0.2, 24, 150), (0.6, 60, 255), (60, 3)):
        x, y = foot + place * length * along + above * upward
        draw.ellipse(
            [x - 12, y - 12, x + 12, y + 12], fill=(int(shade), int(shade), int(0.7 * shade))
        )
    small = image.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
    soft = np.asarray(small.filter(ImageFilter.GaussianBlur(0.7)), dtype=float)
    noisy = soft + rng.normal(0, 4, soft.shape)
    return Image.fromarray(np.clip(noisy, 0, 255).astype(np.uint8))


def bed(angle: float, seed: int = 0) -> Image.Image:
    """Draw a bed of grains whose surface is inclined, before a pale wall."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (WIDTH, HEIGHT), (215, 215, 205))
    draw = ImageDraw.Draw(image)
    t = math.tan(math.radians(angle))
    for x in np.arange(0.1 * WIDTH, 0.9 * WIDTH, 6):
        for y in np.arange(0.0, HEIGHT, 6):
            u, v = x + rng.uniform(-2, 2), y + rng.uniform(-2, 2)
            if 0.8 * HEIGHT - t * (u - 0.1 * WIDTH) < v < 0.9 * HEIGHT:
                shade = int(rng.uniform(60, 120))
                draw.ellipse([u - 5, v - 5, u + 5, v + 5], fill=(shade, shade, shade // 2))
    return image


@pytest.mark.parametrize("angle", [6.0, 22.3, 48.0])
def test_the_angle_of_a_plane_is_found_whichever_way_it_rises(angle: float, tmp_path: Path) -> None:
    plane(angle).save(tmp_path / "right.png")
    plane(angle, seed=1).transpose(Image.Transpose.FLIP_LEFT_RIGHT).save(tmp_path / "left.jpg")
    found = gf.photo([tmp_path / "right.png", tmp_path / "left.jpg"], "slope", level=0.1)

    assert [one.angle for one in found.slopes] == pytest.approx([angle, angle], abs=0.15)
    assert found.angle.value == pytest.approx(angle, abs=2 * found.angle.standard_error)
    assert found.angle.standard_error < 0.3


def test_the_surface_of_a_bed_has_an_angle_with_its_roughness(tmp_path: Path) -> None:
    bed(27.0).save(tmp_path / "bed.png")
    found = gf.photo(tmp_path / "bed.png", "slope", level=0.1)

    assert found.angle.value == pytest.approx(27.0, abs=0.5)
    assert found.parts["edge"] > 0.02


def test_a_reference_line_makes_up_for_a_rolled_camera(tmp_path: Path) -> None:
    path = tmp_path / "rolled.png"
    plane(28.0, roll=-3.0).save(path)
    drop = math.tan(math.radians(-3.0)) * WIDTH
    line = ((0.0, TABLE), (float(WIDTH), TABLE - drop))

    rolled, level = gf.photo(path, "slope"), gf.photo(path, "slope", reference=line)
    assert rolled.angle.value == pytest.approx(25.0, abs=0.2)
    assert rolled.parts["horizontal"] == 0.5
    assert messages.LEVEL_SLOPE.is_in("\n".join(map(str, rolled.summary())))
    assert level.angle.value == pytest.approx(28.0, abs=0.3)
    assert level.parts["horizontal"] < 0.3


def test_what_is_no_slope_is_refused_with_the_reason(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    grey = np.full((HEIGHT, WIDTH, 3), 120) + rng.normal(0, 5, (HEIGHT, WIDTH, 3))
    circle = Image.new("RGB", (WIDTH, HEIGHT), (40, 60, 80))
    ImageDraw.Draw(circle).ellipse([200, 100, 600, 500], fill=(200, 200, 190))
    for name, image, why in (
        ("empty", Image.fromarray(grey.astype(np.uint8)), messages.NO_SLOPE),
        ("level", plane(0.5), messages.NO_SLOPE),
        ("round", circle, messages.NO_SLOPE),
        ("two", plane(20.0, second=33.0), messages.TWO_SLOPES),
    ):
        image.save(tmp_path / f"{name}.png")
        with pytest.raises(gf.NotMeasurableError) as error:
            gf.photo(tmp_path / f"{name}.png", "slope", overlays=tmp_path)
        assert why.is_in(str(error.value)), (name, str(error.value))
        assert (tmp_path / f"{name}_refused.png").is_file()


def test_the_command_prints_the_friction_on_a_wall(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    plane(22.3).save("plane.png")
    line = f"0,{TABLE:g} {WIDTH},{TABLE:g}"
    done = CliRunner().invoke(app, ["photo", "--test", "slope", "--reference", line, "plane.png"])

    assert done.exit_code == 0, done.output
    said = [s for s in done.output.splitlines() if s.startswith("sliding_friction = {")]
    assert 'measured_angle = "22.' in said[0]
    assert Image.open("overlays/plane_measured.png").size[0] == WIDTH
    wrong = CliRunner().invoke(app, ["photo", "--test", "slope", "--plate", "2 cm", "plane.png"])
    assert isinstance(wrong.exception, gf.InputError)


def test_friction_on_a_wall_is_what_the_pictures_of_the_file_tell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    plane(22.3).save("plane_1.png")
    slope = '{ photos = "plane_*.png", level = "0.1 deg" }'
    heap = '[[test]]\ntype = "heap"\nsolver = "lammps"\ntargets.angle_of_repose.value = 25\n'

    def write(name: str, value: str, key: str = "sliding_friction") -> Path:
        lines = BEADS.split("[particle_wall]")
        wall = lines[1].replace("sliding_friction = 0.5", "").replace("rolling_friction = 0.1", "")
        others = {"sliding_friction": "0.5", "rolling_friction": "0.1", "restitution": "0.5"}
        wall = wall.replace("restitution = 0.5", "")
        given = "".join(f"{k} = {v}\n" for k, v in {**others, key: value}.items())
        Path(name).write_text(f"{lines[0]}[particle_wall]\n{given}{wall}{heap}")
        return Path(name)

    setup = gf.load(write("beads.toml", slope))
    alone = gf.photo("plane_1.png", "slope", level="0.1 deg").angle
    given = f'measured_angle = "{alone.value:.2f}°", uncertainty = "{alone.standard_error:.2f}°"'
    typed = gf.load(write("typed.toml", f"{{ {given} }}"))

    assert [str(one) for one in setup.problem.parameters] == list(
        map(str, typed.problem.parameters)
    )
    assert list(setup.provenance.pictures) == ["particle_wall.sliding_friction"]
    said = CliRunner().invoke(app, ["check", "beads.toml"]).output
    assert file_messages.REPEATS_PHOTOGRAPHED.is_in(said), said
    with pytest.raises(
        gf.InputError, match=rf"restitution\.photos: {file_messages.NO_TANGENT.pattern}"
    ):
        gf.load(write("wrong.toml", slope, "restitution"))
