# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of programs that simulate scenes: elementary impacts with published results.

Inherit `ImpactContract` as `grainfit.testing.scene_contract.SceneContract`. Particles start without
spin: an impact with a spin is simulated in a frame of reference in which it has none, and the
seventh impact of the reference (two opposite spins) is not among them. ``studies/benchmarks`` has
all eight, with spins.

References
----------
Chung & Ooi (2011), Granular Matter 13:643-656: eight elementary impacts. Figures 4 to 6 were
digitised by the developers of Kratos Multiphysics.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.contact_models.contact import particle_mass
from grainfit.contact_models.hertz_mindlin.model import impact_overlap, impact_time, particle_moduli
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.records import KineticEnergy, Series
from grainfit.scenes.scene import Box, Scene, Stage, Wall, time_step
from grainfit.scenes.shapes import Plane
from grainfit.testing.simulated_scenes import Run, SimulatedScenes, final_velocities, material

#: Young's modulus, Pa; Poisson's ratio; density, kg/m^3.
GLASS = (48e9, 0.20, 2800.0)
LIMESTONE = (20e9, 0.25, 2500.0)
ALUMINIUM_ALLOY = (70e9, 0.30, 2699.0)
MAGNESIUM_ALLOY = (40e9, 0.35, 1800.0)
ALUMINIUM_OXIDE = (380e9, 0.23, 4000.0)
CAST_IRON = (100e9, 0.25, 7000.0)
SECOND_ALUMINIUM_ALLOY = (70e9, 0.33, 2700.0)
STEEL = (208e9, 0.30, 7850.0)
POLYETHYLENE = (1e9, 0.40, 1400.0)

#: Fourth impact, figure 8: angle of incidence, degrees; tangential restitution.
TANGENTIAL_RESTITUTION = {
    "oxide": (
        ALUMINIUM_OXIDE,
        {5.168: 0.9481, 10.158: 0.6870, 14.990: 0.6244, 20.059: 0.6161, 25.050: 0.6343,
         30.119: 0.6837, 40.020: 0.7809, 50.000: 0.8451, 69.960: 0.9316, 85.010: 0.9827},
    ),
    "alloy": (
        SECOND_ALUMINIUM_ALLOY,
        {5.089: 0.8987, 10.000: 0.6713, 15.069: 0.6129, 20.059: 0.6087, 24.970: 0.6334,
         30.040: 0.6829, 40.020: 0.7801, 49.921: 0.8443, 70.040: 0.9325, 84.931: 0.9827},
    ),
}  # fmt: skip
#: Fourth impact, oxide: angle of incidence, and angle of rebound of the contact patch, degrees.
PATCH_REBOUND = {
    4.901: 3.761, 9.959: -1.556, 14.935: -5.544, 19.988: -7.538, 24.958: -7.538, 29.922: -3.550,
    34.962: 3.429, 39.920: 11.571, 49.834: 29.350, 59.987: 47.795,
}  # fmt: skip
#: Sixth and eighth impact, aluminium alloy: 3.5 mu (1 + e) v_n / v_t, and the restitution of the
#: contact patch.
PATCH_RESTITUTION = {
    0.1762: -0.8200, 0.3524: -0.6335, 0.5507: -0.4447, 0.7709: -0.2428, 0.9692: -0.0277,
}  # fmt: skip


def impact_material(
    body: tuple[float, float, float], restitution: float = 1.0, sliding_friction: float = 0.0
) -> dict[str, float]:
    """Return a material that meets a wall which does not deform."""
    young, poisson, density = body
    return {
        **material(restitution, sliding_friction),
        "particle.youngs_modulus": young,
        "particle.poissons_ratio": poisson,
        "particle.density": density,
        "wall.youngs_modulus": 1e16,
    }


def impact_scene(
    values: Mapping[str, float],
    radii: Sequence[float],
    positions: Sequence[Sequence[float]],
    velocities: Sequence[Sequence[float]],
    seconds: float,
    **options: Any,
) -> Scene:
    """Return particles in flight for some time, with snapshots at two thirds and at the end.

    A plane is at z = 0 unless other walls are given.
    """
    sizes = sorted(set(radii))
    distribution = ParticleSizes(
        tuple(2 * radius for radius in sizes), tuple(1 / len(sizes) for _ in sizes)
    )
    kinds = np.array([sizes.index(radius) for radius in radii])
    places = np.array(positions, dtype=float)
    side = float(np.abs(places).max()) + 6 * sizes[-1]
    step = time_step(distribution, values, 0.01)
    series = Series({"energy": KineticEnergy()}, step)
    given: dict[str, Any] = {
        "walls": {"target": Wall(Plane("z", 0.0))},
        "gravity": 9.81,
        **options,
    }
    return Scene(
        title="Elementary impact",
        material=values,
        sizes=distribution,
        particles=Column(
            places, kinds, float(places[:, 2].max()), np.array(velocities, dtype=float)
        ),
        box=Box((-side, -side, -side), (side, side, side)),
        stages=(
            Stage("impact", Elapsed(2 / 3 * seconds), series=series, snapshot="after"),
            Stage("flight", Elapsed(seconds / 3), snapshot="later"),
        ),
        time_step=step,
        quiet_speed=1e-9,
        check_interval=seconds,
        **given,
    )


