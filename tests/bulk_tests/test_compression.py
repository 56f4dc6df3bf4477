"""The compression test: options, refused materials, validity of a run, and its responses."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.bulk_tests.compression import Compression
from grainfit.bulk_tests.compression import messages as of_compression
from grainfit.bulk_tests.compression.curve import Curve, fit_modulus
from grainfit.bulk_tests.natural_units import NaturalRun, natural_run
from grainfit.bulk_tests.shared import messages
from grainfit.calibration_file.build import build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.errors import InputError, NotMeasurableError, RunFailedError
from grainfit.materials.sizes import ParticleSizes
from grainfit.run_definition import RunDefinition
from grainfit.scenes import messages as of_scenes
from grainfit.scenes.records import Force
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Scene
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS

MONOSIZE = ParticleSizes((0.010,))
E = "particle.youngs_modulus"
#: Base point of the study in which the test was tried out.
MATERIAL = {
    **GLASS_BEADS,
    E: 1e7,
    "particle_particle.sliding_friction": 0.5,
    "particle_particle.rolling_friction": 0.2,
    "particle_particle.restitution": 0.6,
    "particle_wall.sliding_friction": 0.4,
    "particle_wall.rolling_friction": 0.1,
    "particle_wall.restitution": 0.6,
}
FILE = """
name = "sand"

[particle]
diameter = "10 mm"
density = "2100 kg/m^3"
youngs_modulus = {{ min = "{low}", max = "50 MPa" }}
poissons_ratio = 0.22

