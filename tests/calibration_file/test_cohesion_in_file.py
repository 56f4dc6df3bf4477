"""Cohesion in a calibration file: the model, its numbers, and particles that are too soft."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

import needs
from grainfit.bulk_tests.conditions import conditions_of
from grainfit.bulk_tests.heap import Heap
from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.checks import messages as of_checks
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.contact_models import messages as contact_messages
from grainfit.errors import InputError
from grainfit.materials.particle_shape import ASPECT_RATIO, ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.options.places import FileFault
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS as BEADS

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")
BETWEEN, ON_WALL = "restitution = 0.79\n", "restitution = 0.82\n"


def sticky(energy: str = "0.3", on_wall: str = "0", chosen: str = "") -> str:
    text = GLASS_BEADS.replace(BETWEEN, f"{BETWEEN}surface_energy = {energy}\n")
    text = text.replace(ON_WALL, f"{ON_WALL}surface_energy = {on_wall}\n")
    return (
        text.replace("[wall]", f'[contact_models]\ncohesion = "{chosen}"\n\n[wall]')
        if chosen
        else text
    )


def damp(chosen: str = "", solver: str = "liggghts") -> str:
    text = GLASS_BEADS.replace(BETWEEN, f'{BETWEEN}cohesion_energy_density = "2 kJ/m^3"\n')
    text = text.replace('"lammps"', f'"{solver}"')
    return (
        text.replace("[wall]", f'[contact_models]\ncohesion = "{chosen}"\n\n[wall]')
        if chosen
        else text
    )


def setup_of(folder: Path, text: str) -> CalibrationSetup:
    path = folder / "calibration.toml"
    path.write_text(text, encoding="utf-8")
    return build_calibration(load_calibration_file(path))


def identity(setup: CalibrationSetup) -> str:
    values = setup.problem.from_unit([0.5] * setup.problem.dimension)
    return setup.solvers["heap"].definition(values, 1).identity


def test_no_cohesion_is_the_run_of_a_file_without_it(tmp_path: Path) -> None:
    dry = identity(setup_of(tmp_path, GLASS_BEADS))

    assert identity(setup_of(tmp_path, sticky("0"))) == dry
    assert identity(setup_of(tmp_path, sticky("0.3"))) != dry


@needs.LIGGGHTS
def test_the_usual_model_chosen_by_name_is_the_same_run(tmp_path: Path) -> None:
    usual = identity(setup_of(tmp_path, sticky()))

    assert identity(setup_of(tmp_path, sticky(chosen="jkr"))) == usual
    assert identity(setup_of(tmp_path, sticky(chosen="dmt"))) != usual
    assert setup_of(tmp_path, damp("sjkr2")).solvers["heap"].model()["contact_models"] == ["sjkr2"]


def test_a_parameter_of_another_model_is_named(faults_of: Callable[..., list[FileFault]]) -> None:
    [fault] = faults_of(text=damp("jkr", "lammps"))

    assert fault.key == "particle_particle.cohesion_energy_density"
    assert contact_messages.NO_EFFECT(models="jkr") in str(fault)
    assert fault.line is not None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (damp(solver="lammps"), "sjkr, which lammps does not have"),
        (
            sticky().replace('"lammps"', '"liggghts"'),
            "jkr, which liggghts does not have. Use lammps",
        ),
        (sticky(chosen="dmt").replace('"lammps"', '"liggghts"'), "Use lammps or yade"),
    ],
)
def test_a_solver_without_the_model_is_refused(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        setup_of(tmp_path, text)


def test_a_chosen_model_without_cohesion_is_said_to_do_nothing(tmp_path: Path) -> None:
    dry = GLASS_BEADS.replace("[wall]", '[contact_models]\ncohesion = "dmt"\n\n[wall]')
    dry = dry.replace('"lammps"', '"liggghts"')
    for text in (dry, sticky("0", chosen="dmt")):
        lines = "\n".join(describe_plan(setup_of(tmp_path, text)).lines)
        assert (
            "The contact model dmt was chosen and does nothing: it takes "
            "particle_particle.surface_energy or particle_wall.surface_energy above 0."
        ) in lines
        assert "instead of the usual one" not in lines
    for text in (sticky(chosen="dmt"), sticky('{ min = 0, max = "0.5 J/m^2" }', chosen="dmt")):
        lines = "\n".join(describe_plan(setup_of(tmp_path, text)).lines)
        assert "Contact model instead of the usual one: dmt." in lines
        assert "does nothing" not in lines


def test_the_bond_number_is_that_of_the_intervals(tmp_path: Path) -> None:
    text = sticky('{ min = 0, max = "0.5 J/m^2" }', "0.1")
    lines = [line for line in describe_plan(setup_of(tmp_path, text)).lines if "Bond" in line]

    # 3 pi gamma R* over the weight of a bead of the lowest density, with R* = 2.5 mm and 5 mm.
    assert "Cohesion (jkr), two particles, 10 mm: Bond number 0 to 1.6 (attraction" in lines[0]
    assert "Cohesion (jkr), a particle and a wall, 10 mm: Bond number 0.33 to 0.65" in lines[1]
    # Where nothing else is cohesive, the lower end of the interval is dry.
    alone = describe_plan(setup_of(tmp_path, sticky('{ min = 0, max = "0.5 J/m^2" }', "0"))).lines
    assert any("two particles, 10 mm: Bond number 0 to 1.6 (attraction" in line for line in alone)
    dry = describe_plan(setup_of(tmp_path, GLASS_BEADS)).lines
    assert not any("Cohesion" in line for line in dry)


def test_particles_that_are_too_soft_for_their_cohesion_are_refused(tmp_path: Path) -> None:
    problems = describe_plan(setup_of(tmp_path, sticky('{ min = 0, max = "20 J/m^2" }'))).problems
    assert contact_messages.TOO_SOFT.is_in(problems[0])
    assert contact_messages.TOO_SOFT.is_in(problems[0], overlap=9.4)
    assert "Give them at least 9.6e+05 Pa, or less cohesion" in problems[0]

    stiff = sticky('{ min = 0, max = "20 J/m^2" }').replace('"0.36 MPa"', '"0.96 MPa"')
    assert describe_plan(setup_of(tmp_path, stiff)).problems == ()


def test_the_smallest_spheres_of_clumps_decide_whether_they_are_too_soft(tmp_path: Path) -> None:
    text = sticky('{ min = 0, max = "7 J/m^2" }')
    slender = text.replace(
        'diameter = "10 mm"',
        'diameter = "10 mm"\nshape = "lens"\naspect_ratio = { min = 1.5, max = 3.0 }',
    )
    assert describe_plan(setup_of(tmp_path, text)).problems == ()
    [problem] = describe_plan(setup_of(tmp_path, slender)).problems
    assert contact_messages.TOO_SOFT.is_in(problem)


def test_the_finest_of_several_sizes_has_its_own_bond_number(tmp_path: Path) -> None:
    text = sticky('"0.5 J/m^2"').replace(
        '"10 mm"',
        '[{ value = "5 mm", mass_fraction = 0.5 }, { value = "10 mm", mass_fraction = 0.5 }]',
    )
    lines = "\n".join(describe_plan(setup_of(tmp_path, text)).lines)
    # 1 / (0.5 / 5 mm + 0.5 / 10 mm); the Bond number falls with the square of the diameter.
    assert "two particles, 6.67 mm (Sauter diameter): Bond number" in lines
    numbers = [float(n) for n in re.findall(r"two particles, .*?Bond number \S+ to (\S+)", lines)]
    assert numbers[1] / numbers[0] == pytest.approx((20 / 3 / 5) ** 2, rel=0.05)


def test_a_time_step_that_is_too_large_for_cohesion_is_named(tmp_path: Path) -> None:
    undamped = '"lammps"\ntime_step_fraction = 0.15'
    free = sticky('{ min = 0, max = "0.5 J/m^2" }').replace('"lammps"', undamped)
    free = free.replace("rolling_damping = 0.25", "rolling_damping = 0")

    assert any(
        of_checks.LARGE_TIME_STEP.is_in(note, safe=0.12)
        for note in setup_of(tmp_path, free).notes()
    )
    dry = free.replace('{ min = 0, max = "0.5 J/m^2" }', "0")
    assert not any(
        of_checks.LARGE_TIME_STEP.is_in(note) for note in setup_of(tmp_path, dry).notes()
    )


@pytest.mark.parametrize(
    ("text", "fraction"),
    [
        (sticky(), 0.12),
        (sticky().replace("0.79", "0.2"), 0.05),
        (sticky('{ min = 0, max = "0.5 J/m^2" }').replace("0.79", "0.2"), 0.05),
        (damp().replace("0.79", "0.2"), 0.05),
        # Without cohesion, the default is what it was.
        (sticky("0").replace("0.79", "0.2"), 0.09),
    ],
)
def test_cohesion_and_low_restitution_shorten_the_time_step_that_is_the_default(
    tmp_path: Path, text: str, fraction: float
) -> None:
    assert conditions_of(setup_of(tmp_path, text).bulk_tests["heap"]).time_step_fraction == fraction


@pytest.mark.parametrize("energy", ['"0.1 J/m^2"', '{ min = 0, max = "0.1 J/m^2" }'])
def test_a_cohesive_material_on_two_solvers_is_noted(tmp_path: Path, energy: str) -> None:
    text = sticky(energy, chosen="dmt").replace("rolling_damping = 0.25", "rolling_damping = 0")
    packing = 'type = "packing"\nsolver = "yade"\ntargets.bulk_density = { value = 1400 }'
    text = text.replace("[[test]]", f"[[test]]\n{packing}\n\n[[test]]")
    [note] = [
        note
        for note in setup_of(tmp_path, text).notes()
        if contact_messages.SOLVERS_DIFFER.is_in(note)
    ]

    assert "Rolling friction is not quite the same in YADE" in note
    assert "LAMMPS plus twice the pull-off force: cohesive beds do not agree" in note


def test_two_models_that_are_both_free_are_refused(tmp_path: Path) -> None:
    both = sticky('{ min = 0, max = "0.5 J/m^2" }').replace(
        BETWEEN, f'{BETWEEN}cohesion_energy_density = {{ min = 0, max = "1 kJ/m^3" }}\n'
    )
    with pytest.raises(InputError, match=contact_messages.CONTRADICTION.pattern):
        setup_of(tmp_path, both)


def test_the_example_of_a_cohesive_material_is_ready() -> None:
    plan = describe_plan(
        build_calibration(load_calibration_file(EXAMPLES / "cohesive_sand" / "calibration.toml"))
    )
    assert plan.problems == ()
    assert any("Cohesion (jkr)" in line for line in plan.lines)


def test_an_aspect_ratio_that_no_clump_has_is_the_only_fault_of_its_interval() -> None:
    heap = Heap(ParticleSizes((0.01,), shape=ParticleShape("two_spheres")))
    material = {**BEADS, "particle_particle.surface_energy": 0.1}
    [fault] = Lammps(heap, material).interval_faults({ASPECT_RATIO: (1.1, 2.5)})
    assert fault.key == ASPECT_RATIO
