"""Runs of one particle size and density serve every other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache

import pytest

import grainfit as gf
from grainfit.bulk_tests.discharge import Discharge
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.natural_units import Scale, natural_run
from grainfit.campaign.reuse import take_runs
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.evaluation import Curve, Measured, Response
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE

#: Values of some responses in several runs.
Simulated = dict[str, list[float]]
FRICTION = "particle_particle.rolling_friction"
DENSITY, MODULUS = "particle.density", "particle.youngs_modulus"
BODIES = ("particle", "wall")
#: A small heap, in diameters.
SMALL = {
    "cylinder_radius": 3.5,
    "plate_radius": 12.0,
    "strike_off_height": 8.5,
    "bulk_density_top": 7.0,
}


@dataclass(frozen=True)
class Material:
    """Beads of a size and density whose E/(rho g d) is the same as that of all others."""

    diameter: float
    density: float
    stiffness: float = 1800.0

    @property
    def values(self) -> dict[str, float]:
        modulus = self.stiffness * self.density * 9.81 * self.diameter
        return {**GLASS_BEADS, DENSITY: self.density, MODULUS: modulus}

    def heap(self) -> Heap:
        lengths = {name: number * self.diameter for name, number in SMALL.items()}
        speed = 0.3 * math.sqrt(self.diameter / 0.010)
        return Heap(diameter=self.diameter, lift_speed=speed, **lengths, **ROUGH_PLATE)

    def solver(self, free: Iterable[str] = ()) -> Lammps:
        fixed = {name: v for name, v in self.values.items() if name not in free}
        return Lammps(self.heap(), fixed)


BEADS = Material(0.010, 2000.0)
FINE = Material(0.002, 1000.0)


def stored(solver: Lammps, responses: Mapping[str, Measured], seed: int = 3) -> RunStore:
    store = RunStore.in_memory()
    run = solver.definition({}, seed)
    store.save(RunRecord(run.identity, "heap", "finished", run, responses))
    return store


def taken(store: RunStore, material: Material, **free: tuple[float, float]) -> list[RunRecord]:
    """Runs of a store that a calibration of these free parameters takes."""
    names = {name.replace("__", "."): interval for name, interval in free.items()}
    problem = gf.Problem(
        [gf.Parameter(name, *interval) for name, interval in names.items()],
        [gf.Target("angle_of_repose", 22.0)],
    )
    here = RunStore.in_memory()
    count = take_runs(store, problem, {"heap": material.solver(names)}, here)
    found = here.runs("finished")
    assert count == len(found)
    return found


ROLLING = {"particle_particle__rolling_friction": (0.1, 1.0)}
RESPONSES = {"bulk_density": Response(1300.0, 10.0), "angle_of_repose": Response(22.0, 1.0)}


def test_natural_units_are_those_of_diameter_density_and_gravity() -> None:
    scale = Scale(0.01, 2000.0, 9.81)

    assert scale.of("m") == 0.01
    assert scale.of("s") == pytest.approx(math.sqrt(0.01 / 9.81))
    assert scale.of("kg") == pytest.approx(2000.0 * 1e-6)
    assert scale.of("Pa") == pytest.approx(2000.0 * 9.81 * 0.01)
    assert scale.of("kg/s") == pytest.approx(2000.0 * math.sqrt(9.81) * 0.01**2.5)
    assert scale.of("deg") == scale.of("") == 1.0


@pytest.mark.parametrize("diameter", [0.002, 0.010, 0.050])
def test_a_run_of_one_size_serves_every_other(diameter: float) -> None:
    material = Material(diameter, 800.0)
    [run] = taken(stored(BEADS.solver(), RESPONSES), material, **ROLLING)

    assert run.definition.parameters[FRICTION] == GLASS_BEADS[FRICTION]
    assert run.definition.identity == run.identity
    assert (
        run.definition.identity
        == material.solver([FRICTION]).definition({FRICTION: GLASS_BEADS[FRICTION]}, 3).identity
    )
    assert run.responses["bulk_density"].value == pytest.approx(1300.0 * 800 / 2000)
    assert run.responses["bulk_density"].standard_error == pytest.approx(4.0)
    assert run.responses["angle_of_repose"] == Response(22.0, 1.0)
    assert run.origin


def test_a_curve_of_one_size_serves_another() -> None:
    def silo(material: Material, free: Iterable[str] = ()) -> Lammps:
        fixed = {name: v for name, v in material.values.items() if name not in free}
        return Lammps(Discharge(diameter=material.diameter), fixed)

    curve = Curve([0.0, 1.0], [0.0, 0.8], stays=True)
    store = stored(silo(BEADS), {"discharged_mass": curve, "mass_flow": Response(1.0)})
    here, other = RunStore.in_memory(), Material(0.040, 2000.0)
    problem = gf.Problem(
        [gf.Parameter(FRICTION, 0.1, 1.0)],
        [],
        curves=[gf.CurveTarget("discharged_mass", [0.5, 1.0], [10.0, 50.0], "2 %")],
    )
    take_runs(store, problem, {"silo": silo(other, [FRICTION])}, here)
    [run] = here.runs("finished")
    found = run.responses["discharged_mass"]

    # Times grow with the root of the diameter, masses with its cube.
    assert isinstance(found, Curve)
    assert found.coordinates == pytest.approx([0.0, 2.0])
    assert found.values == pytest.approx([0.0, 0.8 * 64])
    assert found.stays


def test_a_free_density_follows_from_a_fixed_stiffness_and_the_other_way_round() -> None:
    store = stored(BEADS.solver(), RESPONSES)
    [run] = taken(store, FINE, particle__density=(800.0, 1200.0))
    assert run.definition.parameters[DENSITY] == pytest.approx(1000.0, rel=1e-9)

    [run] = taken(store, FINE, particle__youngs_modulus=(1e4, 1e5))
    assert run.definition.parameters[MODULUS] == pytest.approx(FINE.values[MODULUS], rel=1e-9)


def test_with_density_and_stiffness_free_a_run_lies_within_the_interval_of_the_density() -> None:
    intervals = {"particle__density": (800.0, 1200.0), "particle__youngs_modulus": (1e4, 1e5)}
    [run] = taken(stored(BEADS.solver(), RESPONSES), FINE, **intervals)
    values = run.definition.parameters

    assert values[DENSITY] == 1200.0
    assert values[MODULUS] / (1200.0 * 9.81 * 0.002) == pytest.approx(1800.0)


@pytest.mark.parametrize(
    "other",
    [
        Material(0.002, 1000.0, stiffness=1801.0),
        Material(0.002, 1000.0, stiffness=900.0),
    ],
)
def test_runs_of_another_stiffness_are_other_runs(other: Material) -> None:
    assert taken(stored(BEADS.solver(), RESPONSES), other, **ROLLING) == []


def test_runs_of_another_lift_speed_are_other_runs() -> None:
    solver = Lammps(Heap(diameter="2 mm", lift_speed="0.3 m/s", **ROUGH_PLATE), FINE.values)
    assert taken(stored(solver, RESPONSES), BEADS, **ROLLING) == []


@pytest.mark.parametrize(
    "free",
    [
        ROLLING,
        {"particle__density": (1500.0, 2500.0)},
        {"particle__youngs_modulus": (1e5, 1e6)},
        # Just outside an interval, it must not be taken as it is and at its bound as well.
        {"particle__density": (1500.0, 1900.0), "particle__youngs_modulus": (1e5, 1e6)},
    ],
)
def test_runs_of_the_same_scale_are_taken_once_as_they_are(
    free: dict[str, tuple[float, float]],
) -> None:
    # Densities as a Latin hypercube has them, with all their digits.
    store = stored(Material(0.010, 1981.0280000123).solver(), RESPONSES)
    [run] = taken(store, Material(0.010, 1981.0280000123), **free)
    [original] = store.runs("finished")

    assert run.identity == original.identity
    assert run.responses == original.responses


def test_a_function_has_no_natural_units() -> None:
    solver = PythonCallable(lambda p, s: {"angle_of_repose": 22.0}, identity="drum")
    assert natural_run(solver.definition({}, 1)) is None


@pytest.fixture(scope="module")
def three_heaps(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Material], Simulated]:
    """Give solid fractions and angles of three heaps of a material, each simulated once."""

    @cache
    def simulated(material: Material) -> Simulated:
        folders = [tmp_path_factory.mktemp("heap") for _ in range(3)]
        runs = [
            material.solver().run({}, seed, Workspace(folder, 600.0))
            for seed, folder in enumerate(folders, start=1)
        ]
        return {
            "solid fraction": [r["bulk_density"].value / material.density for r in runs],
            "angle": [r["angle_of_repose"].value for r in runs],
        }

    return simulated


@pytest.mark.slow
@pytest.mark.parametrize("diameter", [0.002, pytest.param(0.050, marks=pytest.mark.thorough)])
def test_simulated_runs_of_two_sizes_are_the_same_run(
    diameter: float, three_heaps: Callable[[Material], Simulated]
) -> None:
    one, other = three_heaps(BEADS), three_heaps(Material(diameter, 800.0))
    # Equal seeds fall from the same places; rounding makes them two samples of one distribution.
    for fraction, again in zip(one["solid fraction"], other["solid fraction"], strict=True):
        assert again == pytest.approx(fraction, rel=0.03)
    difference = sum(other["angle"]) / 3 - sum(one["angle"]) / 3
    # Seeds of this small heap scatter by 1.5 degrees: three standard errors of a mean of three.
    assert abs(difference) < 3 * 1.5 * math.sqrt(2 / 3)


@dataclass(frozen=True)
class Sticky(Material):
    """Beads with a surface energy over rho g d^2."""

    energy: float = 0.005

    @property
    def values(self) -> dict[str, float]:
        energy = self.energy * self.density * 9.81 * self.diameter**2
        return {**super().values, "particle_particle.surface_energy": energy}


def test_cohesion_is_compared_without_its_unit() -> None:
    scale = Scale(0.01, 2000.0, 9.81)
    assert scale.of("J/m^2") == pytest.approx(2000.0 * 9.81 * 0.01**2)
    assert scale.of("J/m^3") == pytest.approx(2000.0 * 9.81 * 0.01)

    store = stored(Sticky(0.010, 2000.0).solver(), RESPONSES)
    [run] = taken(store, Sticky(0.002, 1000.0), **ROLLING)
    assert run.definition.parameters["particle_particle.surface_energy"] == pytest.approx(
        0.005 * 1000.0 * 9.81 * 0.002**2
    )
    # The same surface energy is a larger Bond number on small particles.
    same_energy = Sticky(0.002, 1000.0, energy=0.005 * 2000.0 / 1000.0 * 25)
    assert taken(store, same_energy, **ROLLING) == []
    assert taken(store, FINE, **ROLLING) == []
    assert taken(stored(BEADS.solver(), RESPONSES), Sticky(0.002, 1000.0), **ROLLING) == []


def test_a_free_density_follows_from_a_fixed_cohesion_or_no_cohesion_says_nothing() -> None:
    store = stored(Sticky(0.010, 2000.0).solver(), RESPONSES)
    [run] = taken(store, Sticky(0.002, 1000.0), particle__density=(800.0, 1200.0))
    assert run.definition.parameters[DENSITY] == pytest.approx(1000.0, rel=1e-9)
    assert taken(store, FINE, particle__density=(800.0, 1200.0)) == []


def test_linear_springs_are_the_same_where_stiffness_over_weight_is() -> None:
    def solver(material: Material, stiffness: float) -> Lammps:
        weight = material.density * 9.81 * material.diameter**2
        springs = {f"particle_{body}.normal_stiffness": stiffness * weight for body in BODIES}
        return Lammps(material.heap(), {**material.values, **springs}, contact_models=["linear"])

    runs = [
        natural_run(solver(material, stiffness).definition({}, 3))
        for material, stiffness in ((BEADS, 900.0), (FINE, 900.0), (FINE, 1000.0))
    ]
    first, same, other = runs
    assert first is not None
    assert same is not None
    assert other is not None
    assert first.is_same(same)
    assert not first.is_same(other)
    usual = natural_run(BEADS.solver().definition({}, 3))
    assert usual is not None
    assert usual.model_hash != first.model_hash
