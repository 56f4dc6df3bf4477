"""The heap test without a solver: geometry, deck, identity, what a failed run says."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.heap import messages as of_heap
from grainfit.bulk_tests.shared import messages as of_shared
from grainfit.bulk_tests.workload import workload
from grainfit.errors import InputError, NotMeasurableError, RunFailedError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes import messages
from grainfit.scenes.packing import Round, random_column
from grainfit.scenes.run_output import STAGES, STAGES_HEADER, RunOutput, snapshot_file
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.decks import write_deck

MONOSIZE = ParticleSizes((0.010,))
BIDISPERSE = ParticleSizes((0.012, 0.008), (0.5, 0.5))
SOLVERS = ("lammps", "liggghts")


def option_faults(sizes=MONOSIZE, **options):
    with pytest.raises(InputError) as caught:
        Heap(sizes, **options)
    return [fault.key for fault in caught.value.faults]


class TestDefaults:
    def test_beads_of_10_mm_have_the_geometry_of_the_study(self):
        setup = Heap(MONOSIZE).setup
        assert setup.particle_count == 1500
        assert setup.cylinder_radius == pytest.approx(0.06)
        assert setup.plate_radius == pytest.approx(0.16)
        assert setup.strike_off_height == pytest.approx(0.105)
        assert (setup.bulk_density_bottom, setup.bulk_density_top) == pytest.approx((0.01, 0.09))
        assert setup.lift_speed == pytest.approx(0.05)
        assert setup.lift_height == pytest.approx(0.10)

    def test_other_sizes_follow_by_froudes_law(self):
        setup, large = Heap(MONOSIZE).setup, Heap(ParticleSizes((0.040,))).setup
        assert large.particle_count == setup.particle_count
        assert large.plate_radius == pytest.approx(4 * setup.plate_radius)
        froude = setup.lift_speed**2 / (setup.gravity * setup.cylinder_radius)
        assert large.lift_speed**2 / (large.gravity * large.cylinder_radius) == pytest.approx(
            froude
        )
        assert large.filling.fill_time == pytest.approx(2 * setup.filling.fill_time)
        assert large.filling.check_interval == pytest.approx(2 * setup.filling.check_interval)

    def test_lower_gravity_slows_the_test_down(self):
        setup, moon = Heap(MONOSIZE).setup, Heap(MONOSIZE, gravity=9.81 / 4).setup
        assert moon.lift_speed == pytest.approx(setup.lift_speed / 2)
        assert moon.settling_time_limit == pytest.approx(2 * setup.settling_time_limit)

    @pytest.mark.parametrize("sizes", [MONOSIZE, BIDISPERSE])
    def test_particles_fill_any_cylinder_beyond_the_strike_off_height(self, sizes):
        test = Heap(sizes, cylinder_radius=0.09, strike_off_height=0.2)
        shares = zip(sizes.number_fractions, sizes.diameters, strict=True)
        solid = test.setup.particle_count * sum(s * math.pi / 6 * d**3 for s, d in shares)
        # Random close packing without walls is 0.64.
        assert solid / (math.pi * 0.09**2 * 0.64) > 0.2


class TestImpossibleTests:
    @pytest.mark.parametrize(
        "name",
        [
            "particle_count",
            "cylinder_radius",
            "plate_radius",
            "strike_off_height",
            "bulk_density_bottom",
            "bulk_density_top",
            "lift_speed",
            "lift_height",
            "gravity",
            "time_step_fraction",
            "settling_time_limit",
            "views",
        ],
    )
    @pytest.mark.parametrize("value", [0, -1, math.nan, math.inf])
    def test_zero_negative_and_not_a_number_are_refused(self, name, value):
        assert option_faults(**{name: value}) == [name]

    @pytest.mark.parametrize(
        "name", ["rim_height", "plate_sliding_friction", "plate_rolling_friction"]
    )
    def test_negative_friction_and_rim_are_refused(self, name):
        assert option_faults(**{name: -0.1}) == [name]
        Heap(MONOSIZE, **{name: 0.0})

    def test_every_fault_is_named_at_once(self):
        assert option_faults(gravity=0, lift_speed=-1, views=2.5) == [
            "lift_speed",
            "views",
            "gravity",
        ]

    def test_a_plate_narrower_than_the_cylinder(self):
        assert option_faults(plate_radius=0.05) == ["plate_radius"]

    def test_a_cylinder_narrower_than_four_particles(self):
        with pytest.raises(
            InputError, match=of_shared.CYLINDER_IS_NARROW.matching(radius=0.019, least=0.02)
        ):
            Heap(MONOSIZE, cylinder_radius=0.019)
        # It is the largest particle that jams.
        assert option_faults(ParticleSizes((0.03, 0.005), (0.5, 0.5)), cylinder_radius=0.05) == [
            "cylinder_radius"
        ]

    def test_a_strike_off_height_that_the_particles_do_not_reach(self):
        assert option_faults(particle_count=900) == ["particle_count"]
        assert option_faults(particle_count=1500, strike_off_height=0.2) == ["particle_count"]

    def test_a_bulk_density_measured_above_the_bed(self):
        assert option_faults(bulk_density_top=0.12) == ["bulk_density_top"]

    def test_a_bulk_density_measured_in_no_height(self):
        assert option_faults(bulk_density_bottom=0.09, bulk_density_top=0.05) == [
            "bulk_density_top"
        ]

    def test_a_time_step_above_the_rayleigh_time_step(self):
        assert option_faults(time_step_fraction=1.5) == ["time_step_fraction"]

    def test_a_lift_that_leaves_the_cylinder_in_the_heap(self):
        assert option_faults(lift_height=0.01) == ["lift_height"]

    @pytest.mark.parametrize("height", [0.05, 0.092, 0.5])
    def test_defaults_follow_a_strike_off_height_that_is_given(self, height):
        heap = Heap(diameter="10 mm", strike_off_height=height)

        assert heap.setup.bulk_density_top <= height
        assert heap.setup.lift_height >= height / 4

    def test_a_default_that_was_valid_before_stays_so_that_runs_keep_their_identity(self):
        setup = Heap(diameter="10 mm", strike_off_height=0.3).setup

        assert (setup.lift_height, setup.bulk_density_top) == pytest.approx((0.1, 0.09))

    def test_a_rim_as_high_as_the_bed(self):
        assert option_faults(rim_height=0.2) == ["rim_height"]

    def test_more_particles_than_any_machine_calibrates_with(self):
        assert option_faults(cylinder_radius=2.0, plate_radius=5.0, strike_off_height=5.0) == [
            "strike_off_height"
        ]
        assert option_faults(particle_count=2_000_000) == ["particle_count"]


class TestDefinition:
    def test_is_json_and_equal_for_equal_tests(self):
        one, other = Heap(MONOSIZE), Heap(MONOSIZE, cylinder_radius=0.06)
        assert json.dumps(one.definition()) == json.dumps(other.definition())

    @pytest.mark.parametrize(
        "change",
        [
            {"lift_speed": 0.04},
            {"views": 6},
            {"time_step_fraction": 0.1},
            {"plate_rolling_friction": 0.1},
            {"sizes": BIDISPERSE},
        ],
    )
    def test_whatever_decides_the_outcome_is_in_it(self, change):
        changed = Heap(**{"sizes": MONOSIZE, **change})
        assert changed.definition() != Heap(MONOSIZE).definition()


class TestDeck:
    @pytest.mark.parametrize("sizes", [MONOSIZE, BIDISPERSE])
    @pytest.mark.parametrize("solver", SOLVERS)
    def test_is_complete_and_reproducible(self, tmp_path, solver, sizes, glass_beads):
        test = Heap(sizes, rim_height=0.01)
        files = []
        for number in (1, 2):
            folder = tmp_path / str(number)
            folder.mkdir()
            deck = write_deck(test, folder, solver, glass_beads, seed=5)
            assert deck.parent == folder
            written = [path for path in folder.iterdir() if path.is_file()]
            files.append({path.name: path.read_text() for path in written})
        assert files[0] == files[1]
        text = files[0][deck.name]
        assert "{{" not in text
        assert "None" not in text
        for name in re.findall(r"\b\w+\.(?:data|stl)\b", text):
            assert name in files[0]

    @pytest.mark.parametrize("solver", SOLVERS)
    def test_both_solvers_start_from_the_same_particles(self, tmp_path, solver, glass_beads):
        write_deck(Heap(BIDISPERSE), tmp_path, solver, glass_beads, seed=5)
        rows = (tmp_path / "particles.data").read_text().split("Atoms\n\n")[1].split("\n")
        particles = np.array([[float(word) for word in row.split()] for row in rows if row])
        setup = Heap(BIDISPERSE).setup
        column = random_column(BIDISPERSE, setup.particle_count, Round(setup.cylinder_radius), 5)
        assert particles[:, 4:] == pytest.approx(column.positions, abs=1e-12)
        assert particles[:, 2].tolist() == [BIDISPERSE.diameters[i] for i in column.size_indices]
        assert set(particles[:, 3]) == {2100.0}

    def test_the_plate_is_of_the_wall_unless_its_options_say_otherwise(self, tmp_path, glass_beads):
        material = {**glass_beads, "particle_particle.rolling_friction": 0.4321}

        def matrix(test):
            deck = write_deck(test, tmp_path, "liggghts", material, seed=1)
            found = re.search(
                r"coefficientRollingFriction peratomtypepair 3 &\n(.*) &", deck.read_text()
            )
            return found.group(1).split()

        rough = Heap(MONOSIZE, plate_rolling_friction="particle_particle")
        assert matrix(rough) == ["0.4321", "0.005", "0.4321"]
        assert matrix(Heap(MONOSIZE, plate_rolling_friction=0.1)) == ["0.4321", "0.005", "0.1"]

    def test_all_that_matters_of_the_material_reaches_the_decks(self, tmp_path, glass_beads):
        # The density of a wall that does not move is the one of the 14 that nothing depends on.
        for solver in SOLVERS:
            plain = write_deck(Heap(MONOSIZE), tmp_path, solver, glass_beads, 1).read_text()
            particles = (tmp_path / "particles.data").read_text()
            for name in glass_beads:
                changed = {**glass_beads, name: glass_beads[name] * 0.9}
                deck = write_deck(Heap(MONOSIZE), tmp_path, solver, changed, 1).read_text()
                same = (deck, (tmp_path / "particles.data").read_text()) == (plain, particles)
                assert same == (name == "wall.density"), name


#: A run that went well, as stages.csv tells it.
ENDED_WELL = (
    "fill,at_rest,2000,0.5,1500,1e-05",
    "lift,done,9000,2.2,1400,1e-05",
    "heap,at_rest,9500,2.3,1390,1e-06",
)


class TestMeasure:
    def write_stages(self, folder, *rows):
        (folder / STAGES).write_text("\n".join((STAGES_HEADER, *rows)) + "\n")

    def measure(self, folder):
        return Heap(MONOSIZE).measure(RunOutput(folder))

    def test_a_bed_that_never_rests_is_said(self, tmp_path):
        self.write_stages(tmp_path, "fill,restless,9000,2.4,1500,0.012")
        with pytest.raises(
            RunFailedError,
            match=messages.RESTLESS.matching(stage="fill", time=2.4, energy=0.012),
        ):
            self.measure(tmp_path)

    def test_an_explosion_is_said(self, tmp_path):
        self.write_stages(tmp_path, ENDED_WELL[0], "lift,unstable,2500,0.6,1400,8.9e+12")
        with pytest.raises(
            RunFailedError, match=messages.UNSTABLE.matching(stage="lift", energy=8.9e12)
        ):
            self.measure(tmp_path)

    @pytest.mark.parametrize("energy", ["nan", "-nan", "inf"])
    def test_an_energy_that_is_no_number_is_an_explosion_too(self, tmp_path, energy):
        self.write_stages(tmp_path, f"heap,restless,9000,2.4,1500,{energy}")
        with pytest.raises(
            RunFailedError,
            match=messages.NOT_FINITE_ENERGY.matching(stage="heap", energy=float(energy)),
        ):
            self.measure(tmp_path)

    def test_particles_that_break_out_are_said(self, tmp_path):
        self.write_stages(tmp_path, "fill,broken,2000,0.5,1490,1e-05")
        with pytest.raises(RunFailedError, match=messages.BROKEN.matching(container="cylinder")):
            self.measure(tmp_path)

    def test_a_run_that_stops_half_way_is_said_with_the_end_of_its_log(self, tmp_path):
        self.write_stages(tmp_path, ENDED_WELL[0])
        (tmp_path / "log.liggghts").write_text("the last words of the program\n")
        with pytest.raises(
            RunFailedError, match=messages.ENDED_EARLY.matching(stages="fill")
        ) as caught:
            self.measure(tmp_path)
        assert "last words" in caught.value.log_tail

    def write_dump(self, path, positions, radius=0.005):
        rows = [
            f"{i} 1 {x:.9g} {y:.9g} {z:.9g} {radius} 0.0011"
            for i, (x, y, z) in enumerate(positions, 1)
        ]
        path.parent.mkdir(exist_ok=True)
        path.write_text(
            f"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n{len(positions)}\n"
            "ITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\n"
            "ITEM: ATOMS id type x y z radius mass\n" + "\n".join(rows) + "\n"
        )

    def write_run(self, folder, bed, heap):
        self.write_stages(folder, *ENDED_WELL)
        self.write_dump(folder / snapshot_file("settled"), bed)
        self.write_dump(folder / snapshot_file("heap"), heap)

    def cubic_bed(self, spacing):
        steps = np.arange(-0.06, 0.06, spacing)
        x, y, z = np.meshgrid(steps, steps, np.arange(0.005, 0.12, spacing))
        bed = np.column_stack((x.ravel(), y.ravel(), z.ravel()))
        return bed[np.hypot(bed[:, 0], bed[:, 1]) < 0.055]

    def test_a_heap_that_rolled_away_leaves_a_picture_all_the_same(self, tmp_path):
        bed = self.cubic_bed(0.0101)
        self.write_run(tmp_path, bed, bed[bed[:, 2] < 0.006])
        with pytest.raises(NotMeasurableError):
            self.measure(tmp_path)
        assert (tmp_path / "heap.png").read_bytes().startswith(b"\x89PNG")
        assert (tmp_path / "heap.vtk").read_bytes().startswith(b"# vtk DataFile")

    def test_a_bed_that_clings_to_the_lifted_cylinder_is_no_heap(self, tmp_path):
        bed, lifted = self.cubic_bed(0.0101), self.cubic_bed(0.01)
        upper = lifted[:, 2] > 0.06
        # The cylinder has a radius of 60 mm.
        lifted[upper] += [0.005, 0.0, 0.05]
        self.write_run(tmp_path, bed, lifted)
        share = 100 * upper.mean()
        with pytest.raises(NotMeasurableError, match=of_heap.CLINGING.matching(percent=share)):
            self.measure(tmp_path)
        assert (tmp_path / "heap.png").read_bytes().startswith(b"\x89PNG")

    def test_particles_squeezed_into_each_other_are_no_bed(self, tmp_path):
        bed = self.cubic_bed(0.0085)
        self.write_run(tmp_path, bed, bed)
        with pytest.raises(RunFailedError, match=of_shared.OVERLAP.matching(percent=15)):
            self.measure(tmp_path)

    def test_a_folder_without_dumps_is_not_measurable(self, tmp_path):
        self.write_stages(tmp_path, *ENDED_WELL)
        with pytest.raises(NotMeasurableError, match=r"settled\.dump"):
            self.measure(tmp_path)


class TestCost:
    def test_time_step_is_the_stated_share_of_the_rayleigh_time_step(self, glass_beads):
        estimated = workload(Heap(MONOSIZE), glass_beads)
        assert estimated.time_step == pytest.approx(0.12 * 0.002054, rel=1e-3)

    def test_stiffer_particles_cost_more(self, glass_beads):
        stiff = {**glass_beads, "particle.youngs_modulus": 100 * 3.6e5}
        test = Heap(MONOSIZE)
        soft_cost, stiff_cost = (
            Lammps.speed.cost(workload(test, material)) for material in (glass_beads, stiff)
        )
        assert stiff_cost.steps == pytest.approx(10 * soft_cost.steps, rel=0.01)
        assert stiff_cost.wall_seconds == pytest.approx(10 * soft_cost.wall_seconds, rel=0.01)

    def test_each_of_very_many_particles_costs_more(self, glass_beads):
        few, more, most = (
            Lammps.speed.cost(workload(Heap(MONOSIZE, particle_count=count), glass_beads))
            for count in (1500, 9000, 90_000)
        )
        each = [cost.wall_seconds / cost.steps / cost.particles for cost in (few, more, most)]
        assert each[1] == pytest.approx(each[0])
        assert each[2] == pytest.approx(9**0.15 * each[0])
        assert re.search(r"about 1 h \d\d min a run", str(replace(most, wall_seconds=4000)))
