# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of contact models, as tests to inherit: single contacts in the real solvers.

Write a test class for a custom contact model, in a file that pytest finds::

    from grainfit.testing.contact_model_contract import ContactModelContract

    class TestMyModel(ContactModelContract):
        model = MY_MODEL
        material = {**GLASS_BEADS, "particle_particle.my_parameter": 0.1, ...}

        @pytest.fixture(params=MY_MODEL.solvers)
        def program(self, request):
            return ...  # the `SingleContacts` of this solver

and add the closed forms of the model. A new solver inherits `HertzMindlinContract`,
`EpsdContract` and `Epsd2Contract` with its own `SingleContacts`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.contact_models.base import ContactModel
from grainfit.contact_models.contact import TYPICAL_LOAD, particle_mass
from grainfit.contact_models.epsd.contact_model import EPSD
from grainfit.contact_models.epsd.model import rolling_spring
from grainfit.contact_models.epsd2.contact_model import EPSD2
from grainfit.contact_models.epsd2.model import rolling_stiffness
from grainfit.contact_models.hertz_mindlin.contact_model import HERTZ_MINDLIN
from grainfit.contact_models.hertz_mindlin.model import (
    EffectiveModuli,
    damping_factor,
    hertz_overlap,
    hertz_stiffness,
    impact_overlap,
    impact_time,
    particle_moduli,
    tangential_stiffness,
)
from grainfit.contact_models.linear.contact_model import LINEAR
from grainfit.contact_models.linear.model import impact_overlap as spring_overlap
from grainfit.contact_models.linear.model import impact_time as spring_time
from grainfit.contact_models.registry import MATERIAL_PARAMETERS, contact_law, with_defaults
from grainfit.materials.equations import SYMBOLS
from grainfit.run_definition import without_defaults
from grainfit.testing.materials import GLASS_BEADS
from grainfit.testing.single_contacts import ContactCase, Motion, SingleContacts, Sphere
from grainfit.units import is_unit

RADIUS = 0.005
DENSITY = 2100.0
GRAVITY = 9.81
#: Glass beads on a floor of the same stiffness, with a different restitution.
BEADS: Mapping[str, float] = {
    **GLASS_BEADS,
    "particle.density": DENSITY,
    "wall.youngs_modulus": 2.0e5,
    "wall.poissons_ratio": 0.40,
    "particle_wall.restitution": 0.55,
}
MASS = particle_mass(BEADS, RADIUS)
Simulate = Callable[..., Motion]