class ImpactContract(SimulatedScenes):
    """Elementary impacts of Chung & Ooi (2011); the subclass defines the program.

    Attributes
    ----------
    oblique_tolerance, patch_tolerance : float
        Of the fourth impact: tangential restitution, and angle of the contact patch in degrees.
    sliding_tolerance : float
        Of the restitution of a sliding contact patch.
    """

    oblique_tolerance: ClassVar[float] = 0.02
    patch_tolerance: ClassVar[float] = 1.5
    sliding_tolerance: ClassVar[float] = 0.16

    @pytest.mark.parametrize("body", [GLASS, LIMESTONE], ids=["glass", "limestone"])
    def test_first_impact_two_elastic_spheres(
        self, run: Run, body: tuple[float, float, float]
    ) -> None:
        radius, speed, values = 0.010, 10.0, impact_material(body)
        moduli = particle_moduli(values, "particle")
        mass = particle_mass(values, radius)
        time = impact_time(2 * speed, mass / 2, moduli, radius / 2)
        places = [(-radius * 1.0001, 0, 0.05), (radius * 1.0001, 0, 0.05)]
        scene = impact_scene(
            values, [radius] * 2, places, [(speed, 0, 0), (-speed, 0, 0)], 3 * time, walls={}
        )
        out = run(scene)

        assert self._contact_time(scene, out.series("impact")) == pytest.approx(time, rel=0.02)
        rebound = final_velocities(out, scene)[:, 0]
        assert rebound == pytest.approx([-speed, speed], rel=5e-3)

    @pytest.mark.parametrize("body", [ALUMINIUM_ALLOY, MAGNESIUM_ALLOY], ids=["al", "mg"])
    def test_second_impact_an_elastic_sphere_on_a_plane(
        self, run: Run, body: tuple[float, float, float]
    ) -> None:
        radius, speed, values = 0.100, 0.2, impact_material(body)
        effective = self.wall_radius * radius
        moduli = particle_moduli(values, "wall")
        mass = particle_mass(values, radius)
        time = impact_time(speed, mass, moduli, effective)
        start = radius + 0.1 * impact_overlap(speed, mass, moduli, effective)
        scene = impact_scene(
            values, [radius], [(0, 0, start)], [(0, 0, -speed)], 3 * time, gravity=1e-5
        )
        out = run(scene)

        assert self._contact_time(scene, out.series("impact")) == pytest.approx(time, rel=0.02)
        assert out.stages[-1].kinetic_energy == pytest.approx(mass * speed**2 / 2, rel=0.02)

    @pytest.mark.parametrize(
        ("body", "restitution"), [(ALUMINIUM_OXIDE, 0.2), (CAST_IRON, 0.6), (ALUMINIUM_OXIDE, 1.0)]
    )
    def test_third_impact_normal_restitution(
        self, run: Run, body: tuple[float, float, float], restitution: float
    ) -> None:
        radius, speed, values = 0.0025, 3.9, impact_material(body, restitution)
        scene = impact_scene(values, [radius], [(0, 0, 1.0001 * radius)], [(0, 0, -speed)], 1e-4)
        energies = run(scene).series("impact")["energy"]

        before = particle_mass(values, radius) * speed**2 / 2
        assert math.sqrt(energies[-1] / before) == pytest.approx(restitution, abs=0.01)

    @pytest.mark.parametrize("name", TANGENTIAL_RESTITUTION)
    def test_fourth_impact_oblique_with_friction(self, run: Run, name: str) -> None:
        body, published = TANGENTIAL_RESTITUTION[name]
        angles = np.radians(list(published))
        before = 3.9 * np.column_stack((np.sin(angles), np.zeros(len(angles)), -np.cos(angles)))
        after = self._rebounds(run, impact_material(body, 0.98, 0.092), 0.0025, before, 0.0025)

        found = after[:, 0] / before[:, 0]
        assert found == pytest.approx(list(published.values()), abs=self.oblique_tolerance)

    def test_fourth_impact_rebound_of_the_contact_patch(self, run: Run) -> None:
        angles = np.radians(list(PATCH_REBOUND))
        before = 3.9 * np.column_stack((np.sin(angles), np.zeros(len(angles)), -np.cos(angles)))
        values = impact_material(ALUMINIUM_OXIDE, 0.98, 0.092)
        after = self._rebounds(run, values, 0.0025, before, 0.0025)

        found = np.degrees(np.arctan2(_patch_velocity(before, after), after[:, 2]))
        assert found == pytest.approx(list(PATCH_REBOUND.values()), abs=self.patch_tolerance)

    @pytest.mark.parametrize("body", [STEEL, POLYETHYLENE], ids=["steel", "polyethylene"])
    def test_fifth_impact_recoil_of_a_sliding_contact_patch(
        self, run: Run, body: tuple[float, float, float]
    ) -> None:
        # Sliding from beginning to end: friction takes 7/2 mu (1 + e) v_n off the velocity.
        friction, speed = 0.3, 5.0
        scaled = np.array([7.5, 10.0, 13.0, -10.0])
        before = np.zeros((len(scaled), 3))
        before[:, 0], before[:, 2] = scaled * friction * speed, -speed
        after = self._rebounds(run, impact_material(body, 1.0, friction), 1e-5, before, 1e-5)

        patch = _patch_velocity(before, after) / (friction * speed)
        assert patch == pytest.approx(scaled - 7 * np.sign(scaled), abs=0.1)

    # With so much damping the tangential impulse differs between programs: measured, it is up to
    # 10 % below friction times normal impulse in LAMMPS, and 16 % above in LIGGGHTS.
    def test_sixth_impact_restitution_of_a_sliding_contact_patch(self, run: Run) -> None:
        values = impact_material(SECOND_ALUMINIUM_ALLOY, 0.5, 0.4)
        before = self._grazing(0.2, values)
        after = self._rebounds(run, values, 0.100, before, 0.1, gravity=1e-3)

        found = -_patch_velocity(before, after) / before[:, 0]
        published = list(PATCH_RESTITUTION.values())
        assert found == pytest.approx(published, abs=self.sliding_tolerance)

    def test_eighth_impact_two_spheres_of_different_sizes(self, run: Run) -> None:
        small, large = 0.1, 0.5
        values = impact_material(SECOND_ALUMINIUM_ALLOY, 0.5, 0.4)
        before = self._grazing(0.2, values)
        rows = 2.0 * np.arange(len(before)) * (small + large)
        above = 1.00001 * (small + large)
        places = [place for y in rows for place in ((0, y, above), (0, y, 0))]
        velocities = [row for velocity in before.tolist() for row in (velocity, (0.0, 0.0, 0.0))]
        scene = impact_scene(
            values,
            [small, large] * len(before),
            places,
            velocities,
            0.003,
            walls={},
            gravity=1e-3,
        )
        after = final_velocities(run(scene), scene)[::2]
        # The large sphere takes up the impulse, too.
        after[:, 0] -= (before[:, 0] - after[:, 0]) * (small / large) ** 3
        reached = -_patch_velocity(before, after) / before[:, 0]

        published = list(PATCH_RESTITUTION.values())
        assert reached == pytest.approx(published, abs=self.sliding_tolerance)

    @staticmethod
    def _grazing(normal: float, values: Mapping[str, float]) -> NDArray[np.float64]:
        """Return velocities of the published abscissae of `PATCH_RESTITUTION`."""
        friction = values["particle_wall.sliding_friction"]
        factor = 3.5 * friction * (1 + values["particle_wall.restitution"])
        tangential = factor * normal / np.array(list(PATCH_RESTITUTION))
        zeros = np.zeros(len(tangential))
        return np.column_stack((tangential, zeros, zeros - normal))

    @staticmethod
    def _rebounds(
        run: Run,
        values: Mapping[str, float],
        radius: float,
        before: NDArray[np.float64],
        apart: float,
        **options: Any,
    ) -> NDArray[np.float64]:
        """Return the velocities after simultaneous impacts of many particles on a plane."""
        moduli = particle_moduli(values, "wall")
        slowest = float(-before[:, 2].max())
        time = impact_time(slowest, particle_mass(values, radius), moduli, radius)
        sides = 4 * apart * (np.arange(len(before)) - len(before) / 2)
        places = [(0.0, side, 1.0001 * radius) for side in sides]
        seconds = 5 * time + 6e-4 * radius / slowest
        scene = impact_scene(
            values, [radius] * len(before), places, before.tolist(), seconds, **options
        )
        return final_velocities(run(scene), scene)

    @staticmethod
    def _contact_time(scene: Scene, series: Mapping[str, NDArray[np.float64]]) -> float:
        """Return the time during which some kinetic energy is stored in an elastic contact, s."""
        flying = scene.initial_energy * (1 - 1e-6)
        touching = series["time"][series["energy"] < flying]
        return float(np.ptp(touching))


def _patch_velocity(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """Velocity of the contact patch after an impact without spin before it.

    The tangential impulse that changes the velocity by dv changes the spin by 5 dv / (2 r).
    """
    return after[:, 0] - 5 / 2 * (before[:, 0] - after[:, 0])
