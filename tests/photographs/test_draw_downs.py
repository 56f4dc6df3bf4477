"""Draw-downs on pictures: drawn ones whose angles are known, and ones to refuse."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter
from typer.testing import CliRunner

import grainfit as gf
from grainfit.calibration_file import messages as file_messages
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.originals import keep_pictures
from grainfit.cli.app import app
from grainfit.measurement.height_map import height_map
from grainfit.measurement.inclination import inclination_of_pile, inclination_of_wedges
from grainfit.measurement.particles import Particles
from grainfit.photographs import messages
from tests.beads_file import BEADS

#: Half the width of the box, of the slot and depth, in diameters; floor and shelf.
HALF, SLOT, DEPTH = 12.0, 2.5, 6.0
FLOOR, SHELF = 0.0, 14.0
#: Pixels of a diameter; columns and rows of the picture; row of the floor.
PIXELS, SIZE, BOTTOM = 14, (640, 420), 380


def drawn_down(shear: float, repose: float, seed: int) -> tuple[NDArray[np.float64], ...]:
    """Return the particles of heap and wedges, places in diameters: across, depth, height."""
    rng = np.random.default_rng(seed)
    axes = np.arange(-18, 18, 0.9), np.arange(0.45, DEPTH, 0.9), np.arange(0.5, 14, 0.82)
    lattice = np.column_stack([one.ravel() for one in np.meshgrid(*axes)])
    lattice += rng.uniform(-0.25, 0.25, lattice.shape)
    x, _, z = lattice.T
    heap = lattice[z < 7.5 - np.abs(x) * math.tan(math.radians(repose))]
    slope = (np.abs(x) - SLOT) * math.tan(math.radians(shear)) - 0.3
    wedges = lattice[(np.abs(x) < HALF - 0.5) & (z < slope)] + [0, 0, SHELF]
    return heap, wedges


def truth(heap: NDArray[np.float64], wedges: NDArray[np.float64]) -> dict[str, float]:
    """Return the angles by the measure of simulated draw-downs."""

    def of(places: NDArray[np.float64]) -> Particles:
        radii = np.full(len(places), 0.5)
        return Particles(places, radii, radii**3)

    pile = height_map(of(heap), -18, 18, DEPTH, FLOOR)
    left = height_map(of(wedges), -HALF, HALF, DEPTH, SHELF)
    return {
        "angle_of_repose": inclination_of_pile(pile, 1.0).value,
        "shear_angle": inclination_of_wedges(left, 2 * SLOT, 1.0).value,
    }


def picture(
    heap: NDArray[np.float64], wedges: NDArray[np.float64], roll: float = 0.0, seed: int = 0
) -> Image.Image:
    """Draw them from the front, before a dark wall, with box, shelf and floor."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (2 * SIZE[0], 2 * SIZE[1]), (35, 45, 60))
    draw = ImageDraw.Draw(image)

    def place(x: float, z: float) -> tuple[float, float]:
        return SIZE[0] + 2 * PIXELS * x, 2 * (BOTTOM - PIXELS * z)

    def box(x: float, z: float, u: float, v: float, colour: tuple[int, int, int]) -> None:
        draw.rectangle([*place(x, v), *place(u, z)], fill=colour)

    box(-30, -5, 30, FLOOR, (95, 75, 60))
    for side in (-1, 1):
        inner, outer, slot = side * HALF, side * (HALF + 0.5), side * SLOT
        box(min(slot, outer), SHELF - 0.5, max(slot, outer), SHELF, (120, 125, 130))
        box(min(inner, outer), SHELF, max(inner, outer), 26, (120, 125, 130))
    for x, y, z in sorted(np.vstack([heap, wedges]).tolist(), key=lambda one: -one[1]):
        u, v = place(x, z)
        light = (1 - 0.25 * y / DEPTH) * rng.uniform(0.9, 1.1)
        for size, shade in ((0.5, 0.75), (0.35, 0.9)):
            r = 2 * PIXELS * size
            colour = tuple(int(min(shade * light * c, 255)) for c in (225, 195, 140))
            draw.ellipse([u - r, v - r, u + r, v + r], fill=colour)
    small = image.rotate(roll, Image.Resampling.BICUBIC, fillcolor=(35, 45, 60)).resize(
        SIZE, Image.Resampling.LANCZOS
    )
    soft = np.asarray(small.filter(ImageFilter.GaussianBlur(0.7)), dtype=float)
    return Image.fromarray(np.clip(soft + rng.normal(0, 4, soft.shape), 0, 255).astype(np.uint8))


def test_both_angles_are_those_of_the_simulated_measure(tmp_path: Path) -> None:
    trues, folder = [], tmp_path / "pictures"
    folder.mkdir()
    for number, (shear, repose, roll) in enumerate(((30, 26, 0.0), (38, 29, 1.5))):
        heap, wedges = drawn_down(shear, repose, number)
        trues.append(truth(heap, wedges))
        picture(heap, wedges, roll, number).save(folder / f"{number}.png")
    known = {"diameter": "10 mm", "box": f"{20 * HALF:g} mm"}
    found = gf.photo(folder, "draw_down", overlays=tmp_path, **known)

    for one, true in zip(found.pictures, trues, strict=True):
        assert one.angles["angle_of_repose"] == pytest.approx(true["angle_of_repose"], abs=0.5)
        assert one.angles["shear_angle"] == pytest.approx(true["shear_angle"], abs=1.3)
    for name, angle in found.responses.items():
        mean = np.mean([true[name] for true in trues])
        assert abs(angle.value - mean) < 2 * angle.standard_error
    assert len(list(tmp_path.glob("*_measured.png"))) == 2