class ContactModelContract:
    """Tests that hold for every contact model; subclasses define model, material and program.

    Attributes
    ----------
    model : ContactModel
        The model under test, which is registered.
    material : mapping of str to float
        All material parameters, with values at which the model acts.
    """

    model: ClassVar[ContactModel]
    material: ClassVar[Mapping[str, float]] = BEADS

    @pytest.fixture
    def program(self) -> SingleContacts:
        """Return the program of a solver that has the model."""
        raise NotImplementedError

    @pytest.fixture
    def simulate(self, program: SingleContacts, tmp_path: Path) -> Simulate:
        """Return a function that simulates particles; options are fields of `ContactCase`."""

        def simulate(
            particles: Sequence[Sphere],
            seconds: float,
            changes: Mapping[str, float] | None = None,
            **options: Any,
        ) -> Motion:
            material = {**self.material, **(changes or {})}
            folder = tmp_path / str(len(list(tmp_path.iterdir())))
            folder.mkdir()
            case = ContactCase(
                contact_law(material, [self.model.name]), material, particles, seconds, **options
            )
            return program.simulate(case, folder)

        return simulate

    def test_parameters_are_declared_completely(self) -> None:
        for parameter in self.model.parameters:
            assert MATERIAL_PARAMETERS[parameter.name] == parameter
            assert parameter.symbol
            assert parameter.description
            assert not parameter.unit or is_unit(parameter.unit)
            assert -math.inf < parameter.lowest < parameter.highest < math.inf
            if parameter.default is not None:
                assert parameter.lowest <= parameter.default <= parameter.highest

    def test_the_model_acts_in_the_material_and_the_solver_has_it(
        self, program: SingleContacts
    ) -> None:
        law = contact_law(self.material, [self.model.name])

        assert self.model in law.models
        assert law.without(program.solver) == []

    def test_its_terms_have_equations_of_which_every_symbol_is_explained(
        self, program: SingleContacts
    ) -> None:
        law = contact_law(self.material, [self.model.name])

        assert not list(self.model.missing())
        for solver in ("", program.solver):
            equations = law.equations(solver)
            explained = {*SYMBOLS, *(convention.symbol for convention in law.conventions)}
            for equation in equations:
                explained |= equation.symbols_explained
            for equation in equations:
                assert equation.symbols <= explained, equation.words

    def test_a_solver_differs_in_terms_of_the_law(self, program: SingleContacts) -> None:
        law = contact_law(self.material, [self.model.name])
        terms = {equation.term for equation in law.equations()}

        for solver, equation in law.differing_terms:
            assert solver != program.solver or equation.term in terms, equation.words

    def test_at_its_defaults_an_optional_model_changes_nothing(self) -> None:
        names = {parameter.name for parameter in self.model.parameters}
        rest = {name: value for name, value in self.material.items() if name not in names}
        defaults = {parameter.name: parameter.default for parameter in self.model.parameters}
        if self.model.is_optional:
            at_defaults = {**rest, **{n: v for n, v in defaults.items() if v is not None}}

            assert self.model not in contact_law(at_defaults).models
            assert without_defaults(at_defaults, with_defaults({})) == rest
        else:
            assert None in defaults.values()

    def test_a_collision_keeps_momentum_and_gives_no_energy(self, simulate: Simulate) -> None:
        # Oblique, off centre, with spins, and of two sizes: all parts of the contact law act.
        small, large = 0.8 * RADIUS, RADIUS
        particles = [
            Sphere((-0.0046, 0.0, 0.1), (0.3, 0.1, 0.0), (10.0, 20.0, -30.0), small),
            Sphere((0.0046, 0.001, 0.1), (-0.2, 0.0, 0.05), (0.0, 40.0, 5.0), large),
        ]
        motion = simulate(particles, 0.03)
        masses = np.array([particle_mass(self.material, s.radius) for s in particles])
        inertias = 2 / 5 * masses * np.array([small, large]) ** 2

        assert not np.allclose(motion.velocities[0], motion.velocities[-1], atol=0.05)
        before, after = (_momenta(motion, frame, masses, inertias) for frame in (0, -1))
        scale = masses[0] * 0.3
        assert after[0] == pytest.approx(before[0], abs=1e-6 * scale)
        # Solvers lose angular momentum where their lever differs from the point of contact.
        assert after[1] == pytest.approx(before[1], abs=0.02 * scale * RADIUS)
        energies = [_kinetic_energy(motion, frame, masses, inertias) for frame in (0, -1)]
        assert energies[1] < energies[0]


