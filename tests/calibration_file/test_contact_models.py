"""The choice of contact models in a calibration file, and notes on solvers and time steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.bulk_tests.conditions import conditions_of
from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.checks import messages as of_checks
from grainfit.calibration_file.load import load_calibration_file
from grainfit.contact_models import messages as contact_messages
from grainfit.errors import InputError
from grainfit.options.places import FileFault
from grainfit.solvers.dem import messages as of_dem
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.program import DeckSolver

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")
DAMPED = "rolling_damping = 0.25\n"
UNDAMPED = GLASS_BEADS.replace(DAMPED, "")
PACKING = (
    '\n[[test]]\ntype = "packing"\nsolver = "{solver}"\ntargets.bulk_density = {{ value = 1500 }}\n'
)


def choosing(model: str, text: str = UNDAMPED) -> str:
    return text.replace("[particle]", f'[contact_models]\nrolling = "{model}"\n\n[particle]')


def setup_of(folder: Path, text: str) -> CalibrationSetup:
    path = folder / "calibration.toml"
    path.write_text(text, encoding="utf-8")
    return build_calibration(load_calibration_file(path))


def identity(setup: CalibrationSetup) -> str:
    values = setup.problem.from_unit([0.5] * setup.problem.dimension)
    return setup.solvers["heap"].definition(values, 1).identity


def test_without_a_dashpot_no_damping_is_asked_for(tmp_path: Path) -> None:
    setup = setup_of(tmp_path, choosing("epsd2"))
    run = setup.solvers["heap"].definition(setup.problem.from_unit([0.5, 0.5]), 1)

    assert run.model["contact_models"] == ["epsd2"]
    assert not any("rolling_damping" in name for name in run.parameters)


@pytest.mark.parametrize(
    ("change", "fraction"),
    [
        ({}, 0.19),
        ({"0.36 MPa": "10 MPa"}, 0.33),
        ({'"0.36 MPa"': '{ min = "0.1 MPa", max = "10 MPa" }'}, 0.15),
        ({"0.79": "0.5"}, 0.16),
        ({"0.79": "{ min = 0.1, max = 0.9 }"}, 0.07),
        ({"rolling_damping = 0.25": "rolling_damping = 1"}, 0.06),
        ({"rolling_damping = 0.25": "rolling_damping = { min = 0, max = 1 }"}, 0.06),
        ({"0.891": "2.5"}, 0.07),
        ({"0.891": "2.5", "rolling_damping = 0.25": "rolling_damping = 0"}, 0.18),
    ],
)
def test_the_time_step_follows_restitution_and_rolling(
    tmp_path: Path, change: dict[str, str], fraction: float
) -> None:
    text = GLASS_BEADS
    for old, new in change.items():
        assert old in text
        text = text.replace(old, new)
    heap = setup_of(tmp_path, text).bulk_tests["heap"]

    assert conditions_of(heap).time_step_fraction == fraction


def test_low_restitution_shortens_the_time_step_that_is_the_default(tmp_path: Path) -> None:
    text = choosing("epsd2").replace("restitution = 0.79", "restitution = 0.1")
    heap = setup_of(tmp_path, text).bulk_tests["heap"]

    assert conditions_of(heap).time_step_fraction == 0.07


def test_a_given_time_step_is_kept(tmp_path: Path) -> None:
    text = choosing("epsd2").replace('"lammps"', '"lammps"\ntime_step_fraction = 0.1')
    heap = setup_of(tmp_path, text).bulk_tests["heap"]

    assert conditions_of(heap).time_step_fraction == 0.1


def test_the_usual_model_chosen_by_name_is_the_same_run(tmp_path: Path) -> None:
    usual = setup_of(tmp_path, GLASS_BEADS)

    assert identity(setup_of(tmp_path, choosing("epsd", GLASS_BEADS))) == identity(usual)
    assert identity(setup_of(tmp_path, choosing("epsd2"))) != identity(usual)
    assert "contact_models" not in usual.solvers["heap"].model()


def test_damping_of_a_model_without_dashpot_is_named(
    faults_of: Callable[..., list[FileFault]],
) -> None:
    faults = faults_of(text=choosing("epsd2", GLASS_BEADS))

    assert [fault.key for fault in faults] == [
        "particle_particle.rolling_damping",
        "particle_wall.rolling_damping",
    ]
    assert contact_messages.NO_EFFECT(models="epsd2") in str(faults[0])
    assert faults[0].line is not None


def test_the_usual_model_asks_for_its_damping(faults_of: Callable[..., list[FileFault]]) -> None:
    faults = faults_of(text=choosing("epsd"))
    assert {fault.key.rpartition(".")[2] for fault in faults} == {"rolling_damping"}


@pytest.mark.parametrize("model", ["epsd3", "hertz_mindlin"])
def test_a_model_that_there_is_not_is_named(
    faults_of: Callable[..., list[FileFault]], model: str
) -> None:
    faults = faults_of(text=choosing(model, GLASS_BEADS))
    assert faults[0].key == "contact_models.rolling"
    assert "epsd" in faults[0].remedy


#: Springs of particles and walls, and no rolling friction that YADE cannot compute beside them.
SPRINGS = "normal_stiffness = {stiffness}\ntangential_stiffness = {tangential}\n"


def linear(text: str = UNDAMPED, **springs: str) -> str:
    """Return the file with linear springs, given or from Young's modulus."""
    given = SPRINGS.format(**springs) if springs else ""
    for section in ("[particle_particle]", "[particle_wall]"):
        text = text.replace(section, f"{section}\nrolling_damping = 0\n{given}")
    return text.replace("[particle]", '[contact_models]\ncontact = "linear"\n\n[particle]')


