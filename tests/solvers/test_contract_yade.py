"""YADE keeps the contract of all solvers, with small beds; what it refuses and why."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import needs
from grainfit.bulk_tests.discharge import Discharge
from grainfit.bulk_tests.drum import Drum
from grainfit.bulk_tests.drum.angles import DrumAngles
from grainfit.bulk_tests.drum.bed import TurningBed
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.packing import Packing
from grainfit.bulk_tests.shear import Shear
from grainfit.calibration_file.build import build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.contact_models.hertz_mindlin.model import effective_moduli, particle_moduli
from grainfit.contact_models.hertz_mindlin.yade import wall_modulus
from grainfit.errors import InputError, RunFailedError, SolverNotFoundError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.scene import STANDARD_GRAVITY, Box, Scene, Stage, Wall
from grainfit.scenes.shapes import Plane
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem import messages as dem_messages
from grainfit.solvers.dem.yade.program import Yade
from grainfit.solvers.dem.yade.scene_deck import YadeSceneDeck
from grainfit.testing.materials import GLASS_BEADS
from grainfit.testing.solver_contract import ProcessSolverContract

DAMPING = ("particle_particle.rolling_damping", "particle_wall.rolling_damping")
MATERIAL = {**GLASS_BEADS, **dict.fromkeys(DAMPING, 0.0)}
FREE = ("particle.density", "particle_particle.rolling_friction")
FIXED = {name: value for name, value in MATERIAL.items() if name not in FREE}
BEADS = ParticleSizes((0.010,))
EXAMPLE = (Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml").read_text(
    encoding="utf-8"
)
#: A run starts, fills, and ends within a second or two.
SMALL = Packing(BEADS, cylinder_radius=0.03, fill_height=0.05)


@needs.YADE
@pytest.mark.slow
class TestYade(ProcessSolverContract):
    @pytest.fixture
    def solver(self):
        return Yade(SMALL, FIXED)

    @pytest.fixture
    def parameters(self):
        return {"particle.density": 2100.0, "particle_particle.rolling_friction": 0.67}

    @pytest.fixture
    def endless(self):
        return Yade(Heap(BEADS, particle_count=6000, cylinder_radius=0.1), FIXED)


def test_rolling_damping_is_refused_and_what_to_do_is_said():
    with pytest.raises(InputError) as caught:
        Yade(SMALL, GLASS_BEADS)

    assert [fault.key for fault in caught.value.faults] == list(DAMPING)
    for fault in caught.value.faults:
        assert "0.25" in fault.message
        assert dem_messages.NO_ROLLING_DAMPING.is_in(str(fault))


def test_an_interval_of_rolling_damping_is_refused_before_a_run():
    fixed = {name: value for name, value in MATERIAL.items() if name != DAMPING[0]}
    (fault,) = Yade(SMALL, fixed).interval_faults({DAMPING[0]: (0.0, 0.5)})

    assert fault.key == DAMPING[0]
    assert "0.5" in fault.message


def test_ranks_are_refused_with_the_reason():
    with pytest.raises(InputError, match=dem_messages.YADE_ON_ONE_CORE.pattern):
        Yade(SMALL, MATERIAL, ranks=2)


def test_a_program_that_is_not_there_or_no_yade_says_how_to_install_it(tmp_path):
    with pytest.raises(SolverNotFoundError, match="apt-get install yade"):
        Yade(SMALL, MATERIAL, executable=str(tmp_path / "yade")).check()
    with pytest.raises(SolverNotFoundError, match=dem_messages.IS_ANOTHER_PROGRAM.pattern):
        Yade(SMALL, MATERIAL, executable="true").version()


def test_a_round_orifice_is_refused_with_what_to_use_instead():
    with pytest.raises(InputError, match='solver = "lammps" or "liggghts"'):
        Yade(Discharge(BEADS, orifice="round"), MATERIAL).check()


@pytest.mark.parametrize("wall_young", [2e5, 5e6, 2.11e11])
def test_walls_are_as_stiff_as_if_r_star_was_the_radius(wall_young):
    material = {**GLASS_BEADS, "wall.youngs_modulus": wall_young}
    young, poisson = material["particle.youngs_modulus"], material["particle.poissons_ratio"]
    of_yade = effective_moduli(young, poisson, wall_modulus(material, 0.5), poisson)

    assert of_yade.young * math.sqrt(0.5) == pytest.approx(particle_moduli(material, "wall").young)


def one_particle(box: Box) -> Scene:
    return Scene(
        title="One particle",
        material=MATERIAL,
        sizes=BEADS,
        particles=Column(np.array([[0.0, 0.01, 0.02]]), np.zeros(1, int), 0.03),
        box=box,
        walls={"floor": Wall(Plane("z", 0.0))},
        stages=(Stage("fall", Elapsed(0.001)),),
        gravity=9.81,
        time_step=1e-4,
        quiet_speed=1e-3,
        check_interval=0.01,
    )


def test_without_gravity_rolling_is_as_stiff_as_on_earth(tmp_path):
    box = Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1))
    on_earth = one_particle(box)
    afloat = replace(on_earth, gravity=0.0)
    texts = [
        YadeSceneDeck(scene, tmp_path).text()
        for scene in (replace(on_earth, gravity=STANDARD_GRAVITY), afloat)
    ]
    stiffness = [
        [float(number) for number in re.findall(r"(?:krot=|\.kr = )([-.e\d]+)", text)]
        for text in texts
    ]

    assert stiffness[0] == stiffness[1]
    assert len(stiffness[1]) == 2
    assert min(stiffness[1]) > 0


def test_a_calibration_file_can_name_it(tmp_path):
    for model in ("", '\n[contact_models]\nrolling = "epsd2"\n'):
        damping = "" if model else "rolling_damping = 0\n"
        text = EXAMPLE.replace("rolling_damping = 0.25\n", damping).replace('"lammps"', '"yade"')
        path = tmp_path / "calibration.toml"
        path.write_text(text + model, encoding="utf-8")
        solver = build_calibration(load_calibration_file(path)).solvers["heap"]

        assert isinstance(solver, Yade)
        assert solver.contact_models == (("epsd2",) if model else ())


@needs.YADE
@pytest.mark.slow
def test_a_bed_is_sheared_between_plates(tmp_path):
    short = {"transient_strain": 0.5, "averaged_strain": 1.0}
    test = Shear(BEADS, length=0.06, depth=0.04, gap=0.07, **short)
    found = Yade(test, MATERIAL).run({}, 1, Workspace(tmp_path))

    # One run of LAMMPS has 24.4 degrees and 1321 kg/m^3; runs scatter by a degree.
    assert found["internal_friction_angle"].value == pytest.approx(24, abs=3)
    assert found["shear_density"].value == pytest.approx(1320, rel=0.03)


@needs.YADE
@pytest.mark.slow
@pytest.mark.parametrize(("lining", "slip"), [(True, 0.07), (False, 0.27)])
def test_a_drum_takes_its_bed_along(tmp_path, lining, slip):
    turns = {"discarded_turns": 0.2, "averaged_turns": 0.3}
    test = Drum(BEADS, drum_radius=0.05, drum_length=0.04, lining=lining, **turns)
    material = {**MATERIAL, "particle_wall.sliding_friction": 0.9}
    run = Yade(test, material).simulate(test.scene(material, 1), Workspace(tmp_path))
    end = run.stages[-1]
    bed = TurningBed.of(run.frames("turning"), test.setup, end.time / end.step)

    assert end.particles == test.setup.particle_count
    # LAMMPS and LIGGGHTS have 0.07 and 0.08 with a lining, 0.24 and 0.30 without it.
    assert DrumAngles(bed).slip == pytest.approx(slip, abs=0.05)


def test_a_period_that_yade_would_overlook_contacts_across_is_refused(tmp_path):
    box = Box((-0.1, 0.0, -0.1), (0.1, 0.02, 0.1), periodic="y")
    with pytest.raises(InputError, match=dem_messages.PERIOD_TOO_SHORT.pattern):
        Yade(SMALL, MATERIAL).simulate(one_particle(box), Workspace(tmp_path))


@needs.YADE
@pytest.mark.slow
def test_an_error_of_the_script_is_the_reason_of_the_failure(tmp_path):
    solver = Yade(SMALL, MATERIAL)
    box = Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1))
    deck = solver.deck(one_particle(box), tmp_path).write()
    (tmp_path / "particles.txt").unlink()
    with pytest.raises(RunFailedError) as caught:
        solver._simulate(deck, Workspace(tmp_path, 60.0))

    assert caught.value.reason.startswith("yade: FileNotFoundError: particles.txt")
    assert "Traceback" in caught.value.log_tail