class HertzMindlinContract(ContactModelContract):
    """Closed forms of Hertz and Mindlin; the subclass defines the program.

    References
    ----------
    Johnson (1985), Contact Mechanics, chapters 4.2, 7.2 and 11.4.
    """

    model: ClassVar[ContactModel] = HERTZ_MINDLIN

    @pytest.fixture
    def resting(self, program: SingleContacts) -> float:
        """Overlap of one particle that rests on the floor, m."""
        return _resting(program)

    def test_an_elastic_impact_of_two_particles_is_johnsons(self, simulate: Simulate) -> None:
        speed, moduli = 0.5, particle_moduli(self.material, "particle")
        time = impact_time(speed, MASS / 2, moduli, RADIUS / 2)
        start = (1 + 1e-9) * RADIUS
        motion = simulate(
            [
                Sphere((-start, 0.0, 0.05), (speed / 2, 0.0, 0.0)),
                Sphere((start, 0.0, 0.05), (-speed / 2, 0.0, 0.0)),
            ],
            1.5 * time,
            {"particle_particle.restitution": 1.0},
            frames=600,
            time_step_fraction=0.002,
        )
        overlap = 2 * RADIUS - np.ptp(motion.positions[:, :, 0], axis=1)
        deepest = impact_overlap(speed, MASS / 2, moduli, RADIUS / 2)
        assert overlap.max() == pytest.approx(deepest, rel=2e-3)
        strongest = hertz_stiffness(deepest, moduli, RADIUS / 2) * deepest
        assert motion.forces[:, 1, 0].max() == pytest.approx(strongest, rel=3e-3)
        assert motion.times[overlap > 0][-1] == pytest.approx(time, rel=5e-3)
        assert np.diff(motion.velocities[-1, :, 0]) == pytest.approx(speed, rel=2e-3)

    def test_an_elastic_impact_on_the_floor_has_the_stiffness_of_both_bodies(
        self, program: SingleContacts, simulate: Simulate
    ) -> None:
        speed, moduli = 0.5, particle_moduli(self.material, "wall")
        radius = program.floor_radius * RADIUS
        time = impact_time(speed, MASS, moduli, radius)
        motion = simulate(
            [Sphere((0.0, 0.0, (1 + 1e-9) * RADIUS), (0.0, 0.0, -speed))],
            1.5 * time,
            {"particle_wall.restitution": 1.0},
            frames=600,
            time_step_fraction=0.002,
        )
        overlap = RADIUS - motion.positions[:, 0, 2]
        assert overlap.max() == pytest.approx(impact_overlap(speed, MASS, moduli, radius), rel=2e-3)
        assert motion.times[overlap > 0][-1] == pytest.approx(time, rel=5e-3)

    @pytest.mark.parametrize("restitution", [0.3, 0.79])
    def test_two_particles_rebound_with_their_own_restitution(
        self, simulate: Simulate, restitution: float
    ) -> None:
        motion = simulate(
            [
                Sphere((-0.0051, 0.0, 0.05), (0.25, 0.0, 0.0)),
                Sphere((0.0051, 0.0, 0.05), (-0.25, 0.0, 0.0)),
            ],
            0.02,
            {"particle_particle.restitution": restitution},
        )
        rebound = np.diff(motion.velocities[-1, :, 0])
        assert rebound == pytest.approx(restitution * 0.5, rel=0.02)

    def test_a_particle_rebounds_from_the_floor_with_the_walls_restitution(
        self, simulate: Simulate
    ) -> None:
        motion = simulate([Sphere((0.0, 0.003, 0.0051), (0.0, 0.0, -0.5))], 0.02)
        assert motion.velocities[-1, 0, 2] == pytest.approx(0.55 * 0.5, rel=0.02)

    def test_a_particle_rests_at_hertz_overlap(self, simulate: Simulate, resting: float) -> None:
        motion = simulate([_on_floor(resting)], 0.05, gravity=GRAVITY)
        assert RADIUS - motion.positions[-1, 0, 2] == pytest.approx(resting, rel=1e-3)

    def test_sticking_has_the_stiffness_of_mindlin(
        self, program: SingleContacts, simulate: Simulate, resting: float
    ) -> None:
        # A slow start from rest: the spring has taken up the whole displacement, and nothing slips.
        # Restitution 1 has no dashpot.
        moduli = particle_moduli(self.material, "wall")
        contact_radius = math.sqrt(program.floor_radius * RADIUS * resting)
        stiffness = tangential_stiffness(moduli) * contact_radius
        # Sticking, a sphere oscillates with 7/2 of the inertia of a block.
        period = 2 * math.pi * math.sqrt(MASS / (3.5 * stiffness))
        motion = simulate(
            [_on_floor(resting, (1e-5, 0.0, 0.0))],
            period / 20,
            {"particle_wall.restitution": 1.0, "particle_wall.sliding_friction": 10.0}
            | _NO_ROLLING,
            gravity=GRAVITY,
            time_step_fraction=0.0005,
        )
        # Of the point of contact: translation, and the spin that follows from it.
        phase = 2 * math.pi / 20
        displacement = 1e-5 * period / (2 * math.pi) * math.sin(phase)
        assert motion.forces[-1, 0, 0] == pytest.approx(-stiffness * displacement, rel=0.02)

    def test_sliding_decelerates_with_the_friction_of_the_floor(
        self, simulate: Simulate, resting: float
    ) -> None:
        slide = {"particle_wall.sliding_friction": 0.2, **_NO_ROLLING}
        motion = simulate([_on_floor(resting, (0.5, 0.0, 0.0))], 0.05, slide, gravity=GRAVITY)
        lost = 0.5 - motion.velocities[-1, 0, 0]
        assert lost == pytest.approx(0.2 * GRAVITY * 0.05, rel=0.03)

    def test_a_sliding_particle_ends_rolling_at_five_sevenths_of_its_speed(
        self, simulate: Simulate, resting: float
    ) -> None:
        slide = {"particle_wall.sliding_friction": 0.5, **_NO_ROLLING}
        motion = simulate([_on_floor(resting, (0.5, 0.0, 0.0))], 0.08, slide, gravity=GRAVITY)
        _require_rolling_after_sliding(motion, 0.5)

    def test_an_oblique_impact_that_slides_throughout_loses_mu_times_the_normal_impulse(
        self, simulate: Simulate
    ) -> None:
        # Elastic: with a dashpot, solvers differ in what limits friction while bodies part.
        # Slow: the lever of the torque is the radius, or the radius less the overlap.
        oblique = Sphere((0.0, 0.0, 0.0051), (0.1, 0.0, -0.02))
        changes = {
            "particle_wall.sliding_friction": 0.1,
            "particle_wall.restitution": 1.0,
            **_NO_ROLLING,
        }
        motion = simulate([oblique], 0.03, changes)
        lost = 0.1 * 2 * 0.02
        assert 0.1 - motion.velocities[-1, 0, 0] == pytest.approx(lost, rel=1e-3)
        assert motion.spins[-1, 0, 1] == pytest.approx(5 / 2 * lost / RADIUS, rel=0.02)


