"""The example of a box over a plate: its measurement, and a small one in a real solver."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grainfit.bulk_tests.own_scene import OwnScene
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.errors import NotMeasurableError
from grainfit.scenes import RunOutput
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps

PLATE = Path(__file__).parents[2] / "examples" / "plate_discharge"
DIAMETER = 0.01
SMALL: dict[str, Any] = {"width": 0.28, "plate": 0.2, "depth": 0.05, "fill_height": 0.08}


@pytest.fixture
def plate_box() -> Any:
    spec = importlib.util.spec_from_file_location("plate_box", PLATE / "plate_box.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def pile(angle: float, half: float, depth: float) -> Any:
    """Return a run whose spheres fill a straight-sided pile, and some that have left it."""
    x, y, z = np.meshgrid(
        np.arange(-half + 0.001, half, 0.002),
        np.arange(0.001, depth, 0.002),
        np.arange(0.001, half, 0.002),
        indexing="ij",
    )
    below = z < (half - np.abs(x)) * math.tan(math.radians(angle))
    inside = np.column_stack([x[below], y[below], z[below]])
    gone = inside - [0.0, 0.0, 0.1]
    positions = np.vstack([inside, gone])
    end = SimpleNamespace(positions=positions, radii=np.full(len(positions), 0.001))
    return SimpleNamespace(snapshot=lambda _name: end)


@pytest.mark.parametrize("angle", [12.0, 20.0, 33.0])
def test_the_inclination_of_a_straight_pile_is_measured(plate_box: Any, angle: float) -> None:
    sizes = SimpleNamespace(sauter_diameter=DIAMETER)
    options = {"plate": 0.6, "depth": 0.05}

    value, error = plate_box.measure(pile(angle, 0.3, 0.05), sizes, options)["angle_of_repose"]

    assert value == pytest.approx(angle, abs=0.5)
    assert error < 0.3


def test_a_plate_with_hardly_a_layer_has_no_angle(plate_box: Any) -> None:
    sizes = SimpleNamespace(sauter_diameter=DIAMETER)

    with pytest.raises(NotMeasurableError, match="lower than 4 particle diameters"):
        plate_box.measure(pile(4.0, 0.3, 0.05), sizes, {"plate": 0.6, "depth": 0.05})


@pytest.mark.parametrize("end_walls", [pytest.param(False, marks=pytest.mark.thorough), True])
def test_a_pile_stays_on_the_plate_and_the_rest_leaves_the_box(
    tmp_path: Path, end_walls: bool
) -> None:
    file = load_calibration(PLATE / "calibration.toml").file
    scene, measure = (f"{PLATE}/plate_box.py:{name}" for name in ("scene", "measure"))
    box = OwnScene(
        file.sizes, scene=scene, measure=measure, options={**SMALL, "end_walls": end_walls}
    )
    material = {**file.fixed, "particle_particle.sliding_friction": 0.5}

    found = Lammps(box, material).run({}, 1, Workspace(tmp_path, timeout=120.0))

    assert 12.0 < found["angle_of_repose"].value < 45.0
    x, y, z = RunOutput(tmp_path).snapshot("end").positions.T
    assert (np.abs(x[z > 0]) < 0.11).all()
    # Between end walls no centre is nearer to them than a radius, but for the overlap.
    margin = 0.4 * DIAMETER if end_walls else 0.0
    assert ((y >= margin) & (y <= 0.05 - margin)).all()


def test_the_file_is_ready_to_run() -> None:
    plan = describe_plan(load_calibration(PLATE / "calibration.toml"))

    assert plan.problems == ()
