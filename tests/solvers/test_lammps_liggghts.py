"""LAMMPS and LIGGGHTS: what they refuse, what they say, and real heaps."""

import json
import math
import os
import stat
import threading
import time
from dataclasses import replace
from functools import cache

import pytest
from small_heaps import SMALL_HEAP, each_solver, lammps_and_thoroughly_liggghts

import needs
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import InputError, RunFailedError, SolverNotFoundError
from grainfit.evaluation import scalars
from grainfit.materials.sizes import ParticleSizes
from grainfit.run_definition import RunDefinition
from grainfit.scenes import messages as scene_messages
from grainfit.scenes.run_output import SNAPSHOTS, STAGES
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem import messages as dem_messages
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE

MONOSIZE = ParticleSizes((0.010,))
STUDY = Heap(MONOSIZE, **ROUGH_PLATE)
SMALL = Heap(MONOSIZE, **SMALL_HEAP)


def run(solver_type, folder, test=SMALL, seed=1, ranks=1, timeout=120.0, **changes):
    solver = solver_type(test, {**GLASS_BEADS, **changes}, ranks=ranks)
    responses = solver.run({}, seed, Workspace(folder, timeout))
    return {name: response.value for name, response in scalars(responses).items()}


@pytest.fixture(scope="module")
def small_heap(tmp_path_factory):
    """Give the folder and the responses of one small heap of each solver."""

    @cache
    def simulated(solver_type):
        folder = tmp_path_factory.mktemp(solver_type.name)
        return folder, run(solver_type, folder)

    return simulated


class TestParameters:
    @each_solver
    def test_definition_is_all_that_decides_the_outcome(self, solver_type):
        fixed = {k: v for k, v in GLASS_BEADS.items() if k != "particle.density"}
        solver = solver_type(SMALL, fixed)
        definition = solver.definition({"particle.density": 2300.0}, seed=7)
        assert RunDefinition.from_json(json.loads(json.dumps(definition.to_json()))) == definition
        assert definition.parameters == {**GLASS_BEADS, "particle.density": 2300.0}
        assert list(definition.parameters) == [n for n in MATERIAL_PARAMETERS if n in GLASS_BEADS]
        assert definition.seed == 7
        assert (
            solver_type(SMALL, GLASS_BEADS).definition({"particle.density": 2300.0}, seed=7)
            == definition
        )
        others = [
            solver.definition({"particle.density": 2301.0}, 7),
            solver.definition({"particle.density": 2300.0}, 8),
            solver_type(STUDY, fixed).definition({"particle.density": 2300.0}, 7),
            solver_type(SMALL, fixed, ranks=2).definition({"particle.density": 2300.0}, 7),
        ]
        assert all(other != definition for other in others)

    @each_solver
    def test_where_the_program_lies_is_no_part_of_the_identity(self, solver_type, tmp_path):
        usual = solver_type(SMALL, GLASS_BEADS)
        link = tmp_path / "elsewhere"
        link.symlink_to(usual._program())
        other = solver_type(SMALL, GLASS_BEADS, executable=str(link))
        assert other.definition({}, 1) == usual.definition({}, 1)

    @each_solver
    def test_responses_are_those_of_the_test(self, solver_type):
        names = ("bulk_density", "angle_of_repose", "base_radius", "heap_height", "profile")
        assert solver_type(SMALL, {}).response_names == names

    @each_solver
    @pytest.mark.parametrize(
        ("name", "value"),
        [
            ("particle.colour", 1.0),
            ("particle.density", -5.0),
            ("particle.poissons_ratio", 0.5),
            ("particle_particle.restitution", 1.1),
            ("particle.youngs_modulus", math.nan),
            ("particle_wall.sliding_friction", math.inf),
        ],
    )
    def test_garbage_is_refused_by_name(self, solver_type, name, value):
        with pytest.raises(InputError, match=name):
            solver_type(SMALL, {**GLASS_BEADS, name: value})
        with pytest.raises(InputError, match=name):
            solver_type(SMALL, GLASS_BEADS).definition({name: value}, 1)

    @each_solver
    def test_a_missing_parameter_is_named(self, solver_type, tmp_path):
        solver = solver_type(SMALL, {"particle.density": 2100.0})
        with pytest.raises(InputError) as caught:
            solver.run({}, 1, Workspace(tmp_path))
        assert len(caught.value.faults) == 13

    @each_solver
    def test_no_ranks_at_all_are_refused(self, solver_type):
        with pytest.raises(InputError, match="ranks"):
            solver_type(SMALL, GLASS_BEADS, ranks=0)