class LinearContract(ContactModelContract):
    """Closed forms of linear springs and dashpots; the subclass defines the program."""

    model: ClassVar[ContactModel] = LINEAR
    #: Without rolling friction, which not every solver has beside it; the springs are given.
    material: ClassVar[Mapping[str, float]] = {
        **BEADS,
        "particle_particle.rolling_friction": 0.0,
        "particle_wall.rolling_friction": 0.0,
        "particle_particle.normal_stiffness": 800.0,
        "particle_particle.tangential_stiffness": 300.0,
        "particle_wall.normal_stiffness": 1500.0,
        "particle_wall.tangential_stiffness": 600.0,
    }

    @pytest.mark.parametrize("restitution", [1.0, 0.79, 0.3])
    def test_an_impact_of_two_particles_is_that_of_a_spring_and_a_dashpot(
        self, program: SingleContacts, simulate: Simulate, restitution: float
    ) -> None:
        speed, stiffness, start = 0.5, 800.0, (1 + 1e-9) * RADIUS
        damping = damping_factor(restitution)
        time = spring_time(MASS / 2, stiffness, damping)
        motion = simulate(
            [
                Sphere((-start, 0.0, 0.05), (speed / 2, 0.0, 0.0)),
                Sphere((start, 0.0, 0.05), (-speed / 2, 0.0, 0.0)),
            ],
            1.5 * time,
            {"particle_particle.restitution": restitution},
            frames=600,
            time_step_fraction=0.002,
        )
        overlap = 2 * RADIUS - np.ptp(motion.positions[:, :, 0], axis=1)
        rebound = np.diff(motion.velocities[-1, :, 0])
        assert rebound == pytest.approx(restitution * speed, rel=5e-3)
        if restitution == 1 or not program.never_pulls:
            deepest = spring_overlap(speed, MASS / 2, stiffness) * _deepest(damping)
            assert overlap.max() == pytest.approx(deepest, rel=2e-3)
            assert motion.times[overlap > 0][-1] == pytest.approx(time, rel=5e-3)

    @pytest.mark.parametrize("given", [True, False])
    def test_an_elastic_impact_on_the_floor_has_its_springs(
        self, simulate: Simulate, given: bool
    ) -> None:
        changes = {"particle_wall.restitution": 1.0}
        stiffness = 1500.0
        if not given:
            changes |= {f"particle_{b}.{k}": 0.0 for b in ("particle", "wall") for k in _SPRINGS}
            stiffness = 2 * particle_moduli(self.material, "wall").young * RADIUS
        time = spring_time(MASS, stiffness)
        motion = simulate(
            [Sphere((0.0, 0.0, (1 + 1e-9) * RADIUS), (0.0, 0.0, -0.5))],
            1.5 * time,
            changes,
            frames=600,
            time_step_fraction=0.002,
        )
        overlap = RADIUS - motion.positions[:, 0, 2]
        assert overlap.max() == pytest.approx(spring_overlap(0.5, MASS, stiffness), rel=2e-3)
        assert motion.times[overlap > 0][-1] == pytest.approx(time, rel=5e-3)

    def test_a_particle_rebounds_from_the_floor_with_the_walls_restitution(
        self, simulate: Simulate
    ) -> None:
        motion = simulate([Sphere((0.0, 0.003, 0.0051), (0.0, 0.0, -0.5))], 0.02)
        assert motion.velocities[-1, 0, 2] == pytest.approx(0.55 * 0.5, rel=0.01)

    def test_sticking_has_the_tangential_spring(self, simulate: Simulate) -> None:
        resting = MASS * GRAVITY / 1500.0
        # Sticking, a sphere oscillates with 7/2 of the inertia of a block.
        period = 2 * math.pi * math.sqrt(MASS / (3.5 * 600.0))
        motion = simulate(
            [_on_floor(resting, (1e-4, 0.0, 0.0))],
            period / 20,
            {"particle_wall.restitution": 1.0, "particle_wall.sliding_friction": 10.0},
            gravity=GRAVITY,
            time_step_fraction=0.0005,
        )
        displacement = 1e-4 * period / (2 * math.pi) * math.sin(2 * math.pi / 20)
        assert motion.forces[-1, 0, 0] == pytest.approx(-600.0 * displacement, rel=0.02)

    def test_sliding_decelerates_with_the_friction_of_the_floor(self, simulate: Simulate) -> None:
        start = _on_floor(MASS * GRAVITY / 1500.0, (0.5, 0.0, 0.0))
        motion = simulate([start], 0.05, {"particle_wall.sliding_friction": 0.2}, gravity=GRAVITY)
        lost = 0.5 - motion.velocities[-1, 0, 0]
        assert lost == pytest.approx(0.2 * GRAVITY * 0.05, rel=0.03)

    def test_a_sliding_particle_ends_rolling_at_five_sevenths_of_its_speed(
        self, simulate: Simulate
    ) -> None:
        start = _on_floor(MASS * GRAVITY / 1500.0, (0.5, 0.0, 0.0))
        motion = simulate([start], 0.08, {"particle_wall.sliding_friction": 0.5}, gravity=GRAVITY)
        _require_rolling_after_sliding(motion, 0.5)

    def test_an_oblique_impact_that_slides_throughout_loses_mu_times_the_normal_impulse(
        self, simulate: Simulate
    ) -> None:
        oblique = Sphere((0.0, 0.0, 0.0051), (0.1, 0.0, -0.02))
        changes = {"particle_wall.sliding_friction": 0.1, "particle_wall.restitution": 1.0}
        motion = simulate([oblique], 0.03, changes)
        lost = 0.1 * 2 * 0.02
        assert 0.1 - motion.velocities[-1, 0, 0] == pytest.approx(lost, rel=2e-3)
        assert motion.spins[-1, 0, 1] == pytest.approx(5 / 2 * lost / RADIUS, rel=0.02)

    def test_rolling_friction_acts_beside_it(
        self, program: SingleContacts, simulate: Simulate
    ) -> None:
        if LINEAR in (model for _, model in contact_law(BEADS, ["linear"]).unfit(program.solver)):
            assert program.solver == "yade"
            return
        # A tenth of the way to the limit: it rocks back with the frequency of its rolling spring.
        load, friction = MASS * GRAVITY, 0.05
        stiffness = 2.25 * 1500.0 * (friction * RADIUS) ** 2
        frequency = math.sqrt(stiffness / _ROLLING_INERTIA)
        speed = 0.1 * frequency * friction * load * RADIUS**2 / stiffness
        changes = {
            "particle_wall.rolling_friction": friction,
            "particle_wall.sliding_friction": 0.5,
            "particle_wall.rolling_damping": 0.0,
        }
        start = _on_floor(load / 1500.0, (speed, 0.0, 0.0), (0.0, speed / RADIUS, 0.0))
        motion = simulate([start], math.pi / frequency, changes, gravity=GRAVITY)
        assert motion.velocities[-1, 0, 0] == pytest.approx(-speed, rel=0.05)