@pytest.mark.parametrize(
    ("text", "fraction"),
    [
        # The collision time follows sqrt(m / k): independent of E where the springs follow from it.
        (linear(), 0.04),
        (linear().replace("0.36 MPa", "10 MPa"), 0.04),
        # The springs of the modulus are 1892 N/m; a ninth of them has three times the step.
        (linear(stiffness='"1892 N/m"', tangential='"1658 N/m"'), 0.04),
        (linear(stiffness='"210 N/m"', tangential='"184 N/m"'), 0.13),
        (linear(stiffness='{ min = "210 N/m", max = "1892 N/m" }', tangential="1658"), 0.04),
        # Coarse-grained, they are stiffer by the factor, and the mass is larger by its cube.
        (
            linear(stiffness='"1892 N/m"', tangential='"1658 N/m"').replace(
                'diameter = "10 mm"', 'diameter = "10 mm"\ncoarse_graining = 1.4'
            ),
            0.04,
        ),
        # A stiff pair does not end at 0 %.
        (linear(stiffness='"2e6 N/m"', tangential='"1.7e6 N/m"'), 0.0013),
        (linear().replace("0.79", "0.2"), 0.02),
    ],
)
def test_the_time_step_of_linear_springs_follows_the_collision_time(
    tmp_path: Path, text: str, fraction: float
) -> None:
    heap = setup_of(tmp_path, text).bulk_tests["heap"]

    assert conditions_of(heap).time_step_fraction == fraction


def test_springs_are_told_where_linear_contacts_are_not_chosen(
    faults_of: Callable[..., list[FileFault]],
) -> None:
    text = linear(stiffness="900", tangential="300").replace('contact = "linear"', "")
    faults = faults_of(text=text)

    assert {fault.key.rpartition(".")[2] for fault in faults} == {
        "normal_stiffness",
        "tangential_stiffness",
    }
    assert contact_messages.NOT_CHOSEN(model="linear", kind="contact") in str(faults[0])


SIZES = '[{ value = "8 mm", mass_fraction = 0.5 }, { value = "12 mm", mass_fraction = 0.5 }]'
COHESIVE = '[particle_particle]\nsurface_energy = "0.1 J/m^2"'


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ({'"lammps"': '"yade"'}, "particle_wall.rolling_friction", "use lammps or liggghts"),
        ({"[particle_particle]": COHESIVE}, "particle_particle.surface_energy", "Set it to 0."),
        ({'"lammps"': '"liggghts"', '"10 mm"': SIZES}, "diameter", "Use lammps"),
    ],
)
def test_what_a_solver_cannot_compute_beside_linear_springs_is_refused(
    tmp_path: Path, change: dict[str, str], key: str, words: str
) -> None:
    text = linear()
    for old, new in change.items():
        assert old in text
        text = text.replace(old, new)
    with pytest.raises(InputError) as caught:
        setup_of(tmp_path, text)

    [fault] = [one for one in caught.value.faults if one.key.endswith(key)]
    assert words in fault.remedy