class TestProgram:
    @each_solver
    def test_is_found_and_tells_its_version(self, solver_type):
        solver = solver_type(SMALL, GLASS_BEADS, ranks=2)
        solver.check()
        assert any(character.isdigit() for character in solver.version())

    def test_lammps_is_found_without_an_activated_environment(self, monkeypatch):
        monkeypatch.setenv("PATH", "/usr/bin:/bin")
        Lammps(SMALL, GLASS_BEADS).check()

    @pytest.mark.parametrize(
        ("solver_type", "remedy"),
        [(Lammps, r"pip install 'grainfit\[lammps\]'"), (Liggghts, "apt-get install liggghts")],
    )
    def test_a_missing_program_says_how_to_install_it(self, solver_type, remedy):
        solver = solver_type(SMALL, GLASS_BEADS, executable="no-such-program")
        with pytest.raises(SolverNotFoundError, match=f"no-such-program.*{remedy}"):
            solver.check()

    @pytest.mark.parametrize("solver_type", [Lammps, Liggghts])
    def test_another_program_is_not_taken_for_it(self, solver_type):
        with pytest.raises(SolverNotFoundError, match=dem_messages.IS_ANOTHER_PROGRAM.pattern):
            solver_type(SMALL, GLASS_BEADS, executable="true").definition({}, 1)

    def test_lammps_without_granular_is_said(self, tmp_path):
        program = tmp_path / "lmp"
        program.write_text(
            "#!/bin/sh\n"
            "echo 'Large-scale Atomic/Molecular Massively Parallel Simulator - 2 Aug 2023'\n"
            "echo 'Installed packages:'\necho 'KSPACE MOLECULE'\n"
        )
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        with pytest.raises(SolverNotFoundError, match=dem_messages.WITHOUT_GRANULAR.pattern):
            Lammps(SMALL, GLASS_BEADS, executable=str(program)).definition({}, 1)

    @needs.LIGGGHTS
    def test_liggghts_refuses_a_low_restitution_before_any_run(self):
        material = {**GLASS_BEADS, "particle_wall.restitution": 0.05}
        with pytest.raises(InputError, match=r"particle_wall\.restitution.*LAMMPS"):
            Liggghts(SMALL, material).check()

    @needs.LIGGGHTS
    def test_the_programs_own_error_message_is_the_reason(self, tmp_path):
        with pytest.raises(RunFailedError, match="coefficientRestitution") as caught:
            run(Liggghts, tmp_path, **{"particle_particle.restitution": 0.05})
        assert caught.value.kind == "simulation"