class RollingContract(ContactModelContract):
    """Rolling friction with an elastic-plastic spring; subclasses define model and stiffness."""

    friction: ClassVar[float] = 0.05

    def rolling_stiffness(self, program: SingleContacts, load: float) -> float:
        """Return the stiffness of a particle that rocks on the floor under a load (N), N m."""
        raise NotImplementedError

    @pytest.fixture
    def roll(self, program: SingleContacts, simulate: Simulate) -> Callable[..., float]:
        """Return a function that rolls a particle along the floor and returns its final speed."""
        name, factor = program.floor_rolling_friction

        def roll(speed: float, seconds: float, changes: Mapping[str, float] | None = None) -> float:
            material = {
                name: self.friction / factor,
                "particle_wall.sliding_friction": 0.5,
                **(changes or {}),
            }
            start = _on_floor(_resting(program), (speed, 0.0, 0.0), (0.0, speed / RADIUS, 0.0))
            motion = simulate([start], seconds, material, gravity=GRAVITY)
            return float(motion.velocities[-1, 0, 0])

        return roll

    @property
    def undamped(self) -> Mapping[str, float]:
        """Material values at which the model has no dashpot."""
        return {}

    def test_rolling_decelerates_with_five_sevenths_of_the_rolling_friction(
        self, roll: Callable[..., float]
    ) -> None:
        lost = 0.2 - roll(0.2, 0.15, self.undamped)
        assert lost == pytest.approx(5 / 7 * self.friction * GRAVITY * 0.15, rel=0.03)

    def test_a_particle_rolls_down_a_slope_that_is_steeper_than_its_rolling_friction(
        self, program: SingleContacts, simulate: Simulate
    ) -> None:
        name, factor = program.floor_rolling_friction
        changes = {name: self.friction / factor, "particle_wall.sliding_friction": 0.5}
        steepness = math.degrees(math.atan(self.friction))
        start, options = _on_floor(_resting(program)), {"gravity": GRAVITY, "frames": 2}
        material = {**changes, **self.undamped}
        motion = simulate([start], 0.2, material, slope=3 * steepness, **options)
        turned = math.radians(3 * steepness)
        drive = math.sin(turned) - self.friction * math.cos(turned)
        # Once the rolling spring is at its limit.
        faster = float(np.diff(motion.velocities[1:, 0, 0])[0])
        assert faster == pytest.approx(5 / 7 * GRAVITY * drive * 0.1, rel=0.03)

        motion = simulate([start], 0.2, material, slope=0.3 * steepness, **options)
        free = 5 / 7 * GRAVITY * math.sin(math.radians(0.3 * steepness)) * 0.2**2 / 2
        # It rocks on its rolling spring.
        assert abs(motion.positions[-1, 0, 0] - start.position[0]) < 0.3 * free

    def _rocking(self, program: SingleContacts) -> tuple[float, float]:
        """Return frequency (1/s) and start speed of rocking, a tenth of the way to the limit."""
        load = MASS * GRAVITY
        weights = TYPICAL_LOAD if program.rolling_load == "typical" else 1.0
        stiffness = self.rolling_stiffness(program, weights * load)
        frequency = math.sqrt(stiffness / _ROLLING_INERTIA)
        return frequency, 0.1 * frequency * self.friction * load * RADIUS**2 / stiffness


