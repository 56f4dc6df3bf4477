"""A chosen contact model acts in the runs of every solver, and only there."""

import re
from typing import Any

import pytest

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.contact_models import messages as contact_messages
from grainfit.errors import InputError
from grainfit.problem import Parameter
from grainfit.scenes.run_output import RunOutput
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS
from grainfit.which_test.available import available_tests

FILLED = "bed"
UNDAMPED = {n: v for n, v in GLASS_BEADS.items() if not n.endswith("rolling_damping")}
NO_DASHPOT = {**GLASS_BEADS, "particle_particle.rolling_damping": 0.0} | {
    "particle_wall.rolling_damping": 0.0
}


def bed(solver: str, folder, material, models) -> RunOutput:
    """Fill a small container; return the output."""
    folder.mkdir()
    test = Packing(diameter="10 mm", cylinder_radius="3 cm", fill_height="6 cm")
    program = DEM_PROGRAMS[solver](test, material, contact_models=models)
    scene = test.scene(program.run_parameters({}), seed=1)
    return program.simulate(scene, Workspace(folder))


@pytest.mark.parametrize(
    "solver",
    [
        "lammps",
        pytest.param("liggghts", marks=needs.LIGGGHTS),
        pytest.param("yade", marks=[needs.YADE, pytest.mark.slow]),
    ],
)
def test_the_chosen_model_moves_the_particles(tmp_path, solver: str) -> None:
    usual = bed(solver, tmp_path / "epsd", NO_DASHPOT, ())
    chosen = bed(solver, tmp_path / "epsd2", UNDAMPED, ["epsd2"])

    ends = [run.stages[0] for run in (usual, chosen)]
    assert ends[0].end == ends[1].end == "at_rest", ends
    first, second = (run.snapshot(FILLED) for run in (usual, chosen))
    # From the same first packing, another law gives another bed.
    assert first.positions.shape == second.positions.shape
    assert abs(first.positions - second.positions).max() > 1e-4


def test_models_that_cannot_be_chosen_are_named() -> None:
    test = Packing(diameter="10 mm")
    known = "hertz_mindlin, linear, sjkr, sjkr2, jkr, dmt, epsd, epsd2"
    unknown = contact_messages.UNKNOWN_MODEL(name="hooke", known=known)
    with pytest.raises(InputError, match=re.escape(unknown)):
        Lammps(test, GLASS_BEADS, contact_models=["hooke"])
    with pytest.raises(InputError, match=contact_messages.CONTRADICTION.pattern):
        Lammps(test, UNDAMPED, contact_models=["epsd", "epsd2"])
    with pytest.raises(InputError, match=contact_messages.NO_EFFECT.pattern):
        Lammps(test, GLASS_BEADS, contact_models=["epsd2"])


def test_a_parameter_of_another_model_than_the_named_one_is_refused() -> None:
    damp = {**GLASS_BEADS, "particle_wall.cohesion_energy_density": 1e3}
    with pytest.raises(
        InputError,
        match=f"cohesion_energy_density: {contact_messages.NO_EFFECT.matching(models='jkr')}",
    ):
        Liggghts(Packing(diameter="10 mm"), damp, contact_models=["jkr"])


def test_a_run_of_the_usual_model_keeps_its_definition() -> None:
    test = Packing(diameter="10 mm")
    usual = Lammps(test, GLASS_BEADS).definition({}, 1)
    by_name = Lammps(test, GLASS_BEADS, contact_models=["epsd"]).definition({}, 1)

    assert by_name.identity == usual.identity
    assert set(usual.model) == {"solver", "version", "ranks", "test"}


def test_candidates_for_further_tests_have_the_chosen_model() -> None:
    heap = Lammps(Heap(diameter="10 mm"), UNDAMPED, contact_models=["epsd2"])
    free = Parameter("particle_particle.rolling_friction", 0.1, 1.0)
    found = available_tests([free], {"heap": heap}, UNDAMPED, wanted=["packing"])

    run = found.solvers["packing"].definition({free.name: 0.5}, 1)
    assert run.model["contact_models"] == ["epsd2"]


@pytest.mark.parametrize("program", DEM_PROGRAMS.values())
@pytest.mark.parametrize(
    ("wrong", "name"),
    [
        ({"test": "heap"}, "test"),
        ({"test": Heap}, "test"),
        ({"material": None}, "material"),
        ({"material": [1]}, "material"),
        ({"material": {3: 4.0}}, "material"),
        ({"material": {"particle.density": None}}, r"particle\.density"),
        ({"material": {"particle.density": True}}, r"particle\.density"),
        ({"material": {"particle.density": 10**400}}, r"particle\.density"),
        ({"ranks": "2"}, "ranks"),
        ({"ranks": 1.5}, "ranks"),
        ({"executable": 3}, "executable"),
        ({"contact_models": "epsd2"}, r"contact_models: .*list"),
        ({"contact_models": None}, "contact_models"),
        ({"walls": ["plate"]}, "walls"),
        ({"walls": {"plate": 3}}, "walls"),
    ],
)
def test_arguments_of_a_wrong_kind_are_named(
    program: type[DeckSolver], wrong: dict[str, Any], name: str
) -> None:
    heap = Heap(diameter="10 mm")
    with pytest.raises(InputError, match=name):
        program(**{"test": heap, "material": {}, **wrong})
