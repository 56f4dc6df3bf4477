"""Scenes: particles, walls, motions, stages and records of a simulated experiment.

A scene is plain data in SI units that knows no solver. Each solver translates it into its own
input, and leaves the same files in the folder of the run (`grainfit.scenes.run_output`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.contact import TYPICAL_LOAD, particle_mass
from grainfit.contact_models.registry import contact_law
from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.time_step import rayleigh_time_step
from grainfit.materials.walls import on_wall
from grainfit.one_line import OneLine
from grainfit.scenes import messages
from grainfit.scenes.conditions import Clear, Condition, Loaded
from grainfit.scenes.glued import Glued
from grainfit.scenes.packing import Column
from grainfit.scenes.records import Force, Frames, RadialForce, Series, Travel
from grainfit.scenes.shapes import Cylinder, Plane, Shape, Vector
from grainfit.scenes.spheres import ClumpSpheres, clump_spheres

#: Raised whenever packing or decks of scenes change the outcome of runs: part of their identity.
SCENES_REVISION = 1
#: The surface of walls whose contacts are those of the material's section ``[particle_wall]``.
WALL = "wall"
#: Gravity that particle weights are counted with in a scene without gravity, m/s^2.
STANDARD_GRAVITY = 9.81
#: Upper limit of the energy of spins, over that about the axis of the largest moment of inertia.
_MORE_THAN_SPINS = 1.01
#: Energy at the beginning that programs may find, over that of the scene: they round it, and time
#: steps change it a little.
_MORE_THAN_AT_FIRST = 1.01
#: Largest speed of a particle that is hit, over the largest speed of what moves.
_THROW = 3.0
#: Largest length of a triangle in a periodic box, over the period.
_SHARE_OF_PERIOD = 0.25
#: Names that decks use themselves.
_TAKEN = {
    "walls": {
        *("gravity", "motion", "series", "walls", "above", "all", "loose", "glued", "surplus"),
        *("beyond", "clumps", "bodies", "remains", "undrained"),
        *("youngs_modulus", "poissons_ratio"),
    },
    "stages": {"end", "restless", "broken", "unstable", "unloaded"},
    "columns": {"time"},
}


@dataclass(frozen=True)
class Box(OneLine):
    """The simulated space; particles that leave it are gone.

    Parameters
    ----------
    low, high : tuple of float
        Corners, m.
    periodic : str
        Axes along which the space repeats, such as ``"y"`` or ``"xy"``.
    """

    low: Vector
    high: Vector
    periodic: str = ""

    def beyond(self, axis: str) -> tuple[float, float]:
        """Return the ends on an axis of what goes on through a period on both sides, m."""
        number = "xyz".index(axis)
        low, high = self.low[number], self.high[number]
        return 2 * low - high, 2 * high - low

    @property
    def longest_element(self) -> float:
        """Largest length of a triangle of a wall, m; infinite without a period.

        An element that is longer than a period makes LIGGGHTS abort.
        """
        axes = (axis for axis, name in enumerate("xyz") if name in self.periodic)
        lengths = (self.high[axis] - self.low[axis] for axis in axes)
        return _SHARE_OF_PERIOD * min(lengths, default=math.inf)


@dataclass(frozen=True)
class Wall(OneLine):
    """A wall: its shape, and the surface that particles touch.

    Parameters
    ----------
    shape : Shape
        Of `grainfit.scenes.shapes`.
    surface : str
        Name of a surface of the scene.
    """

    shape: Shape
    surface: str = WALL


@dataclass(frozen=True)
class Velocity:
    """Motion of a wall or a glued set at constant velocity.

    Parameters
    ----------
    along : {"x", "y", "z"}
        Axis of the motion.
    speed : float
        m/s; negative in the negative direction.
    """

    along: str
    speed: float


@dataclass(frozen=True)
class Load:
    """Motion of a wall or a glued set that presses on the particles, no faster than a speed.

    Parameters
    ----------
    along : {"x", "y", "z"}
        Axis of the motion.
    force : float
        Force on the particles, N; negative when it presses in the negative direction.
    largest_speed : float
        m/s.
    gain : float
        Speed over missing force, m/(N s): one over stiffness of the bed times time constant.
    across : tuple of (str, str)
        Pairs of walls, the lower one first: the force follows the product of their distances, as a
        stress on the area between them does. It is the given one where these walls are put.
    """

    along: str
    force: float
    largest_speed: float
    gain: float
    across: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Rotation:
    """Rotation of a wall at constant angular speed.

    Parameters
    ----------
    along : {"x", "y", "z"}
        Direction of the axis.
    speed : float
        rad/s, not zero; by the right-hand rule, so that about the y axis z turns towards x.
    through : tuple of float
        A point on the axis, m.
    """

    along: str
    speed: float
    through: Vector = (0.0, 0.0, 0.0)

    @property
    def axis(self) -> tuple[str, Vector]:
        """Direction of the axis, and a point on it."""
        return self.along, self.through


Motion = Velocity | Load | Rotation


@dataclass(frozen=True)
class Stage(OneLine):
    """A part of the procedure: what changes at its beginning, and when it ends.

    Parameters
    ----------
    name : str
        An identifier.
    until : Condition
        End of the stage, see `grainfit.scenes.conditions`.
    remark : str
        What happens in it, for a comment in a deck.
    take_away : tuple of str
        Walls that are removed at its beginning.
    put : mapping of str to Wall
        Walls that are added at its beginning.
    strike_off : float, optional
        Particles whose centre is above this height are removed at its beginning, m.
    motions : mapping of str to Motion or tuple of Motion
        Walls and glued sets that move in this stage, and only in it. Several motions of a glued
        set, along different axes, act together; a wall has one.
    series : Series, optional
        Quantities recorded in it.
    frames : Frames, optional
        Snapshots of the particles during it.
    snapshot : str
        Name of the snapshot of the particles at its end; empty for none.
    is_closed : bool
        No particle may get lost in it: walls hold them all.
    sliding_friction : float, optional
        Sliding friction between particles in this stage, and only in it; that of the material by
        default.
    """

    name: str
    until: Condition
    remark: str = ""
    take_away: tuple[str, ...] = ()
    put: Mapping[str, Wall] = field(default_factory=dict)
    strike_off: float | None = None
    motions: Mapping[str, Motion | tuple[Motion, ...]] = field(default_factory=dict)
    series: Series | None = None
    frames: Frames | None = None
    snapshot: str = ""
    is_closed: bool = False
    sliding_friction: float | None = None

    def motions_of(self, name: str) -> tuple[Motion, ...]:
        """Return the motions of a wall or a glued set in this stage; none when it stands still."""
        found = self.motions.get(name, ())
        return found if isinstance(found, tuple) else (found,)

    def all_motions(self) -> Iterator[tuple[str, Motion]]:
        """Iterate over every motion of the stage, with the name of what moves."""
        for name in self.motions:
            yield from ((name, motion) for motion in self.motions_of(name))


@dataclass(frozen=True)
class Scene:
    """A simulated experiment.

    Parameters
    ----------
    title : str
        A short text, for the first line of a deck.
    material : mapping of str to float
        All material parameters by dotted name; those with a default may be missing.
    sizes : ParticleSizes
        Particle size distribution, and the shape of loose particles. Glued ones are spheres.
    particles : Column
        Loose particles at the beginning.
    box : Box
        The simulated space.
    walls : mapping of str to Wall
        Walls at the beginning, by name (an identifier).
    stages : tuple of Stage
        In order.
    gravity : float
        m/s^2, downwards; 0 is none.
    time_step : float
        s.
    quiet_speed : float
        Particles are at rest when their kinetic energy is less than if every one had this speed.
    check_interval : float
        Simulated time between two looks at the end of a stage, s.
    surfaces : mapping of str to mapping
        Material parameters of surfaces other than ``"wall"`` that differ from it, by name of the
        surface and of the parameter.
    typical_load : float
        Typical normal force of a contact in particle weights: LAMMPS and YADE keep rolling
        stiffness and damping constant at its value there. Weights are those on Earth in a scene
        without gravity.
    glued : mapping of str to Glued
        Rigid bodies of glued particles, by name (an identifier, and no wall's).
    contact_models : tuple of str
        Contact models that replace the usual ones of their kind.
    film_interval : float, optional
        Simulated time between two frames of all particles through all stages, s, which change
        nothing of the run; none by default. See `grainfit.scenes.film`.
    """

    title: str
    material: Mapping[str, float]
    sizes: ParticleSizes
    particles: Column
    box: Box
    walls: Mapping[str, Wall]
    stages: tuple[Stage, ...]
    gravity: float
    time_step: float
    quiet_speed: float
    check_interval: float
    surfaces: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    typical_load: float = TYPICAL_LOAD
    glued: Mapping[str, Glued] = field(default_factory=dict)
    contact_models: tuple[str, ...] = ()
    film_interval: float | None = None

    def __post_init__(self) -> None:
        """Raise `InputError` if a deck would misread a name, or what a stage names is not there."""
        InputError.raise_for(
            [
                *_name_faults(self),
                *_wall_faults(self),
                *_motion_faults(self),
                *_rotation_faults(self),
                *_area_faults(self),
            ]
        )

    def __repr__(self) -> str:
        stages = ", ".join(stage.name for stage in self.stages)
        return f"<Scene {self.title!r}: {self.number_of_particles} particles, stages {stages}>"

    @property
    def law(self) -> ContactLaw:
        """Contact models that act between particles or on any surface."""
        own = {
            on_wall(name, surface): value
            for surface, values in self.surfaces.items()
            for name, value in values.items()
        }
        return contact_law({**self.material, **own}, self.contact_models)

    def material_on(self, surface: str) -> dict[str, float]:
        """Return the material parameters for contacts with a surface."""
        return {**self.law.defaults, **self.material, **self.surfaces.get(surface, {})}

    @cached_property
    def clumps(self) -> ClumpSpheres | None:
        """Spheres of the loose particles that are clumps; None if they are spheres."""
        return clump_spheres(self.sizes)

    def all_walls(self) -> dict[str, Wall]:
        """Return the walls of all stages by name."""
        later = [wall for stage in self.stages for wall in stage.put.items()]
        return {**self.walls, **dict(later)}

    def motions_of(self, name: str) -> Iterator[Motion]:
        """Iterate over the motions of a wall or a glued set in all stages."""
        for stage in self.stages:
            yield from stage.motions_of(name)

    def first_distance(self, low: str, high: str) -> float:
        """Return the distance between two parallel planes where they are put, m."""
        places = (self.all_walls()[name].shape for name in (low, high))
        first, second = (place.at for place in places if isinstance(place, Plane))
        return second - first

    def steps(self, time: float) -> int:
        """Return the number of time steps of a simulated time; at least one."""
        return max(1, round(time / self.time_step))

    @property
    def weight_gravity(self) -> float:
        """Gravity that particle weights are counted with, m/s^2: Earth's where there is none."""
        return self.gravity or STANDARD_GRAVITY

    @property
    def number_of_particles(self) -> int:
        """Number of particles at the beginning, glued ones included."""
        glued = sum(len(body.positions) for body in self.glued.values())
        return len(self.particles.positions) + glued

    @property
    def mass(self) -> float:
        """Mass of all loose particles at the beginning, kg."""
        shares = zip(self.sizes.number_fractions, self.sizes.diameters, strict=True)
        mean = sum(share * particle_mass(self.material, d / 2) for share, d in shares)
        return len(self.particles.positions) * mean

    @property
    def initial_energy(self) -> float:
        """Kinetic energy of the loose particles at the beginning, J; of spins, an upper limit."""
        velocities, spins = self.particles.velocities, self.particles.spins
        masses = [particle_mass(self.material, d / 2) for d in self.sizes.diameters]
        own = np.array(masses)[self.particles.size_indices]
        energy = 0.0 if velocities is None else (own * (velocities**2).sum(axis=1)).sum() / 2
        if spins is not None and self.clumps is not None:
            diameters = np.array(self.sizes.diameters)[self.particles.size_indices]
            largest = max(self.clumps.clump.moments) * own * diameters**2
            energy += _MORE_THAN_SPINS * (largest * (spins**2).sum(axis=1)).sum() / 2
        return float(energy)

    @property
    def energy_at_rest(self) -> float:
        """Kinetic energy below which the loose particles are at rest, J."""
        return self.mass * self.quiet_speed**2 / 2

    @property
    def energy_limit(self) -> float:
        """Kinetic energy that is out of reach, J.

        It is the sum of these energies:

        - All loose particles fall from top to bottom, or a wall throws them.
        - They have a little more than their energy at the beginning.
        - The largest load on each wall and glued set acts across the box.
        - A glued set throws all particles.
        """
        fall = self.mass * self.gravity * (self.particles.height - self.box.low[2])
        work = sum(self._largest_work(name) for name in (*self.all_walls(), *self.glued))
        corners = np.array([*product(*zip(self.box.low, self.box.high, strict=True))])
        by_walls = self._throw(dict.fromkeys(self.all_walls(), corners))
        by_sets = self._throw({name: body.positions for name, body in self.glued.items()})
        first = _MORE_THAN_AT_FIRST * self.initial_energy
        return first + work + by_sets + max(fall, by_walls)

    def _throw(self, places: Mapping[str, NDArray[np.float64]]) -> float:
        """Return the kinetic energy of all particles thrown by what moves, J.

        Places, m, are those of each wall or glued set that may be the fastest.
        """
        speeds = [
            _fastest(motion, there)
            for name, there in places.items()
            for motion in self.motions_of(name)
        ]
        return self.mass * (_THROW * max(speeds, default=0.0)) ** 2 / 2

    def _largest_work(self, name: str) -> float:
        """Work of the largest load on a wall or glued set across the box, J; zero without one."""
        loads = [motion for motion in self.motions_of(name) if isinstance(motion, Load)]
        lengths = ("xyz".index(load.along) for load in loads)
        reaches = (self.box.high[axis] - self.box.low[axis] for axis in lengths)
        works = (abs(load.force) * reach for load, reach in zip(loads, reaches, strict=True))
        return max(works, default=0.0)

    def concepts(self) -> set[str]:
        """Return the names of the concepts that a solver must have to translate the scene."""
        walls = self.all_walls().values()
        found = {type(wall.shape).__name__.lower() for wall in walls}
        found |= {type(m).__name__.lower() for s in self.stages for _, m in s.all_motions()}
        if self.clumps is not None:
            found.add("clumps")
        if self.glued:
            found.add("glued")
        if any(len({type(m) for m in self.motions_of(wall)}) > 1 for wall in self.all_walls()):
            found.add("velocity and load")
        if any(isinstance(w.shape, Cylinder) and w.shape.axis != "z" for w in walls):
            found.add("lying cylinder")
        if any(stage.frames for stage in self.stages):
            found.add("frames")
        motions = [motion for stage in self.stages for _, motion in stage.all_motions()]
        if any(isinstance(motion, Load) and motion.across for motion in motions):
            found.add("load on an area")
        if any(stage.sliding_friction is not None for stage in self.stages):
            found.add("friction of a stage")
        if self.box.periodic:
            found.add("periodic " + self.box.periodic)
        return found


def _fastest(motion: Motion, places: NDArray[np.float64]) -> float:
    """Return the speed of the fastest place that moves so, m/s; 0 under a load."""
    if isinstance(motion, Velocity):
        return abs(motion.speed)
    if isinstance(motion, Rotation):
        arms = np.delete(places - motion.through, "xyz".index(motion.along), axis=1)
        return abs(motion.speed) * float(np.linalg.norm(arms, axis=1).max())
    return 0.0


def _name_faults(scene: Scene) -> Iterator[Fault]:
    """Names become variables and files of decks: identifiers, each with one meaning."""
    stages = scene.stages
    kinds = {
        "walls": [*scene.walls, *(name for stage in stages for name in stage.put), *scene.glued],
        "stages": [stage.name for stage in stages],
        "snapshots": [
            *(stage.snapshot for stage in stages if stage.snapshot),
            *(stage.frames.name for stage in stages if stage.frames),
        ],
    }
    columns = [name for stage in stages if stage.series for name in stage.series.columns]
    for key, names in {**kinds, "columns": columns, "surfaces": [*scene.surfaces]}.items():
        for name in dict.fromkeys(names):
            if not (name.isidentifier() and name.isascii()):
                yield messages.NOT_A_WORD.fault(key, name=name)
            if name in _TAKEN.get(key, ()):
                yield messages.TAKEN_NAME.fault(key, name=name)
    for key, names in kinds.items():
        for name in dict.fromkeys(names):
            if names.count(name) > 1:
                yield messages.NAME_TWICE.fault(key, name=name)


def _wall_faults(scene: Scene) -> Iterator[Fault]:
    """Everything that a stage does with a wall needs the wall."""
    there = dict(scene.walls)
    for stage in scene.stages:
        key = f"stage {stage.name}"
        for name in stage.take_away:
            if there.pop(name, None) is None:
                yield _no_wall(key, "takes away", name, there)
        there |= stage.put
        bodies = {**there, **scene.glued}
        for name in stage.motions:
            if name not in bodies:
                yield _no_wall(key, "moves", name, bodies)
        yield from _record_faults(scene, stage, there)
        until = stage.until
        if isinstance(until, Clear) and not _is_cylinder(there.get(until.wall)):
            yield messages.NOT_CLEARED.fault(key, wall=until.wall)
        if isinstance(until, Loaded) and load_on(stage, until.wall) is None:
            yield messages.NOT_LOADED.fault(key, wall=until.wall)


def _rotation_faults(scene: Scene) -> Iterator[Fault]:
    """A wall or glued set that turns does so about one axis, and does nothing else."""
    for name in (*scene.all_walls(), *scene.glued):
        motions = [*scene.motions_of(name)]
        rotations = [motion for motion in motions if isinstance(motion, Rotation)]
        turns = {rotation.axis for rotation in rotations}
        others = [motion for motion in motions if not isinstance(motion, Rotation)]
        if any(rotation.speed == 0 for rotation in rotations):
            yield messages.NO_TURN.fault(name)
        if turns and (len(turns) > 1 or others):
            yield messages.TURNS_AND_MOVES.fault(name)


def _record_faults(scene: Scene, stage: Stage, there: Mapping[str, Wall]) -> Iterator[Fault]:
    """A wall or glued set that is recorded must be there, and the record must make sense of it."""
    key, bodies = f"stage {stage.name}", {**there, **scene.glued}
    for quantity in stage.series.columns.values() if stage.series else ():
        if isinstance(quantity, Force | Travel) and quantity.wall not in bodies:
            yield _no_wall(key, "records", quantity.wall, bodies)
        if isinstance(quantity, RadialForce) and quantity.wall not in there:
            yield _no_wall(key, "records", quantity.wall, there)
        if isinstance(quantity, Travel) and quantity.wall in scene.glued and not quantity.along:
            yield messages.TRAVEL_WITHOUT_AXIS.fault(key, name=quantity.wall)


def _motion_faults(scene: Scene) -> Iterator[Fault]:
    """A wall has one motion at a time, a glued set one along each axis."""
    for stage in scene.stages:
        key = f"stage {stage.name}"
        for name in stage.motions:
            motions = stage.motions_of(name)
            if name not in scene.glued and len(motions) != 1:
                yield messages.SEVERAL_MOTIONS.fault(key, name=name, count=len(motions))
            axes = [motion.along for motion in motions] if len(motions) > 1 else []
            if len(set(axes)) < len(axes):
                yield messages.MOVED_TWICE.fault(key, name=name)
            if sum(isinstance(motion, Load) for motion in motions) > 1:
                yield messages.TWO_LOADS.fault(key, name=name)


def _area_faults(scene: Scene) -> Iterator[Fault]:
    """A load on an area needs parallel planes, the lower one first, on both sides of it."""
    walls = scene.all_walls()
    for stage in scene.stages:
        for name, motion in stage.all_motions():
            pairs = motion.across if isinstance(motion, Load) else ()
            for pair in pairs:
                planes = [walls[one].shape for one in pair if one in walls]
                ends = [(one.axis, one.at) for one in planes if isinstance(one, Plane)]
                if len(ends) < 2 or ends[0][0] != ends[1][0] or ends[0][1] >= ends[1][1]:
                    low, high = pair
                    yield messages.NO_AREA.fault(
                        f"stage {stage.name}", name=name, low=low, high=high
                    )


def load_on(stage: Stage, name: str) -> Load | None:
    """Return the load that moves a wall or a glued set in a stage; None without one."""
    return next((m for m in stage.motions_of(name) if isinstance(m, Load)), None)


def _no_wall(stage: str, does: str, name: str, there: Mapping[str, object]) -> Fault:
    known = ", ".join(there) or "none"
    return messages.NO_WALL.fault(stage, does=does, name=name, known=known)


def _is_cylinder(wall: Wall | None) -> bool:
    return wall is not None and isinstance(wall.shape, Cylinder) and wall.shape.axis == "z"


def time_step(sizes: ParticleSizes, material: Mapping[str, float], fraction: float) -> float:
    """Return a fraction of the Rayleigh time step, s."""
    return fraction * rayleigh_time_step(
        sizes.rayleigh_radius,
        material["particle.density"],
        material["particle.youngs_modulus"],
        material["particle.poissons_ratio"],
    )


def natural_time(sizes: ParticleSizes, gravity: float) -> float:
    """Return sqrt(d/g) with the Sauter diameter d, s."""
    return math.sqrt(sizes.sauter_diameter / gravity)


def natural_speed(sizes: ParticleSizes, gravity: float) -> float:
    """Return sqrt(g d) with the Sauter diameter d, m/s."""
    return math.sqrt(sizes.sauter_diameter * gravity)