class EpsdContract(RollingContract):
    """Closed forms of EPSD; the subclass defines the program.

    References
    ----------
    Ai, Chen, Rotter & Ooi (2011), Powder Technology 206:269-282, model C.
    """

    model: ClassVar[ContactModel] = EPSD
    damping: ClassVar[float] = 0.25

    @property
    def undamped(self) -> Mapping[str, float]:
        """Material values at which the model has no dashpot."""
        return _damped(0.0)

    def rolling_stiffness(self, program: SingleContacts, load: float) -> float:  # noqa: ARG002
        """Return the stiffness of a particle that rocks on the floor under a load (N), N m."""
        moduli: EffectiveModuli = particle_moduli(BEADS, "wall")
        spring = rolling_spring(moduli, RADIUS, load, _ROLLING_INERTIA, self.friction, 0.0)
        return spring.stiffness * RADIUS**2

    def test_rocking_has_the_stiffness_and_the_damping_of_epsd(
        self, program: SingleContacts, roll: Callable[..., float]
    ) -> None:
        damping = 0.0 if program.rolling_dashpot == "none" else self.damping
        frequency, speed = self._rocking(program)
        root = math.sqrt(1 - damping**2)
        after = roll(speed, math.pi / (frequency * root), _damped(damping))
        assert after == pytest.approx(-math.exp(-math.pi * damping / root) * speed, rel=0.05)

    def test_the_dashpot_acts_within_or_beyond_the_rolling_limit(
        self, program: SingleContacts, roll: Callable[..., float]
    ) -> None:
        # The known difference of the solvers, which docs/contact_law.md explains.
        after = roll(0.3, 0.15, _damped(self.damping))
        for dashpot in _DASHPOTS:
            expected = _braked_speed(0.3, 0.15, self.friction, self.damping, dashpot)
            if dashpot == program.rolling_dashpot:
                assert after == pytest.approx(expected, rel=0.01)
            elif {dashpot, program.rolling_dashpot} != {"none", "within the limit"}:
                assert after != pytest.approx(expected, rel=0.02)