[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"

[particle_particle]
sliding_friction = 0.5
rolling_friction = 0.2
rolling_damping = 0.25
restitution = 0.6

[particle_wall]
sliding_friction = 0.4
rolling_friction = 0.1
rolling_damping = 0.25
restitution = 0.6

[[test]]
type = "compression"
solver = "lammps"
targets.loading_modulus = {{ value = "280 kPa", uncertainty = "5 %" }}
"""


def small(**options: object) -> Compression:
    """Return a test of which a run takes one or two seconds."""
    return Compression(MONOSIZE, **{"cylinder_radius": 0.03, "strike_off_height": 0.05, **options})


class TestOptions:
    def test_beads_of_10_mm_have_the_geometry_of_the_study(self) -> None:
        setup = Compression(MONOSIZE).setup
        assert (setup.cylinder_radius, setup.strike_off_height) == pytest.approx((0.05, 0.08))
        assert (setup.stress, setup.seating_stress) == pytest.approx((10e3, 500))
        assert setup.largest_speed(MATERIAL) == pytest.approx(0.0065 * (10e3 / 2100) ** 0.5)

    def test_other_sizes_and_gravities_are_the_same_test(self) -> None:
        setup = Compression(MONOSIZE).setup
        large = Compression(ParticleSizes((0.040,)), gravity=9.81 / 2).setup
        assert large.stress == pytest.approx(2 * setup.stress)
        assert large.cylinder_radius == pytest.approx(4 * setup.cylinder_radius)
        assert large.particle_count == setup.particle_count
        stiff = {**MATERIAL, E: 2 * MATERIAL[E]}
        stretched = large.record_interval(stiff) / setup.record_interval(MATERIAL)
        assert stretched == pytest.approx(8**0.5)

    def test_the_control_is_slower_than_what_inelastic_contacts_answer(self) -> None:
        setup = small().setup
        usual, inelastic = (
            setup.load(500.0, {**MATERIAL, "particle_wall.restitution": one}) for one in (0.6, 0.25)
        )
        assert inelastic.gain < 0.6 * usual.gain
        assert inelastic.force == usual.force

    @pytest.mark.slow
    def test_a_load_is_held_by_a_bed_with_little_restitution_and_friction(
        self, tmp_path: Path
    ) -> None:
        smooth = {
            **dict.fromkeys((n for n in MATERIAL if n.endswith("restitution")), 0.25),
            **dict.fromkeys((n for n in MATERIAL if n.endswith("sliding_friction")), 0.1),
            **dict.fromkeys((n for n in MATERIAL if n.endswith("rolling_friction")), 0.02),
        }
        solver = Lammps(small(), {**MATERIAL, **smooth})
        assert "loading_modulus" in solver.run({}, 1, Workspace(tmp_path))

    @pytest.mark.parametrize(
        ("options", "key"),
        [
            ({"cylinder_radius": "15 mm"}, "cylinder_radius"),
            ({"strike_off_height": "30 mm"}, "strike_off_height"),
            ({"particle_count": 300}, "particle_count"),
            ({"cylinder_radius": "2 m"}, "cylinder_radius"),
            ({"particle_count": 2_000_000}, "particle_count"),
            ({"stress": "1 kPa", "seating_stress": "900 Pa"}, "seating_stress"),
        ],
    )
    def test_impossible_tests_are_refused(self, options: dict[str, object], key: str) -> None:
        with pytest.raises(InputError) as caught:
            Compression(MONOSIZE, **options)
        assert [fault.key for fault in caught.value.faults] == [key]


def natural(diameter: float, density: float, **options: object) -> NaturalRun:
    """Return a run in natural units, of particles whose E/(rho g d) is always the same."""
    material = {**MATERIAL, "particle.density": density, E: 6e4 * density * 9.81 * diameter}
    # Walls are as much stiffer than the particles, too.
    material["wall.youngs_modulus"] = 2e4 * material[E]
    test = Compression(ParticleSizes((diameter,)), **options)
    run = natural_run(
        RunDefinition({"solver": "lammps", "version": "1", "test": test.definition()}, material, 1)
    )
    assert run is not None
    return run


class TestNaturalUnits:
    def test_runs_of_other_sizes_and_the_same_stress_over_weight_are_the_same(self) -> None:
        assert natural(0.010, 2100.0).is_same(natural(0.002, 2100.0))
        twice = {"stress": "20 kPa", "seating_stress": "1 kPa"}
        assert natural(0.010, 2000.0).is_same(natural(0.010, 4000.0, **twice))

    def test_the_default_stress_is_another_one_to_lighter_particles(self) -> None:
        assert not natural(0.010, 2000.0).is_same(natural(0.010, 1000.0))

    def test_a_default_that_is_given_is_the_same_run(self) -> None:
        given = Compression(MONOSIZE, stress=10e3, cylinder_radius=0.05)
        assert given.definition() == Compression(MONOSIZE).definition()


class TestMaterials:
    def test_a_stress_of_a_thousandth_of_youngs_modulus_is_possible(self) -> None:
        assert Lammps(small(), MATERIAL).run_parameters({})[E] == 1e7

    def test_particles_that_are_too_soft_are_refused_with_the_figure(self) -> None:
        with pytest.raises(
            InputError, match=f"stress: {messages.TOO_SOFT.matching(stress=10000, ratio=36)}"
        ):
            Lammps(small(), {**MATERIAL, E: 3.6e5})

    def test_a_bed_that_weighs_as_much_as_the_stress_is_refused(self) -> None:
        with pytest.raises(
            InputError,
            match=f"stress: {of_compression.BED_IS_HEAVY.matching(stress=1000, weight=939)}",
        ):
            Lammps(Compression(MONOSIZE, stress="1 kPa"), MATERIAL)

    def test_an_interval_that_begins_too_soft_is_refused_before_any_run(self) -> None:
        problem = gf.Problem(
            [gf.Parameter(E, "5 MPa", "50 MPa")], [gf.Target("loading_modulus", "280 kPa")]
        )
        fixed = {name: value for name, value in MATERIAL.items() if name != E}
        with pytest.raises(
            InputError, match=messages.TOO_SOFT.matching(modulus=5000000.0, ratio=500)
        ):
            gf.calibrate(problem, Lammps(small(), fixed))

    @pytest.mark.parametrize(("low", "problems"), [("10 MPa", 0), ("5 MPa", 1)])
    def test_check_shows_an_interval_that_begins_too_soft(
        self, low: str, problems: int, tmp_path: Path
    ) -> None:
        path = tmp_path / "calibration.toml"
        path.write_text(FILE.format(low=low), encoding="utf-8")
        plan = describe_plan(build_calibration(load_calibration_file(path)))

        found = [
            problem for problem in plan.problems if messages.TOO_SOFT.is_in(problem, ratio=500)
        ]
        assert len(found) == problems

    def test_of_an_interval_only_the_worse_end_is_told(self) -> None:
        solver = Lammps(small(), {name: value for name, value in MATERIAL.items() if name != E})
        [soft] = solver.interval_faults({E: (2e6, 5e6)})
        assert messages.TOO_SOFT.is_in(soft.message, ratio=200)

        light = Lammps(Compression(MONOSIZE, stress="1.5 kPa"), {})
        [heavy] = light.interval_faults({"particle.density": (2500.0, 4000.0)})
        assert "particle.density 4000 kg/m^3" in heavy.message

    def test_a_run_with_soft_particles_fails_with_the_reason(self, tmp_path: Path) -> None:
        fixed = {name: value for name, value in MATERIAL.items() if name != E}
        with pytest.raises(RunFailedError, match=messages.TOO_SOFT.matching(ratio=100)):
            Lammps(small(), fixed).run({E: 1e6}, 1, Workspace(tmp_path))
        assert list(tmp_path.iterdir()) == []


class TestModulus:
    def curve(self, stresses: np.ndarray, strains: np.ndarray) -> Curve:
        return Curve(np.arange(len(strains)), 0.08 * (1 - strains), stresses, stresses, stresses)

    def test_it_is_the_slope_between_half_and_98_percent_of_the_stress(self) -> None:
        strains = np.linspace(0, 0.05, 200)
        # Softer below half of the stress, and flat above 98 %: neither counts.
        stresses = np.interp(strains, [0, 0.02, 0.04, 0.05], [500, 5000, 9800, 9800])
        fit = fit_modulus(self.curve(stresses, strains), 0.08, 10e3, "modulus")

        assert fit.value == pytest.approx(4800 / 0.02, rel=1e-6)
        assert fit.standard_error < 1e-6 * fit.value
        assert fit.stress_at_zero == pytest.approx(200, abs=0.1)

    def test_too_few_records_are_refused(self) -> None:
        curve = self.curve(np.array([500.0, 6000.0, 9900.0]), np.array([0.0, 0.03, 0.05]))
        with pytest.raises(NotMeasurableError, match=r"only 1 times .* lower piston_speed"):
            fit_modulus(curve, 0.08, 10e3, "modulus")

    def test_a_stress_that_falls_is_refused(self) -> None:
        curve = self.curve(np.linspace(9000, 6000, 20), np.linspace(0, 0.05, 20))
        with pytest.raises(NotMeasurableError, match=of_compression.NO_RISE.pattern):
            fit_modulus(curve, 0.08, 10e3, "modulus")


def with_drag(scene: Scene) -> Scene:
    """Record the vertical force on the pot as well."""
    stages = [
        replace(stage, series=replace(stage.series, columns={**stage.series.columns, **DRAG}))
        if stage.series is not None
        else stage
        for stage in scene.stages
    ]
    return replace(scene, stages=tuple(stages))


DRAG = {"drag": Force("pot", "z")}
_FOLDERS: dict[str, Path] = {}


@pytest.fixture(params=["lammps", "liggghts"])
def finished(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run in each solver, made once."""
    name = request.param
    if name == "liggghts" and shutil.which(name) is None:
        pytest.skip("LIGGGHTS is not installed: apt-get install liggghts")
    if name not in _FOLDERS:
        folder = tmp_path_factory.mktemp(name)
        solver = DEM_PROGRAMS[name](small(), MATERIAL)
        scene = with_drag(small().scene(MATERIAL, 3))
        solver._simulate(solver.deck(scene, folder).write(), Workspace(folder, 300.0))
        _FOLDERS[name] = folder
    return _FOLDERS[name]


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    """A copy of the run, to be damaged."""
    return Path(shutil.copytree(finished, tmp_path / "copy"))


def edit_series(folder: Path, stage: str, column: str, change: Callable[[float], float]) -> None:
    """Change every value of a column of a series."""
    path = folder / f"series_{stage}.csv"
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    index = header.split(",").index(column)
    table = [row.split(",") for row in rows]
    for row in table:
        row[index] = repr(change(float(row[index])))
    path.write_text("\n".join([header, *map(",".join, table)]) + "\n", encoding="utf-8")


@pytest.mark.slow
class TestRun:
    def test_the_responses_are_those_of_the_study(self, finished: Path) -> None:
        """NOTES of the study, pot of 5 d: 273 kPa, 591 kPa, 1140 kg/m^3, 0.393."""
        responses = small().measure(RunOutput(finished))

        expected = {
            "loading_modulus": (260e3, 0.35),
            "unloading_modulus": (550e3, 0.35),
            "bulk_density": (1140, 0.05),
            "lateral_stress_ratio": (0.39, 0.2),
        }
        for name, (value, within) in expected.items():
            assert responses[name].value == pytest.approx(value, rel=within), name
            assert 0 < responses[name].standard_error < within * value
        assert (finished / "compression.png").stat().st_size > 5000
        assert (finished / "loaded.vtk").is_file()

    def test_the_stress_is_held_and_all_forces_are_in_balance(self, finished: Path) -> None:
        output, setup = RunOutput(finished), small().setup
        weight = output.snapshot("loaded").masses.sum() * setup.gravity
        for stage, stress in (("seat", setup.seating_stress), ("load", setup.stress)):
            end = {name: values[-1] for name, values in output.series(stage).items()}
            assert end["piston_force"] == pytest.approx(stress * setup.area, rel=0.01)
            carried = -end["floor_force"] - end["drag"]
            assert carried == pytest.approx(end["piston_force"] + weight, rel=0.003)

    def test_a_stress_that_is_not_held_fails(self, copied: Path) -> None:
        edit_series(copied, "load", "piston_force", lambda force: 0.97 * force)
        not_held = messages.STRESS_NOT_HELD.matching(stage="load", wanted=10000)
        with pytest.raises(RunFailedError, match=f"(?=.* 9[67][0-9][0-9] Pa instead){not_held}"):
            small().measure(RunOutput(copied))

    def test_a_stress_that_ends_its_stage_at_the_limit_is_measured(self, copied: Path) -> None:
        edit_series(copied, "load", "piston_force", lambda force: 0.989 * force)
        assert "loading_modulus" in small().measure(RunOutput(copied))

    def test_a_bed_that_creeps_under_the_seating_stress_is_measured(self, copied: Path) -> None:
        edit_series(copied, "seat", "piston_force", lambda force: 0.98 * force)
        assert "loading_modulus" in small().measure(RunOutput(copied))
        edit_series(copied, "seat", "piston_force", lambda force: 0.96 * force)
        with pytest.raises(RunFailedError, match=messages.STRESS_NOT_HELD.matching(stage="seat")):
            small().measure(RunOutput(copied))

    def test_a_stress_that_is_not_reached_fails(self, copied: Path) -> None:
        stages = copied / "stages.csv"
        stages.write_text(stages.read_text().replace("load,done", "load,unloaded"))
        with pytest.raises(RunFailedError, match=of_scenes.UNLOADED.matching(stage="load")):
            small().measure(RunOutput(copied))

    def test_a_piston_that_leaves_the_bed_fails(self, copied: Path) -> None:
        edit_series(copied, "load", "travel", lambda travel: travel - 0.03)
        with pytest.raises(
            RunFailedError, match=rf"(?=.* 0\.01){of_compression.PISTON_OUT.pattern}"
        ):
            small().measure(RunOutput(copied))

    def test_particles_that_overlap_grossly_fail(self, copied: Path) -> None:
        dump = copied / "snapshots" / "loaded.dump"
        header, rows = dump.read_text().split("ITEM: ATOMS ", 1)
        columns, *lines = rows.splitlines()
        radius = columns.split().index("radius")
        table = [line.split() for line in lines]
        for row in table:
            row[radius] = repr(1.15 * float(row[radius]))
        text = "\n".join([f"ITEM: ATOMS {columns}", *map(" ".join, table)])
        dump.write_text(header + text + "\n")
        with pytest.raises(RunFailedError, match="overlap grossly"):
            small().measure(RunOutput(copied))


@pytest.mark.slow
def test_moduli_grow_with_youngs_modulus_as_for_hertz_contacts(tmp_path: Path) -> None:
    """Between E^(1/2), and E^(2/3); beds of the same seeds begin nearly alike."""
    moduli = []
    for modulus in (1e7, 4e7):
        found = []
        for seed in (1, 2):
            folder = tmp_path / f"{modulus:g} {seed}"
            folder.mkdir()
            solver = Lammps(small(), {**MATERIAL, E: modulus})
            found.append(solver.run({}, seed, Workspace(folder, 300.0)))
        moduli.append(found)
    for name in ("loading_modulus", "unloading_modulus"):
        soft, stiff = (np.mean([run[name].value for run in runs]) for runs in moduli)
        assert 4**0.5 / 1.2 < stiff / soft < 4 ** (2 / 3) * 1.2, name
