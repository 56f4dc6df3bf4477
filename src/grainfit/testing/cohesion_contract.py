# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of models of cohesion: single contacts in the real solvers, against closed forms."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.dmt.contact_model import DMT
from grainfit.contact_models.dmt.model import pull_off_force as dmt_pull_off
from grainfit.contact_models.hertz_mindlin.model import hertz_stiffness, particle_moduli
from grainfit.contact_models.jkr.contact_model import JKR
from grainfit.contact_models.jkr.model import force_at as jkr_force
from grainfit.contact_models.sjkr.contact_model import SJKR
from grainfit.contact_models.sjkr.model import sphere_area
from grainfit.contact_models.sjkr2.contact_model import SJKR2
from grainfit.contact_models.sjkr2.model import area_over_overlap
from grainfit.testing.contact_model_contract import (
    BEADS,
    GRAVITY,
    MASS,
    RADIUS,
    ContactModelContract,
    Simulate,
)
from grainfit.testing.single_contacts import SingleContacts, Sphere

#: Speed of a typical impact, m/s.
_SPEED = math.sqrt(GRAVITY * 2 * RADIUS)
_BODIES = ("particle_particle", "particle_wall")
_ELASTIC = {f"{body}.restitution": 1.0 for body in _BODIES}
#: So low that particles slide all the time.
_FRICTION = 0.05
_NO_ROLLING = {f"{body}.rolling_friction": 0.0 for body in _BODIES}
#: Overlap from which contacts are pulled apart, m.
_PRESSED = 2e-4


class CohesionContract(ContactModelContract):
    """Closed forms of a force of cohesion; subclasses define model, key and force.

    Attributes
    ----------
    key : str
        Key of the parameter.
    strong : float
        A value at which slow particles stick.
    """

    key: ClassVar[str]
    strong: ClassVar[float]

    def force(self, overlap: float, value: float, radius: float, body: str) -> float:
        """Return the normal force of a contact without damping, N; attraction is negative.

        Parameters
        ----------
        overlap : float
            m.
        value : float
            Of the parameter.
        radius : float
            R*, m.
        body : str
            ``"particle"`` or ``"wall"``.
        """
        raise NotImplementedError

    def floor_value(self, program: SingleContacts) -> float:  # noqa: ARG002 (a door)
        """Return the value that a contact with the floor has in a program."""
        return self.material[f"particle_wall.{self.key}"]

    def _changed(self, value: float) -> dict[str, float]:
        return {f"{body}.{self.key}": value for body in _BODIES}

    def test_two_particles_have_the_force_of_the_model_until_they_part(
        self, simulate: Simulate
    ) -> None:
        half = RADIUS - _PRESSED / 2
        motion = simulate(
            [
                Sphere((-half, 0.0, 0.05), (-0.05, 0.0, 0.0)),
                Sphere((half, 0.0, 0.05), (0.05, 0.0, 0.0)),
            ],
            0.01,
            _ELASTIC,
            frames=500,
            time_step_fraction=0.001,
        )
        overlaps = 2 * RADIUS - np.ptp(motion.positions[:, :, 0], axis=1)
        value = self.material[f"particle_particle.{self.key}"]
        self._compare(overlaps, motion.forces[:, 1, 0], value, RADIUS / 2, "particle")

    def test_a_particle_has_the_force_of_the_model_until_it_leaves_the_floor(
        self, program: SingleContacts, simulate: Simulate
    ) -> None:
        motion = simulate(
            [Sphere((0.0, 0.003, RADIUS - _PRESSED), (0.0, 0.0, 0.1))],
            0.01,
            _ELASTIC,
            frames=500,
            time_step_fraction=0.001,
        )
        overlaps = RADIUS - motion.positions[:, 0, 2]
        radius, value = program.floor_radius * RADIUS, self.floor_value(program)
        self._compare(overlaps, motion.forces[:, 0, 2], value, radius, "wall")

    def _compare(
        self,
        overlaps: NDArray[np.float64],
        forces: NDArray[np.float64],
        value: float,
        radius: float,
        body: str,
    ) -> None:
        touching = np.flatnonzero(forces[1:]) + 1
        assert len(touching) > 50
        expected = np.array([self.force(x, value, radius, body) for x in overlaps[touching]])
        # YADE's forces are those of one step before.
        assert forces[touching] == pytest.approx(expected, abs=0.01 * np.ptp(expected))
        # The tension that the contact bears, which is a small part of that where it is pressed.
        assert expected.min() < 0
        assert forces.min() == pytest.approx(expected.min(), rel=0.02)

    def test_an_impact_with_hardly_any_cohesion_has_its_restitution(
        self, program: SingleContacts, simulate: Simulate
    ) -> None:
        changes = self._changed(1e-6 * self.material[f"particle_particle.{self.key}"])
        for restitution, expected in program.restitutions.items():
            motion = simulate(
                [
                    Sphere((-0.0051, 0.0, 0.05), (_SPEED / 2, 0.0, 0.0)),
                    Sphere((0.0051, 0.0, 0.05), (-_SPEED / 2, 0.0, 0.0)),
                    Sphere((-0.05, 0.003, 0.0051), (0.0, 0.0, -_SPEED)),
                ],
                0.03,
                {**changes, **{f"{body}.restitution": restitution for body in _BODIES}},
            )
            rebound = motion.velocities[-1, 1, 0] - motion.velocities[-1, 0, 0]
            assert rebound == pytest.approx(expected * _SPEED, rel=0.02)
            assert motion.velocities[-1, 2, 2] == pytest.approx(expected * _SPEED, rel=0.02)

    def test_slow_particles_stick_and_come_to_rest(self, simulate: Simulate) -> None:
        # Strongly cohesive: the forces are finite where the overlap is none.
        changes = self._changed(self.strong)
        motion = simulate(
            [
                Sphere((-0.00505, 0.0, 0.05), (0.01, 0.0, 0.0)),
                Sphere((0.00505, 0.0, 0.05), (-0.01, 0.0, 0.0)),
                Sphere((-0.05, 0.003, 0.00505), (0.0, 0.0, -0.01)),
            ],
            0.3,
            changes,
        )
        assert np.isfinite(motion.positions).all()
        assert np.ptp(motion.positions[-1, :2, 0]) < 2 * RADIUS
        assert motion.positions[-1, 2, 2] < RADIUS
        assert np.abs(motion.velocities[-1]).max() < 1e-4

    def test_friction_has_the_share_of_the_adhesion_that_the_program_gives_it(
        self, program: SingleContacts, simulate: Simulate
    ) -> None:
        changes = {"particle_wall.sliding_friction": _FRICTION, **_NO_ROLLING}
        material = {**self.material, **changes}
        of_floor = {f"particle_wall.{self.key}": self.floor_value(program)}
        contact = Contact.on_wall({**material, **of_floor}, RADIUS, GRAVITY, 1.0)
        assert self.model.attraction is not None
        found = self.model.attraction(contact)
        attraction = program.floor_radius * found.under_load
        start = Sphere((0.0, 0.003, RADIUS - found.overlap), (0.5, 0.0, 0.0))
        motion = simulate([start], 0.05, changes, gravity=GRAVITY)
        force = MASS * GRAVITY + program.friction_by_adhesion * attraction
        lost = 0.5 - motion.velocities[-1, 0, 0]
        assert lost == pytest.approx(_FRICTION * force / MASS * 0.05, rel=0.05)