class Epsd2Contract(RollingContract):
    """Closed forms of EPSD2; the subclass defines the program.

    References
    ----------
    Iwashita & Oda (1998), J. Eng. Mech. 124:285-292.
    """

    model: ClassVar[ContactModel] = EPSD2
    material: ClassVar[Mapping[str, float]] = {
        name: value for name, value in BEADS.items() if "rolling_damping" not in name
    }

    def rolling_stiffness(self, program: SingleContacts, load: float) -> float:
        """Return the stiffness of a particle that rocks on the floor under a load (N), N m."""
        name, factor = program.floor_rolling_friction
        # A solver with one stiffness for all contacts has that of two particles.
        body = "particle" if name.startswith("particle_particle") else "wall"
        radius = factor * RADIUS
        return rolling_stiffness(particle_moduli(BEADS, body), radius, load) * radius**2

    def test_rocking_has_the_tangential_stiffness_and_no_damping(
        self, program: SingleContacts, roll: Callable[..., float]
    ) -> None:
        frequency, speed = self._rocking(program)
        seconds = math.pi / frequency
        expected = _rocking_speed(program, frequency, seconds)
        after = roll(0.5 * speed, seconds, {"particle_wall.restitution": 1.0})
        assert after / (0.5 * speed) == pytest.approx(expected, abs=0.03)


