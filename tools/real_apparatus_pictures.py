"""Draw the pictures of the tutorial on the real apparatus from the finished example.

python tools/real_apparatus_pictures.py examples/real_apparatus/pot.toml FOLDER

FOLDER is the work folder of the calibration; nothing is simulated. Sizes at the answer are written
to docs/images/real_apparatus_sizes.png, runs of the smallest and the largest size of each test to
docs/images/real_apparatus_runs.png.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from PIL import Image

import grainfit as gf
from grainfit.analysis.size_study import SizePlan, SizeStudy, simulate_sizes
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.twins import SEEDS, sizes_at_answer
from grainfit.work_folder.open_folder import open_folder
from grainfit.work_folder.size_picture import draw_sizes

IMAGES = Path(__file__).parents[1] / "docs" / "images"
#: Width of the picture of a run, pixels.
_WIDTH = 400
_COLOURS = 128


def answer(setup: CalibrationSetup, folder: Path) -> dict[str, float]:
    """Return the parameters at which sizes were simulated last."""
    with open_folder(folder) as opened:
        runs = [run for run in opened.store.runs("finished") if run.test.endswith(", size 1")]
    found = runs[-1].definition.parameters
    return {parameter.name: found[parameter.name] for parameter in setup.problem.parameters}


def plans(setup: CalibrationSetup, parameters: dict[str, float]) -> list[SizePlan]:
    """Return the sizes of each test that were simulated."""
    found = []
    for name, twin in setup.twins.items():
        solver = setup.solvers[name]
        assert solver.bulk_test is not None, "twins are of bulk tests"
        assert twin.bulk_test is not None, "twins are bulk tests"
        times = sizes_at_answer(solver.bulk_test, twin.bulk_test)
        found.append(SizePlan({name: solver}, setup.problem, parameters, times, 1.0, SEEDS))
    return found


def runs(plan: SizePlan, folder: Path) -> list[Image.Image]:
    """Return the pictures of the first run of the smallest and the largest size."""
    [name] = plan.solvers
    pictures = []
    for size in (plan.sizes[0], plan.sizes[-1]):
        run = plan.solver_of(name, size).definition(plan.parameters, 1).identity
        [path] = sorted((folder / "runs" / run).glob("*.png"))
        picture = Image.open(path).convert("RGB")
        height = round(picture.height * _WIDTH / picture.width)
        pictures.append(picture.resize((_WIDTH, height), Image.Resampling.LANCZOS))
    return pictures


def tiled(rows: list[list[Image.Image]]) -> Image.Image:
    """Return pictures in rows."""
    heights = [max(one.height for one in row) for row in rows]
    sheet = Image.new("RGB", (max(map(len, rows)) * _WIDTH, sum(heights)), "white")
    for number, row in enumerate(rows):
        for column, one in enumerate(row):
            sheet.paste(one, (column * _WIDTH, sum(heights[:number])))
    return sheet


def main() -> None:
    """Draw both pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    setup = gf.load(given.file)
    parameters = answer(setup, given.folder)
    found = plans(setup, parameters)
    studies = [simulate_sizes(plan, given.folder) for plan in found]
    tests = tuple(test for study in studies for test in study.tests)
    study = SizeStudy(tests, parameters, SEEDS)
    print(study)
    draw_sizes(study, IMAGES / "real_apparatus_sizes.png")
    sheet = tiled([runs(plan, given.folder) for plan in found])
    sheet.quantize(_COLOURS).save(IMAGES / "real_apparatus_runs.png", optimize=True)


if __name__ == "__main__":
    main()
