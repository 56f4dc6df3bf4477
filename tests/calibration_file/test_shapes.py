"""Particle shapes in a calibration file."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.natural_units import natural_hash
from grainfit.bulk_tests.registry import recreate_test
from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.checks import messages as of_checks
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.schema import calibration_file_schema
from grainfit.errors import InputError
from grainfit.materials.particle_shape import ASPECT_RATIO, ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.dem import messages as dem_messages
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.materials import GLASS_BEADS as BEADS

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")
DIAMETER = 'diameter = "10 mm"'
OWN = "{ spheres = [{ position = [0, 0, 0], radius = 1 }, { position = [1, 0, 0], radius = 1 }] }"


def setup_with(folder: Path, lines: str, solver: str = "lammps") -> CalibrationSetup:
    assert GLASS_BEADS.count(DIAMETER) == 1
    path = folder / "calibration.toml"
    text = GLASS_BEADS.replace(DIAMETER, f"{DIAMETER}\n{lines}")
    path.write_text(text.replace('"lammps"', f'"{solver}"'), encoding="utf-8")
    return build_calibration(load_calibration_file(path))


@pytest.mark.parametrize(
    ("lines", "key", "words"),
    [
        ('shape = "two_spheres"', "particle.aspect_ratio", "is missing for the shape two_spheres"),
        ("aspect_ratio = 1.5", "particle.aspect_ratio", "no effect on particles that are spheres"),
        (f"shape = {OWN}\naspect_ratio = 1.5", "particle.aspect_ratio", "spheres of your own"),
        (
            'shape = "two_spheres"\naspect_ratio = { min = 1.0, max = 2.5 }',
            "particle.aspect_ratio",
            "is 2.5 for two_spheres",
        ),
        ('shape = "two_sphere"\naspect_ratio = 1.5', "particle.shape", "is 'two_sphere'"),
        ("shape = 3", "particle.shape", "is 3"),
        ("shape = { spheres = [] }", "particle.shape.spheres", "has 0 entries"),
        (
            f"shape = {OWN.replace('[1, 0, 0]', '[3, 0, 0]')}",
            "particle.shape.spheres",
            "sphere 2 is apart",
        ),
        (
            f"shape = {OWN.replace('[1, 0, 0]', '[1, 0, 0, 0]')}",
            "particle.shape.spheres[1].position",
            "has 4 numbers",
        ),
    ],
)
def test_impossible_shapes_are_refused_with_key_and_value(
    tmp_path: Path, lines: str, key: str, words: str
) -> None:
    with pytest.raises(InputError) as caught:
        setup_with(tmp_path, lines)

    assert [(fault.key, words in fault.message) for fault in caught.value.faults] == [(key, True)]


def test_editors_say_that_shapes_require_an_aspect_ratio_which_has_no_default() -> None:
    keys = calibration_file_schema()["properties"]["particle"]["properties"]

    words = keys["aspect_ratio"]["description"]
    assert words.endswith("Required with a shape by name.")
    assert "by default" not in words


def test_a_free_aspect_ratio_is_a_parameter_of_runs_of_clumps(tmp_path: Path) -> None:
    free = setup_with(tmp_path, 'shape = "two_spheres"\naspect_ratio = { min = 1.0, max = 2.0 }')
    spheres = setup_with(tmp_path, "")
    solver = free.solvers["heap"]
    values = {**spheres.problem.from_unit([0.5, 0.5]), "particle.aspect_ratio": 1.5}

    assert "particle.aspect_ratio" in free.problem.intervals
    assert solver.bulk_test is not None
    run = solver.definition(values, 1)
    test = recreate_test(run)
    assert test is not None
    assert run.parameters["particle.aspect_ratio"] == 1.5
    assert (run.model["test"]["shape"], test.sizes) == ("two_spheres", solver.bulk_test.sizes)
    clump = test.scene({**BEADS, **values}, 1).sizes.clump
    assert clump is not None
    assert len(clump) == 2
    # Two spheres that touch have half the volume each.
    touching = free.problem.rayleigh_time_step({**values, "particle.aspect_ratio": 2.0})
    sphere = spheres.problem.rayleigh_time_step(values)
    assert touching is not None
    assert sphere is not None
    assert touching / sphere == pytest.approx(0.5 ** (1 / 3), rel=1e-3)


def test_shapes_are_different_runs_and_spheres_are_the_runs_that_they_were(tmp_path: Path) -> None:
    lines = {
        "spheres": "",
        "pair": 'shape = "two_spheres"\naspect_ratio = 1.5',
        "slender": 'shape = "two_spheres"\naspect_ratio = 1.6',
        "pellet": 'shape = "cylinder"\naspect_ratio = 1.5',
        "own": f"shape = {OWN}",
    }
    runs = {}
    for name, given in lines.items():
        setup = setup_with(tmp_path, given)
        values = setup.problem.from_unit([0.5, 0.5])
        runs[name] = setup.solvers["heap"].definition(values, 1)

    assert len({run.identity for run in runs.values()}) == len(lines)
    assert "shape" not in runs["spheres"].model["test"]
    assert "particle.aspect_ratio" not in runs["spheres"].parameters
    # Runs of other sizes are reused by this hash, and by the numbers of the material.
    hashes = {name: natural_hash(run) for name, run in runs.items()}
    assert len(set(hashes.values())) == len(lines) - 1
    assert hashes["pair"] == hashes["slender"]


def test_a_solver_without_clumps_refuses_them_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Liggghts, "missing", {"clumps": 'it has none; use solver = "lammps"'})
    plan = describe_plan(setup_with(tmp_path, f"shape = {OWN}", "liggghts"))

    (problem,) = plan.problems
    assert dem_messages.LACKS_CONCEPT.is_in(problem)
    assert 'use solver = "lammps"' in problem


def test_clumps_take_liggghts_one_core() -> None:
    sizes = ParticleSizes((0.01,), shape=ParticleShape("lens", aspect_ratio=1.5))
    with pytest.raises(InputError, match=dem_messages.CLUMPS_ON_ONE_CORE.pattern):
        Liggghts(Heap(sizes), BEADS, ranks=2)

    assert Liggghts(Heap(diameter="10 mm"), BEADS, ranks=2).ranks == 2


def test_check_tells_the_number_of_spheres(tmp_path: Path) -> None:
    plan = describe_plan(setup_with(tmp_path, 'shape = "lens"\naspect_ratio = 1.5'))

    assert any("1500 particles of 7 spheres" in line for line in plan.lines)


def test_clumps_whose_spheres_nearly_coincide_are_noted(tmp_path: Path) -> None:
    def noted(shape: str, ratio: str) -> list[str]:
        lines = f'shape = "{shape}"\naspect_ratio = {ratio}'
        notes = setup_with(tmp_path, lines).notes()
        return [note for note in notes if "nearly coincide" in note]

    [note] = noted("grain", "{ min = 1.0, max = 2.0 }")
    assert note.startswith("particle.aspect_ratio is 1 and more: there, spheres of the shape grain")
    assert of_checks.STIFFER_THAN_SPHERES.is_in(note)
    [note] = noted("lens", "1.2")
    assert of_checks.NEAR_SPHERES.is_in(note, share="27.9 %")
    assert "otherwise than at 1" not in note
    assert noted("two_spheres", "1.05")
    assert not noted("two_spheres", "{ min = 1.1, max = 2.0 }")
    assert not noted("grain", "1.0")
    assert not noted("grain", "1.5")


def test_a_low_restitution_slows_clumps_whose_spheres_touch_at_once(tmp_path: Path) -> None:
    lines = 'shape = "grain"\naspect_ratio = 1.5'
    setup = setup_with(tmp_path, lines)
    path = setup.file.path
    path.write_text(path.read_text(encoding="utf-8").replace("0.79", "0.3"), encoding="utf-8")

    bouncy, sluggish = setup.notes(), build_calibration(load_calibration_file(path)).notes()
    assert not any(map(of_checks.NEAR_SPHERES.is_in, bouncy))
    assert any(map(of_checks.NEAR_SPHERES.is_in, sluggish))


def test_the_time_step_follows_a_free_aspect_ratio(tmp_path: Path) -> None:
    lines = 'shape = "grain"\naspect_ratio = { min = 1.2, max = 2.0 }'
    setup = setup_with(tmp_path, lines)
    problem, sizes = setup.problem, setup.file.sizes
    assert sizes is not None

    for ratio in (1.2, 1.55, 2.0):
        values = {**problem.middle, ASPECT_RATIO: ratio}
        whole = {**setup.file.fixed, **values}
        (heap,) = setup.bulk_tests.values()
        step = heap.scene(whole, 1).time_step
        assert problem.rayleigh_time_step(values) * heap.time_step_fraction == (
            pytest.approx(step, rel=0.01)
        )