class SurfaceEnergyContract(CohesionContract):
    """A model with a surface energy: the pull-off force does not depend on the stiffness."""

    key: ClassVar[str] = "surface_energy"
    strong: ClassVar[float] = 1.0
    material: ClassVar[Mapping[str, float]] = {
        **BEADS,
        "particle_particle.surface_energy": 0.3,
        "particle_wall.surface_energy": 0.2,
    }

    def floor_value(self, program: SingleContacts) -> float:
        """Return the value that a contact with the floor has in a program."""
        return self.material[program.floor_surface_energy]


class JkrContract(SurfaceEnergyContract):
    """Closed forms of JKR; the subclass defines the program.

    References
    ----------
    Johnson, Kendall & Roberts (1971), Proc. R. Soc. Lond. A 324:301-313.
    """

    model: ClassVar[ContactModel] = JKR

    def force(self, overlap: float, value: float, radius: float, body: str) -> float:
        """Return the normal force of a contact, N."""
        return jkr_force(overlap, value, particle_moduli(BEADS, body).young, radius)

    def test_pull_off_is_one_and_a_half_pi_times_work_of_adhesion_and_radius(
        self, program: SingleContacts, simulate: Simulate
    ) -> None:
        motion = simulate(
            [
                Sphere((-RADIUS, 0.0, 0.05), (-0.1, 0.0, 0.0)),
                Sphere((RADIUS - 1e-5, 0.0, 0.05), (0.1, 0.0, 0.0)),
                Sphere((-0.05, 0.003, RADIUS - 1e-5), (0.0, 0.0, 0.2)),
            ],
            0.002,
            _ELASTIC,
            frames=500,
            time_step_fraction=0.001,
        )
        work, floor = 2 * 0.3, 2 * self.floor_value(program)
        expected = 1.5 * math.pi * work * RADIUS / 2
        assert motion.forces[:, 1, 0].min() == pytest.approx(-expected, rel=0.01)
        at_floor = program.floor_pull_off * 1.5 * math.pi * floor * RADIUS
        assert motion.forces[:, 2, 2].min() == pytest.approx(-at_floor, rel=0.02)


class DmtContract(SurfaceEnergyContract):
    """Closed forms of DMT; the subclass defines the program.

    References
    ----------
    Derjaguin, Muller & Toporov (1975), J. Colloid Interface Sci. 53:314-326.
    """

    model: ClassVar[ContactModel] = DMT

    def force(self, overlap: float, value: float, radius: float, body: str) -> float:
        """Return the normal force of a contact, N."""
        elastic = hertz_stiffness(overlap, particle_moduli(BEADS, body), radius) * overlap
        return elastic - dmt_pull_off(value, radius)


class SjkrContract(CohesionContract):
    """Closed forms of SJKR; the subclass defines the program."""

    model: ClassVar[ContactModel] = SJKR
    key: ClassVar[str] = "cohesion_energy_density"
    strong: ClassVar[float] = 2e4
    material: ClassVar[Mapping[str, float]] = {
        **BEADS,
        "particle_particle.cohesion_energy_density": 5e3,
        "particle_wall.cohesion_energy_density": 3e3,
    }

    def force(self, overlap: float, value: float, radius: float, body: str) -> float:
        """Return the normal force of a contact, N."""
        elastic = hertz_stiffness(overlap, particle_moduli(BEADS, body), radius) * overlap
        return elastic - value * self.area(overlap, None if body == "wall" else RADIUS)

    def area(self, overlap: float, other: float | None) -> float:
        """Return the area of contact with another particle, or with a wall, m^2."""
        distance = RADIUS + (other or 0.0) - overlap
        return sphere_area(distance, RADIUS, other)


class Sjkr2Contract(SjkrContract):
    """Closed forms of SJKR2; the subclass defines the program."""

    model: ClassVar[ContactModel] = SJKR2

    def area(self, overlap: float, other: float | None) -> float:
        """Return the area of contact with another particle, or with a wall, m^2."""
        return area_over_overlap(RADIUS, other) * overlap