def test_without_wedges_there_is_no_shear_angle_and_without_a_heap_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    heap, wedges = drawn_down(30.0, 26.0, 0)
    picture(heap, wedges[wedges[:, 0] < 0]).save("one.png")
    done = CliRunner().invoke(app, ["photo", "--test", "draw_down", "one.png"])

    assert done.exit_code == 0, done.output
    assert messages.NO_WEDGES(left=1, right=0) in " ".join(done.output.split())
    lines = [line for line in done.output.splitlines() if line.startswith("targets.")]
    assert len(lines) == 1
    assert lines[0].startswith("targets.angle_of_repose = {")
    picture(heap[:0], wedges).save("none.png")
    with pytest.raises(gf.NotMeasurableError):
        gf.photo("none.png", "draw_down", overlays=tmp_path)
    assert Path("none_refused.png").is_file()
    for wrong, why in (
        ({"plate": "2 cm"}, messages.NOT_OF_DRAW_DOWN),
        ({"diameter": "3 mm"}, messages.BOX_AND_DIAMETER),
    ):
        with pytest.raises(gf.InputError) as error:
            gf.photo("one.png", "draw_down", **wrong)
        assert why.is_in(str(error.value))


def test_what_hides_a_flank_and_what_is_cut_off_are_refused(tmp_path: Path) -> None:
    whole = picture(*drawn_down(32.0, 27.0, 5), seed=5)
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    # It was measured as 34 degrees.
    spot = 300 * np.exp(-((columns - 360) ** 2 + (rows - 300) ** 2) / (2 * 40**2))
    shone = np.clip(np.asarray(whole, dtype=float) + spot[..., None], 0, 255).astype(np.uint8)
    for image, why in (
        (Image.fromarray(shone), messages.UNEQUAL_FLANKS),
        (whole.crop((0, 130, *SIZE)), messages.WEDGES_CUT_OFF),
    ):
        image.save(tmp_path / "box.png")
        with pytest.raises(gf.NotMeasurableError) as error:
            gf.photo(tmp_path / "box.png", "draw_down", diameter="10 mm", box="240 mm")
        assert why.is_in(str(error.value)), str(error.value)


BOXES = 'photos = ["box_*.png"], diameter = "10 mm"'


def _load(folder: Path, targets: str, options: str = 'width = "240 mm"') -> CalibrationSetup:
    test = f'[[test]]\ntype = "draw_down"\nsolver = "lammps"\n{options}\n'
    (folder / "beads.toml").write_text(BEADS + test + targets)
    return gf.load(folder / "beads.toml", folder / "work")


def test_targets_of_the_file_are_what_the_pictures_tell_and_are_measured_once(
    tmp_path: Path,
) -> None:
    picture(*drawn_down(30.0, 26.0, 0)).save(tmp_path / "box_1.png")
    both = (
        f'targets.shear_angle = {{ {BOXES}, tolerance = "2 deg" }}\n'
        f"targets.angle_of_repose = {{ {BOXES} }}\n"
    )
    setup = _load(tmp_path, both)
    alone = gf.photo(tmp_path / "box_1.png", "draw_down", diameter="10 mm", box="240 mm")

    for target in setup.problem.targets:
        found = alone.responses[target.name]
        assert (target.value, target.uncertainty) == (
            round(found.value, 2),
            round(found.standard_error, 2),
        )
    digest = hashlib.sha256((tmp_path / "box_1.png").read_bytes()).hexdigest()
    assert setup.provenance.pictures["shear_angle"] == {"box_1.png": digest}
    kept = list((tmp_path / "work/photographs").glob("*/measured.json"))
    assert len(kept) == 1
    assert list(kept[0].parent.glob("box_1_measured.png"))

    kept[0].write_text(
        json.dumps({**json.loads(kept[0].read_text()), "angles": {"shear_angle": [33.0, 1.0]}})
    )
    shear = f"targets.shear_angle = {{ {BOXES} }}\n"
    assert _load(tmp_path, shear).problem.targets[0].value == 33.0
    keep_pictures(setup.file.photographed, tmp_path / "work", tmp_path)
    (tmp_path / "box_1.png").rename(tmp_path / "kept.png")
    moved = shear.replace("box_*", "box_1")
    for targets, options, key, why in (
        (moved, 'width = "240 mm"', "photos[0]", file_messages.MOVED_TO),
        (shear.replace("box_*", "kept"), "", "diameter", file_messages.DIAMETER_WITHOUT_BOX),
    ):
        with pytest.raises(gf.InputError) as error:
            _load(tmp_path, targets, options)
        assert f"line 26, test 1, targets.shear_angle.{key}:" in str(error.value)
        assert why.is_in(str(error.value))
