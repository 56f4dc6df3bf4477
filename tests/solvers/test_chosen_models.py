"""A chosen contact model acts in the runs of every solver, and only there."""

import pytest

from grainfit.bulk_tests.packing import Packing
from grainfit.errors import InputError
from grainfit.scenes.run_output import RunOutput
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS

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
    "solver", [pytest.param(s, marks=[pytest.mark.slow] * (s == "yade")) for s in DEM_PROGRAMS]
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
    with pytest.raises(InputError, match=r"'jkr' is no model to choose\. Use epsd, epsd2\."):
        Lammps(test, GLASS_BEADS, contact_models=["jkr"])
    with pytest.raises(InputError, match="epsd and epsd2 cannot act together"):
        Lammps(test, UNDAMPED, contact_models=["epsd", "epsd2"])
    with pytest.raises(InputError, match="rolling_damping: is no parameter of the contact model e"):
        Lammps(test, GLASS_BEADS, contact_models=["epsd2"])


def test_a_run_of_the_usual_model_keeps_its_definition() -> None:
    test = Packing(diameter="10 mm")
    usual = Lammps(test, GLASS_BEADS).definition({}, 1)
    by_name = Lammps(test, GLASS_BEADS, contact_models=["epsd"]).definition({}, 1)

    assert by_name.identity == usual.identity
    assert set(usual.model) == {"solver", "version", "ranks", "test"}