@pytest.mark.slow
class TestRealHeaps:
    @each_solver
    def test_glass_beads_give_the_known_responses(self, solver_type, tmp_path):
        response = run(solver_type, tmp_path, STUDY)
        # Ten replicates of one set-up scatter by 3.7 kg/m^3 and 0.8 degrees: four standard
        # deviations of one run. The solvers' own means differ by 0.5 degrees.
        assert response["bulk_density"] == pytest.approx(1356, abs=4 * 3.7)
        assert response["angle_of_repose"] == pytest.approx(21.9, abs=4 * 0.8)

    @lammps_and_thoroughly_liggghts
    def test_equal_seeds_give_equal_heaps_and_other_seeds_others(
        self, solver_type, small_heap, tmp_path
    ):
        folder, first = small_heap(solver_type)
        others = []
        for seed in (1, 2):
            (tmp_path / str(seed)).mkdir()
            others.append(run(solver_type, tmp_path / str(seed), seed=seed))
        assert others[0] == first
        assert others[1] != first
        left = {path.name: path for path in folder.iterdir()}
        assert {STAGES, SNAPSHOTS, "heap.png", "heap.vtk"} <= set(left)
        snapshots = {path.name for path in left[SNAPSHOTS].iterdir()}
        assert snapshots == {"settled.dump", "heap.dump"}
        # The folder can be copied and its deck run by hand.
        assert str(folder) not in left[f"in.{solver_type.name}"].read_text()

    @lammps_and_thoroughly_liggghts
    def test_bidisperse_particles_pack_denser(self, solver_type, tmp_path):
        sizes = ParticleSizes((0.012, 0.007), (0.6, 0.4))
        result = run(solver_type, tmp_path, Heap(sizes, **SMALL_HEAP))
        # One size gives 1311 kg/m^3 in this cylinder, with a standard deviation of 8 (six runs).
        assert 1335 < result["bulk_density"] < 1500
        assert 10 < result["angle_of_repose"] < 30

    @each_solver
    def test_zero_is_a_value(self, solver_type, tmp_path):
        names = ["particle_particle.rolling_damping", "particle_wall.rolling_friction"]
        assert run(solver_type, tmp_path, **dict.fromkeys(names, 0.0))["bulk_density"] > 1200

    @lammps_and_thoroughly_liggghts
    def test_a_heap_without_friction_rolls_away(self, solver_type, tmp_path):
        test = replace(SMALL, plate_sliding_friction=0, plate_rolling_friction=0)
        nothing = {name: 0.0 for name in GLASS_BEADS if name.endswith("_friction")}
        with pytest.raises(RunFailedError, match="angle of repose") as caught:
            run(solver_type, tmp_path, test, **nothing)
        assert caught.value.kind == "evaluation"
        assert (tmp_path / "heap.png").exists()

    @each_solver
    def test_a_bed_that_is_not_at_rest_in_time_is_said(self, solver_type, tmp_path):
        test = Heap(MONOSIZE, **SMALL_HEAP, settling_time_limit=0.01)
        lively = {"particle_particle.restitution": 0.95, "particle_wall.restitution": 0.95}
        with pytest.raises(RunFailedError, match=scene_messages.RESTLESS.pattern) as caught:
            run(solver_type, tmp_path, test, **lively)
        assert caught.value.kind == "simulation"
        assert not list(tmp_path.rglob("*.dump"))

    @needs.LIGGGHTS
    def test_a_bed_that_its_rolling_dashpots_keep_awake_is_said(self, tmp_path):
        # Twice the safe time step at a high rolling friction: never at rest, and no solver error.
        test = Heap(MONOSIZE, **SMALL_HEAP, time_step_fraction=0.25)
        with pytest.raises(RunFailedError, match="in the fill stage within 2"):
            run(Liggghts, tmp_path, test, **{"particle_particle.rolling_friction": 1.1})

    @each_solver
    def test_a_time_step_too_large_is_said_not_measured(self, solver_type, tmp_path):
        test = Heap(MONOSIZE, **SMALL_HEAP, time_step_fraction=1.0)
        with pytest.raises(RunFailedError, match="time_step_fraction") as caught:
            run(solver_type, tmp_path, test)
        assert caught.value.kind == "simulation"

    @each_solver
    def test_particles_as_soft_as_foam_are_said_not_measured(self, solver_type, tmp_path):
        with pytest.raises(RunFailedError, match="overlap grossly"):
            run(solver_type, tmp_path, **{"particle.youngs_modulus": 2e4})

    @each_solver
    @pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="needs two cores")
    def test_two_ranks_simulate_the_same_test(self, solver_type, tmp_path):
        # The motion of two ranks differs from that of one by little.
        bed = Packing(MONOSIZE, cylinder_radius=0.03, fill_height=0.05)
        folders = [tmp_path / name for name in ("alone", "both")]
        for folder in folders:
            folder.mkdir()
        alone, both = (
            run(solver_type, folder, bed, ranks=ranks, timeout=300)
            for ranks, folder in enumerate(folders, 1)
        )
        assert both["bulk_density"] == pytest.approx(alone["bulk_density"], rel=0.03)

    @each_solver
    def test_the_user_can_stop_a_run(self, solver_type, tmp_path):
        workspace = Workspace(tmp_path)
        timer = threading.Timer(1.0, workspace.cancelled.set)
        timer.start()
        started = time.monotonic()
        # So stiff that it would take minutes.
        solver = solver_type(STUDY, {**GLASS_BEADS, "particle.youngs_modulus": 1e10})
        with pytest.raises(RunFailedError) as caught:
            solver.run({}, 1, workspace)
        timer.join()
        assert caught.value.kind == "cancelled"
        assert time.monotonic() - started < 60