_SPRINGS = ("normal_stiffness", "tangential_stiffness")
_NO_ROLLING = {
    "particle_particle.rolling_friction": 0.0,
    "particle_wall.rolling_friction": 0.0,
}
_ROLLING_INERTIA = 7 / 5 * MASS * RADIUS**2
_DASHPOTS = ("beyond the limit", "within the limit", "none")


def _deepest(damping_ratio: float) -> float:
    """Return the largest overlap of a damped impact over that of an elastic one."""
    root = math.sqrt(1 - damping_ratio**2)
    return math.exp(-damping_ratio / root * math.acos(damping_ratio))


def _on_floor(
    resting: float,
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Sphere:
    return Sphere((-0.03, 0.003, RADIUS - resting), velocity, spin)


def _resting(program: SingleContacts) -> float:
    moduli = particle_moduli(BEADS, "wall")
    return hertz_overlap(MASS * GRAVITY, moduli, program.floor_radius * RADIUS)


def _require_rolling_after_sliding(motion: Motion, speed: float) -> None:
    """Require the speed and the spin of a sphere that has slid until it rolls."""
    assert motion.velocities[-1, 0, 0] == pytest.approx(5 / 7 * speed, rel=0.02)
    assert RADIUS * motion.spins[-1, 0, 1] == pytest.approx(5 / 7 * speed, rel=0.03)


def _rocking_speed(program: SingleContacts, frequency: float, seconds: float) -> float:
    """Speed over its start of an undamped sphere on springs for sliding and for rolling.

    ``frequency`` (1/s) is that of rolling alone. The rolling spring is as stiff as the tangential
    one, so that both give way.
    """
    moduli = particle_moduli(BEADS, "wall")
    contact_radius = math.sqrt(program.floor_radius * RADIUS * _resting(program))
    sliding = tangential_stiffness(moduli) * contact_radius
    rolling = frequency**2 * _ROLLING_INERTIA / RADIUS**2
    # Displacements of the centre and of the surface, with the inertia of translation and of spin.
    stiffness = np.array([[sliding, -sliding], [-sliding, sliding + rolling]])
    squares, modes = np.linalg.eig(np.diag([1 / MASS, 5 / (2 * MASS)]) @ stiffness)
    shares = np.linalg.solve(modes, np.ones(2))
    return float(modes[0] @ (shares * np.cos(np.sqrt(squares) * seconds)))


def _damped(damping: float) -> Mapping[str, float]:
    return {"particle_wall.rolling_damping": damping}


def _braked_speed(
    speed: float, seconds: float, friction: float, damping: float, dashpot: str
) -> float:
    """Speed of a rolling particle whose rolling spring has to be mobilised first."""
    load = MASS * GRAVITY
    spring = rolling_spring(
        particle_moduli(BEADS, "wall"), RADIUS, load, _ROLLING_INERTIA, friction, damping
    )
    stiffness = spring.stiffness * RADIUS**2
    damping = 0.0 if dashpot == "none" else spring.damping * RADIUS**2
    limit = friction * load * RADIUS
    spin, angle, step = speed / RADIUS, 0.0, 1e-6
    for _ in range(round(seconds / step)):
        angle += spin * step
        torque = stiffness * angle + damping * spin
        if stiffness * angle >= limit or (dashpot == "within the limit" and torque > limit):
            torque = limit
        spin -= torque / _ROLLING_INERTIA * step
    return spin * RADIUS


def _momenta(
    motion: Motion, frame: int, masses: NDArray[np.float64], inertias: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Linear and angular momentum of all particles."""
    momenta = masses[:, None] * motion.velocities[frame]
    angular = np.cross(motion.positions[frame], momenta) + inertias[:, None] * motion.spins[frame]
    return momenta.sum(axis=0), angular.sum(axis=0)


def _kinetic_energy(
    motion: Motion, frame: int, masses: NDArray[np.float64], inertias: NDArray[np.float64]
) -> float:
    of_translation = masses * (motion.velocities[frame] ** 2).sum(axis=1)
    of_rotation = inertias * (motion.spins[frame] ** 2).sum(axis=1)
    return float((of_translation + of_rotation).sum() / 2)