def test_a_free_rolling_friction_is_refused_before_a_run_of_yade(tmp_path: Path) -> None:
    text = linear().replace('"lammps"', '"yade"')
    setup = setup_of(tmp_path, text.replace("rolling_friction = 0.005", "rolling_friction = 0"))
    intervals = {p.name: (p.minimum, p.maximum) for p in setup.problem.parameters}
    [fault] = setup.solvers["heap"].interval_faults(intervals)

    assert fault.key == "particle_particle.rolling_friction"


def test_a_time_step_that_is_given_is_refused_where_linear_springs_need_a_shorter_one(
    tmp_path: Path,
) -> None:
    setup = setup_of(tmp_path, linear())
    intervals = {p.name: (p.minimum, p.maximum) for p in setup.problem.parameters}
    own = setup.solvers["heap"]
    assert isinstance(own, DeckSolver)
    assert own.interval_faults(intervals) == []
    usual = Lammps(
        replace(own.test, time_step_fraction=0.12), own.material, contact_models=["linear"]
    )
    [fault] = usual.interval_faults(intervals)

    assert fault.key == "time_step_fraction"
    assert fault.remedy == "Give at most 0.04."
    with pytest.raises(InputError, match=of_dem.LONG_TIME_STEP.pattern):
        gf.calibrate(setup.problem, usual, workdir=tmp_path / "heap.grainfit")


def test_overlaps_of_hertz_contacts_are_not_told_of_linear_springs(tmp_path: Path) -> None:
    assert "The particles are soft" in notes_of(tmp_path, GLASS_BEADS)
    assert "The particles are soft" not in notes_of(tmp_path, linear())


def notes_of(folder: Path, text: str) -> str:
    return "\n".join(setup_of(folder, text).notes())


def test_a_material_that_crosses_solvers_is_named_with_the_size_of_the_effect(
    tmp_path: Path,
) -> None:
    crossing = GLASS_BEADS + PACKING.format(solver="liggghts")

    assert "run with lammps and liggghts. LAMMPS has one" in notes_of(tmp_path, crossing)
    assert "LAMMPS limits the rolling dashpot" in notes_of(tmp_path, crossing)
    assert "0.5° (glass beads) to 2°" in notes_of(tmp_path, crossing)
    undamped = crossing.replace(DAMPED, "rolling_damping = 0\n")
    assert "up to 0.5 % lower" in notes_of(tmp_path, undamped)
    assert "dashpot" not in notes_of(tmp_path, undamped)
    without = choosing("epsd2", crossing.replace(DAMPED, ""))
    assert "run with" not in notes_of(tmp_path, without)
    one_solver = GLASS_BEADS + PACKING.format(solver="lammps")
    assert "run with" not in notes_of(tmp_path, one_solver)


@pytest.mark.parametrize(
    ("text", "fraction", "safe"),
    [
        (GLASS_BEADS, 0.25, "0.19"),
        (GLASS_BEADS.replace("rolling_damping = 0.25", "rolling_damping = 0.6"), 0.15, "0.1"),
        (choosing("epsd2"), 0.25, "0.19"),
        (choosing("epsd2"), 0.19, None),
        (GLASS_BEADS.replace(DAMPED, "rolling_damping = 0\n"), 0.19, None),
        (GLASS_BEADS, 0.12, None),
        (GLASS_BEADS.replace("restitution = 0.79", "restitution = 0.1"), 0.12, "0.07"),
        (GLASS_BEADS.replace("0.79", "{ min = 0.1, max = 0.9 }"), 0.12, "0.07"),
    ],
)
def test_a_time_step_beyond_the_safe_one_is_named(
    tmp_path: Path, text: str, fraction: float, safe: str | None
) -> None:
    text = text.replace('"lammps"', f'"lammps"\ntime_step_fraction = {fraction}')
    said = f"Test heap: a time step of {fraction} of the Rayleigh time step is more than the {safe}"
    assert (said in notes_of(tmp_path, text)) == (safe is not None)
    assert (of_checks.LARGE_TIME_STEP.is_in(notes_of(tmp_path, text))) == (safe is not None)
