"""`softer`, `coarser`, `smaller` in `[strategy]`: cheaper relatives of the tests."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.bulk_tests.shared import messages as of_stress
from grainfit.calibration_file import messages
from grainfit.calibration_file.plan import describe_plan
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation
from grainfit.solvers.dem import messages as of_programs
from grainfit.work_folder.saved_calibration import bulk_tests_of

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")
SOFTER = '[strategy]\nsofter = "0.09 MPa"\n'


def loaded(folder: Path, text: str) -> gf.CalibrationSetup:
    path = folder / "beads.toml"
    path.write_text(text, encoding="utf-8")
    return gf.load(path)


def test_the_relative_is_the_same_test_with_the_softer_modulus(tmp_path: Path) -> None:
    setup = loaded(tmp_path, GLASS_BEADS + SOFTER)
    softer = loaded(tmp_path, GLASS_BEADS.replace('"0.36 MPa"', '"0.09 MPa"'))
    values = setup.problem.middle
    runs = [one["heap"].definition(values, 1) for one in (setup.relatives, softer.solvers)]
    assert runs[0].identity == runs[1].identity
    assert runs[0].identity != setup.solvers["heap"].definition(values, 1).identity
    [line] = [line for line in describe_plan(setup).lines if "softer particles" in line]
    assert messages.PART_OF_SEARCH.is_in(line, share=63)
    assert setup.problem == loaded(tmp_path, GLASS_BEADS).problem
    assert loaded(tmp_path, GLASS_BEADS).relatives == {}


def test_a_plan_counts_the_runs_of_relatives_and_their_time(tmp_path: Path) -> None:
    plain = describe_plan(loaded(tmp_path, GLASS_BEADS))
    found = describe_plan(loaded(tmp_path, GLASS_BEADS + SOFTER))
    budget = describe_plan(loaded(tmp_path, GLASS_BEADS + SOFTER + "max_runs = 20\n"))
    assert plain.runs
    assert found.runs
    assert budget.runs
    # Three runs of the test and five of the relative, in place of five.
    assert found.runs[0] == plain.runs[0] + 2
    assert 20 < budget.runs[1] <= 22
    assert plain.seconds
    assert found.seconds
    assert found.seconds[0] == pytest.approx(plain.seconds[0], rel=0.1)


def test_impossible_softer_particles_are_refused_with_their_line(tmp_path: Path) -> None:
    free = GLASS_BEADS.replace('"0.36 MPa" ', '{ min = "0.1 MPa", max = "1 MPa" } ')
    springs = GLASS_BEADS.replace("[particle_wall]", "[particle_wall]\nnormal_stiffness = 900")
    cases = {
        "Young's modulus changes no": springs + '[contact_models]\ncontact = "linear"\n' + SOFTER,
        "not below": GLASS_BEADS + SOFTER.replace("0.09", "0.4"),
        "needs a fixed": free + SOFTER,
        "no meaning for the staged": GLASS_BEADS + SOFTER + 'name = "staged"\n',
    }
    for why, text in cases.items():
        with pytest.raises(InputError, match=why) as caught:
            loaded(tmp_path, text)
        assert "softer" in str(caught.value)
        assert f"line {text[: text.index('softer = ')].count(chr(10)) + 1}" in str(caught.value)


def test_particles_that_are_too_soft_are_a_fault_of_softer(tmp_path: Path) -> None:
    tests = (EXAMPLES / "three_tests" / "calibration.toml").read_text(encoding="utf-8")
    pressed = tests.replace('{ min = "5 MPa", max = "10 MPa", scale = "log" }', '"7 MPa"')
    for text, softer, why in [
        (GLASS_BEADS, "0.1", of_programs.OUTSIDE_LIMITS),
        (pressed, '"2000 Pa"', of_stress.TOO_SOFT),
    ]:
        written = f"{text}\n[strategy]\nsofter = {softer}\n"
        with pytest.raises(InputError) as caught:
            loaded(tmp_path, written)
        [fault] = caught.value.faults
        assert f"line {written.count(chr(10))}, strategy.softer: " in str(fault)
        assert messages.NO_SUCH_RELATIVE.is_in(str(fault))
        assert why.is_in(str(fault))


def test_a_model_of_the_user_has_no_softer_particles(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text("def run(p, seed):\n    return {'angle': p['friction']}\n")
    text = """
name = "own"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
function = "model.py:run"
targets.angle = { value = 0.5, tolerance = 0.1 }
"""
    with pytest.raises(InputError, match=messages.NO_TEST_HAS_RELATIVES.pattern):
        loaded(tmp_path, text + SOFTER)


def test_relatives_have_larger_or_fewer_particles(tmp_path: Path) -> None:
    setup = loaded(tmp_path, GLASS_BEADS + "[strategy]\ncoarser = 1.25\nsmaller = 0.5\n")
    real, relative = setup.bulk_tests["heap"], setup.relatives["heap"].bulk_test
    assert relative is not None
    assert relative.sizes.coarse_graining == 1.25
    assert relative.setup.cylinder_radius == pytest.approx(0.5 ** (1 / 3) * 0.06)
    assert relative.number_of_particles == pytest.approx(
        0.5 / 1.25**3 * real.number_of_particles, rel=0.05
    )
    [one] = setup.relative_costs
    assert 0.15 < one.cost < 0.35
    [line] = [line for line in describe_plan(setup).lines if messages.PART_OF_SEARCH.is_in(line)]
    assert "particles 1.25 times as large and 50 % of the particles in a smaller" in line


def test_impossible_relatives_are_refused_with_their_line(tmp_path: Path) -> None:
    cases = {
        "coarser = 0.5": "from 1 to 20",
        "smaller = 1.5": "at most 1",
        "smaller = 0.001": "makes test heap impossible: cylinder_radius",
        "coarser = 15": "makes test heap impossible: cylinder_radius",
        'smaller = 0.5\nname = "staged"': "no meaning for the staged",
    }
    for entry, why in cases.items():
        text = f"{GLASS_BEADS}[strategy]\n{entry}\n"
        with pytest.raises(InputError, match=why) as caught:
            loaded(tmp_path, text)
        line = text[: text.index(entry)].count("\n") + 1
        assert f"line {line}" in str(caught.value)


@pytest.mark.slow
@pytest.mark.thorough
def test_a_heap_is_calibrated_with_softer_particles(tmp_path: Path) -> None:
    text = GLASS_BEADS.replace(
        'type = "heap"',
        'type = "heap"\ncylinder_radius = "40 mm"\nstrike_off_height = "80 mm"\n'
        'bulk_density_top = "70 mm"\nplate_radius = "120 mm"',
    ).replace('"0.5 deg"', '"2 deg"')
    setup = loaded(tmp_path, text + SOFTER)
    made: list[Evaluation] = []

    def note(progress: gf.Progress) -> None:
        made[:] = progress.evaluations

    result = setup.calibrate(tmp_path / "work", on_progress=note, workers=2)
    assert result.status == "calibrated", result
    runs = Counter(test for one in made for test in one.runs)
    assert runs["heap (relative)"] >= 5
    assert 6 <= runs["heap"] <= 20
    saved = gf.open(tmp_path / "work")
    assert [*bulk_tests_of(saved)] == ["heap"]
    page = saved.report(tmp_path / "report.html").read_text(encoding="utf-8")
    assert "heap (relative)" in page
    assert setup.calibrate(tmp_path / "work").parameters == result.parameters
