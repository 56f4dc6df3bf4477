"""`grainfit design` and `gf.design`: a file from before the laboratory."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
import needs
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.shared import messages as of_shared
from grainfit.calibration_file.planned import load_planned_file
from grainfit.cli.app import app
from grainfit.evaluation import Evaluation, Proposal
from grainfit.problem import messages as of_problem
from grainfit.solvers.own_model import table_messages
from grainfit.which_test import messages
from grainfit.which_test.available import available_tests, material_of
from grainfit.which_test.knowledge import Knowledge
from grainfit.which_test.measurement_plan import rank_combinations
from grainfit.which_test.simulation import failure_remarks

SLIDING, ROLLING = "particle_particle.sliding_friction", "particle_particle.rolling_friction"
ENERGY = "particle_particle.surface_energy"
SHAPED = 'diameter = "10 mm"\nshape = "two_spheres"\naspect_ratio = { min = 1.1, max = 2 }'
FILE = """\
name = "my sand"
[particle]
diameter = "10 mm"
youngs_modulus = "10 MPa"
poissons_ratio = 0.22
density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }
[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"
[particle_particle]
sliding_friction = { min = 0.1, max = 0.9 }
rolling_friction = { min = 0.05, max = 0.6 }
restitution = 0.6
rolling_damping = 0.25
[particle_wall]
sliding_friction = 0.4
rolling_friction = 0.1
restitution = 0.6
rolling_damping = 0.25
[[test]]
type = "heap"
plate_sliding_friction = 0.5
plate_rolling_friction = "particle_particle"
solver = "lammps"
"""
MEASURED = (
    FILE
    + """\
targets.bulk_density = { value = "1300 kg/m^3", uncertainty = "1 %" }
targets.angle_of_repose = { value = "22 deg", uncertainty = "0.5 deg" }
"""
)


@pytest.fixture
def plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path / "plan.toml"


def command(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["design", *arguments])


def accuracies(path: Path, given: dict[str, Accuracy] | None = None) -> dict[str, Accuracy | None]:
    planned = load_planned_file(path)
    test = planned.solvers["heap"].bulk_test
    assert test is not None
    return {n: planned.accuracy(given or {}, "heap", n, i) for n, i in test.responses.items()}


def test_a_test_without_targets_is_measured_in_all_its_responses(plan: Path) -> None:
    plan.write_text(FILE)
    found = accuracies(plan)
    assert found["bulk_density"] == Accuracy(0.01, is_share=True)
    assert found["angle_of_repose"] == Accuracy(1.0)
    assert None not in found.values()


def test_a_table_is_a_model_of_ones_own_and_names_its_responses_as_targets(plan: Path) -> None:
    (plan.parent / "runs.csv").write_text("friction,angle\n0.2,20\n0.8,30\n")
    table = (
        'name = "sand"\nparameters.friction = { min = 0.1, max = 0.9 }\n'
        '[[test]]\ntype = "table"\nfile = "runs.csv"\n'
    )
    plan.write_text(table)
    of_table = re.escape("targets: ") + table_messages.NO_RESPONSES.matching()
    with pytest.raises(gf.InputError, match=of_table):
        gf.design(plan)
    target = 'targets.angle = { value = 25, uncertainty = "1 %" }\n'
    for planned in (target, "targets.angle = {}\n"):
        plan.write_text(table + planned)
        with pytest.raises(gf.InputError, match=messages.ONLY_OWN_MODELS.matching()):
            gf.design(plan)


def test_targets_without_values_say_what_can_be_measured_and_how_well(plan: Path) -> None:
    plan.write_text(FILE + 'targets.angle_of_repose = { uncertainty = "0.5 deg" }\n')
    found = accuracies(plan)
    assert found == {**dict.fromkeys(found, None), "angle_of_repose": Accuracy(0.5)}
    better = {"angle_of_repose": Accuracy(0.1)}
    assert accuracies(plan, better)["angle_of_repose"] == Accuracy(0.1)
    plan.write_text(FILE + "targets.angle_of_repose = {}\n")
    assert accuracies(plan)["angle_of_repose"] == Accuracy(1.0)


def test_a_file_with_measurements_is_a_plan_too(plan: Path) -> None:
    plan.write_text(MEASURED)
    assert accuracies(plan)["angle_of_repose"] == Accuracy(0.5)
    planned = load_planned_file(plan)
    test = planned.solvers["heap"].bulk_test
    assert test is not None
    assert planned.value("heap", "bulk_density", test.responses["bulk_density"]) == 1300
    assert planned.value("heap", "heap_height", test.responses["heap_height"]) == 0.053


def test_correlations_of_a_file_with_measurements_are_checked(plan: Path) -> None:
    pair = '[["bulk_density", "{}", 0.5]]'
    plan.write_text(MEASURED + f"correlations = {pair.format('angle_of_repose')}\n")
    assert load_planned_file(plan).solvers.keys() == {"heap"}
    plan.write_text(MEASURED + f"correlations = {pair.format('angle')}\n")
    with pytest.raises(gf.InputError, match=of_problem.NO_TARGET_HERE.matching(name="angle")):
        load_planned_file(plan)


def test_a_heap_and_further_tests_settle_both_frictions(plan: Path) -> None:
    plan.write_text(MEASURED)
    found = gf.design(plan, wanted=0.3)
    assert found.best is not None
    assert found.best.name.startswith("heap + ")
    assert max(found.best.half_widths.values()) <= 0.3
    alone = next(c for c in found.combinations if c.name == "heap")
    assert alone.half_widths[SLIDING] > 0.6 > 2 * found.best.half_widths[SLIDING]
    compared = {test.name for c in found.combinations for test in c.tests}
    assert compared >= {"heap", "draw_down", "compression", "discharge", "packing"}


def test_a_response_that_the_file_leaves_out_is_named_where_it_pays(plan: Path) -> None:
    fixed = FILE.replace("{ min = 0.1, max = 0.9 }", "0.5")
    plan.write_text(fixed + MEASURED.removeprefix(FILE), encoding="utf-8")
    assert any("of heap as well" in words for words in gf.design(plan).remarks)
    plan.write_text(fixed, encoding="utf-8")
    assert not any("as well" in words for words in gf.design(plan).remarks)


PELLETS = SHAPED.replace("two_spheres", "cylinder")


def _cohesive(of_particles: str) -> str:
    energy = 'surface_energy = { min = "0 J/m^2", max = "1 J/m^2" }\n[particle_wall]'
    return FILE.replace("[particle_wall]", energy).replace('diameter = "10 mm"', of_particles)


def test_a_parameter_of_which_the_atlas_tells_in_some_tests_counts_there(plan: Path) -> None:
    plan.write_text(_cohesive('diameter = "10 mm"'))
    found = gf.design(plan, wanted=0.3)
    assert found.before.names == ("particle.density", SLIDING, ROLLING, ENERGY)
    words = str(found)
    [told] = [line for line in found.remarks if messages.EFFECT_ON_TESTS_NOT_TOLD.is_in(line)]
    assert "shear" in told
    assert "packing" not in told
    [stand_in] = [line for line in found.remarks if messages.ATLAS_OF_DRY_SPHERES.is_in(line)]
    assert "hopper" in stand_in
    assert "heap" not in stand_in
    assert not messages.COUNTS_AS_KNOWN.is_in(words)


def test_a_parameter_of_which_the_atlas_does_not_tell_counts_as_known(plan: Path) -> None:
    plan.write_text(_cohesive(PELLETS.replace("{ min = 1.1, max = 2 }", "1.5")))
    found = gf.design(plan, wanted=0.3)
    assert found.before.names == ("particle.density", SLIDING, ROLLING)
    words = str(found)
    assert messages.COUNTS_AS_KNOWN.is_in(words, name=ENERGY)
    assert "a shear test" in words
    assert "that settles every other free parameter to ± 30 %." in words
    assert f"settles {ENERGY}" not in words
    assert messages.ATLAS_OF_DRY_SPHERES.is_in(words)


@needs.LIGGGHTS
def test_a_cohesion_energy_density_can_be_determined_by_a_heap(plan: Path) -> None:
    cohesive = FILE.replace(
        "[particle_wall]", "cohesion_energy_density = { min = 0, max = 2000 }\n[particle_wall]"
    )
    plan.write_text(cohesive.replace('"lammps"', '"liggghts"'))
    words = " ".join(str(gf.design(plan, wanted=0.3)).split())
    name = "particle_particle.cohesion_energy_density"
    assert f"To determine {name}: the angle of repose of a heap" in words


def test_nothing_is_compared_where_the_atlas_does_not_tell_of_any_parameter(plan: Path) -> None:
    fixed = re.sub(r'= \{ min = ("[^"]*"|\S+), max = .* \}', r"= \1", FILE)
    plan.write_text(fixed.replace('diameter = "10 mm"', PELLETS))
    found = gf.design(plan)
    assert found.best is None
    assert messages.NO_TEST_COMPARED.is_in(str(found))
    assert "photographs of particles" in str(found)


def test_tests_that_the_material_does_not_allow_are_named(plan: Path) -> None:
    plan.write_text(MEASURED.replace("10 MPa", "0.36 MPa"))
    found = gf.design(plan, wanted=0.3)
    assert "Not compared: compression." in str(found)


COARSE = FILE.replace('"10 mm"', '"10 mm"\ncoarse_graining = 2.5').replace("10 MPa", "30 MPa")


def test_tests_that_are_not_those_of_the_file_are_sized_for_enlarged_particles(plan: Path) -> None:
    plan.write_text(COARSE)
    found = " ".join(str(gf.design(plan)).split())
    for why in re.findall(r"Not compared: \w+\. ([^.]*\.)", found):
        assert why == messages.NOT_IN_ATLAS()
    assert messages.SIZED_FOR_PARTICLES.is_in(
        found, tests="drum, funnel, hopper, packing, shear, shear_cell and tapped"
    )
    assert messages.SIZED_FOR_PARTICLES.is_in(found, factor=2.5)

    setup = load_planned_file(plan)
    material = material_of(setup.solvers, {p.name: p.minimum for p in setup.file.parameters})
    bench = available_tests(setup.file.parameters, setup.solvers, material)
    discharge = bench.solvers["discharge"].bulk_test
    large = gf.tests.Discharge(diameter="25 mm").definition()
    assert discharge is not None
    # The time step follows from the contact law, and not from the size.
    own = {"coarse_graining": 2.5, "time_step_fraction": discharge.time_step_fraction}
    assert discharge.definition() == {**large, **own}
    assert bench.solvers.keys() >= {"compression", "discharge", "draw_down", "packing", "shear"}

    plan.write_text(FILE)
    assert "sized for" not in str(gf.design(plan))


def test_a_candidate_that_would_arch_is_left_out_before_any_run(plan: Path) -> None:
    """Slots have five diameters of equal volume; a slender pellet is twice as long."""
    slender = COARSE.replace("coarse", 'shape = "cylinder"\naspect_ratio = 3\ncoarse')
    plan.write_text(slender)
    found = " ".join(str(gf.design(plan)).split())
    arches = of_shared.ENLARGED_PARTICLES_ARCH.matching(opening="a slot", width=0.125, times=2.59)
    assert re.search(rf"Not compared: discharge\. slot_width: {arches}", found)
    assert "packing, shear, shear_cell and tapped: their apparatus" in found


@pytest.mark.slow
def test_slopes_of_enlarged_particles_are_simulated(plan: Path) -> None:
    text = COARSE.replace("rolling_friction = { min = 0.05, max = 0.6 }", "rolling_friction = 0.2")
    text = text.replace("30 MPa", "0.5 MPa")
    plan.write_text(text.replace('{ min = "1400 kg/m^3", max = "2800 kg/m^3" }', "2500"))
    found = gf.design(plan, tests=["packing"], simulate=True, seeds=1, workers=2)
    assert [row.name for row in found.combinations] == ["packing"]
    assert "failed" not in str(found)


def test_the_command_prints_combinations_and_a_recommendation(plan: Path) -> None:
    plan.write_text(FILE)
    done = command(str(plan), "--wanted", "30%", "--accuracy", "angle_of_repose=0.5 deg")
    assert done.exit_code == 0
    assert "heap + " in done.stdout
    assert "that settles every free parameter to ± 30 %." in " ".join(done.stdout.split())
    only = command(str(plan), "--test", "packing")
    assert "packing" in only.stdout
    assert "draw_down" not in only.stdout.partition("No combination")[0]


@pytest.mark.parametrize(
    ("text", "arguments", "message"),
    [
        (FILE, ["--wanted", "0%"], r"wanted: is '0%'.*as 20%"),
        (FILE, ["--wanted", "much"], r"wanted: is 'much'"),
        (FILE, ["--accuracy", "mass_flow=3 deg"], r"accuracy\.mass_flow.*kg/s"),
        (FILE, ["--accuracy", "mass_flow"], r"'mass_flow' has no value"),
        (FILE, ["--accuracy", "angel_of_repose=1 deg"], r'Did you mean "angle_of_repose"'),
        (FILE, ["--test", "heep"], r"'heep' is not a bulk test.*heap"),
        (FILE, ["--max-time", "10"], r"max-time.*no unit"),
        (FILE, ["--max-time", "0 s"], r"max-time.*above 0"),
        (
            FILE,
            ["--max-time", "5 min", "--seeds", "2"],
            r"^seeds: .*\nmax-time: is for",
        ),
        (FILE + "targets.angle_of_repose = 1\n", [], r"line \d+, test 1, targets.*a table"),
        (FILE + 'targets.bulk_density = { uncertainty = "0 %" }\n', [], r"above 0 %"),
        (FILE + 'targets.angle = { uncertainty = "1 deg" }\n', [], r"angle_of_repose"),
        (FILE.partition("[[test]]")[0], [], r"test: is missing"),
        (FILE.replace('solver = "lammps"', ""), [], r"solver.*missing"),
        (
            FILE.partition("[[test]]")[0] + '[[test]]\ntype = "python"\nfunction = "m.py:f"\n',
            [],
            r"models of your own",
        ),
    ],
)
def test_bad_input_is_named(plan: Path, text: str, arguments: list[str], message: str) -> None:
    plan.write_text(text)
    (plan.parent / "m.py").write_text("def f(parameters, seed): return {'y': 1.0}\n")
    error = command(str(plan), *arguments).exception
    assert isinstance(error, gf.GrainfitError)
    assert re.search(message, str(error), re.DOTALL)


def test_a_plan_is_no_calibration(plan: Path) -> None:
    plan.write_text(FILE + 'targets.angle_of_repose = { uncertainty = "0.5 deg" }\n')
    with pytest.raises(gf.InputError, match="measured value"):
        gf.load(plan)


def test_runs_that_failed_are_said_of_a_test_that_is_compared_without_them() -> None:
    reason = "angle_of_repose could not be measured: the heap reaches the border"
    good = Evaluation(Proposal({SLIDING: 0.3}, 1, "design"), {}, {})
    bad = Evaluation(Proposal({SLIDING: 0.8}, 1, "design"), {}, {"heap": reason})
    (words,) = failure_remarks(["heap", "packing"], [good, bad, bad])
    assert words == f"heap: 2 of 3 runs failed and do not count. The first: {reason}."


def test_a_plan_without_any_usable_test_says_nothing_about_the_tests() -> None:
    before = Knowledge((SLIDING,), np.array([[0.1]]))
    plan = rank_combinations([], before, 0.2, ["Not compared: heap. Too few."], "")
    assert str(plan).split("\n")[0] == "No test could be compared."
    assert "settles" not in str(plan)
