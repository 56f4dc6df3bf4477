"""Scenes as Python scripts for YADE: walls are planes, boxes and polyhedra."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.yade import (
    YadeArgument,
    yade_body,
    yade_law,
    yade_on_wall,
    yade_physics,
)
from grainfit.errors import InputError
from grainfit.scenes.conditions import AtRest, Clear, Drained, Elapsed, Loaded
from grainfit.scenes.film import FILM
from grainfit.scenes.records import Force, MassAbove, RadialForce, Recorded, Travel
from grainfit.scenes.run_output import STAGES_HEADER
from grainfit.scenes.scene import Load, Motion, Rotation, Stage, Velocity, Wall, load_on
from grainfit.scenes.shapes import Block, Cone, Cylinder, Disc, Plane, Prism, Vector
from grainfit.scenes.spheres import ClumpSpheres
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.rigid_bodies import rigid_bodies
from grainfit.solvers.dem.script_syntax import heading
from grainfit.solvers.dem.sphere_types import SphereTypes
from grainfit.solvers.dem.templates import fill
from grainfit.solvers.dem.yade.clump_shares import clump_shares

_EDGES = (
    "YADE gives a particle near an edge between two triangles of one plane two contacts, one of "
    "them tilted; use {instead}"
)
#: Concepts that YADE does not have, with the reason and what to use instead.
MISSING: Mapping[str, str] = {
    "annulus": _EDGES.format(instead='a slot, a cone, or solver = "lammps" or "liggghts"'),
    "mesh": _EDGES.format(instead='solver = "liggghts"'),
}
#: Thickness of the panels of tubes, and of discs, in Sauter diameters; width of panels.
_THICKNESS, _PANEL = 0.5, 0.95
_FEWEST_PANELS, _DISC_CORNERS = 24, 24
#: Cell over box, along axes that are not periodic.
_CELL = 4.0
#: Half the length of a block along a periodic axis, in periods: particles that circle around keep
#: their unwrapped places.
_PERIODS = 1000.0
#: Time steps between two looks for new contacts with walls.
_ROLLING_EVERY = 5
#: Distance that particles move between two searches for neighbours, over the smallest radius.
_VERLET = 0.3
#: Largest share of a period that the bounds of a particle may take.
_SHARE_OF_PERIOD = 0.49


class YadeSceneDeck(SceneDeck):
    """A scene as a script for YADE; see `SceneDeck`."""

    file_name: ClassVar[str] = "in.yade.py"

    def write_particles(self) -> None:
        """Write places, radii and velocities of the particles."""
        if self.scene.glued:
            self._write_glued()
        if self.scene.clumps is not None:
            self._write_clumps(self.scene.clumps)
            return
        particles = self.scene.particles
        radii = np.array(self.scene.sizes.diameters)[particles.size_indices] / 2
        velocities = particles.velocities
        if velocities is None:
            velocities = np.zeros_like(particles.positions)
        table = np.column_stack((particles.positions, radii, velocities))
        np.savetxt(self.folder / "particles.txt", table, "%.12g", header="x y z radius vx vy vz")

    def _write_glued(self) -> None:
        """Write places and radii of the glued particles, and the number of their set, from 0."""
        bodies, radii = self.scene.glued.values(), np.array(self.scene.sizes.diameters) / 2
        positions = np.vstack([body.positions for body in bodies])
        sizes = np.concatenate([body.size_indices for body in bodies])
        sets = np.repeat(np.arange(len(bodies)), [len(body.size_indices) for body in bodies])
        table = np.column_stack((positions, radii[sizes], sets))
        np.savetxt(self.folder / "glued.txt", table, "%.12g", header="x y z radius set")

    def _write_clumps(self, spheres: ClumpSpheres) -> None:
        """Write the spheres of clumps, and mass, inertia, velocity and spin of each clump."""
        table = np.column_stack(self.scene.particles.outlines(spheres))
        np.savetxt(self.folder / "particles.txt", table, "%.12g", header="x y z radius")
        found = rigid_bodies(self.scene)
        bodies = (found.masses, found.upper_inertia, found.velocities, found.spins)
        header = "mass Ixx Iyy Izz Ixy Ixz Iyz vx vy vz wx wy wz"
        np.savetxt(self.folder / "clumps.txt", np.column_stack(bodies), "%.15g", header=header)

    def text(self) -> str:
        """Return the script; write the STL files that it reads.

        Raises
        ------
        InputError
            A period is too short, or a radial force is recorded of another wall than a tube.
        """
        return fill("yade", self.values(), "scene.j2")

    def values(self) -> Mapping[str, Any]:
        """Return the values of the template."""
        scene = self.scene
        contact, body = self._between_particles(), yade_body(self.law)
        first_walls = [line for item in scene.walls.items() for line in self._put(*item)]
        stages = [line for stage in scene.stages for line in self.stage(stage)]
        return {
            "title": scene.title,
            "clumps": None if scene.clumps is None else clump_shares(scene.clumps.clump),
            "file_name": self.file_name,
            "glued": list(scene.glued),
            "prisms": "prism" in scene.concepts(),
            "areas": "load on an area" in scene.concepts(),
            "drains": any(isinstance(stage.until, Drained) for stage in scene.stages),
            "frictions": "friction of a stage" in scene.concepts(),
            "time_step": scene.time_step,
            "gravity": scene.gravity,
            "low": tuple(scene.box.low),
            "high": tuple(scene.box.high),
            "periodic": [axis for axis, name in enumerate("xyz") if self._repeats(name)],
            "periods": self._periods(),
            "energy_at_rest": scene.energy_at_rest,
            "energy_limit": scene.energy_limit,
            "look_every": scene.steps(scene.check_interval),
            "parameters": sorted(scene.material_on("wall").items()),
            "surfaces": [(name, dict(own)) for name, own in sorted(scene.surfaces.items())],
            "quoted": repr,
            "functors": body.functors,
            "particle": body.particle(contact),
            "wall_materials": list(self._wall_materials(contact)),
            "physics": yade_physics(self.law, contact),
            "law": ", ".join(f"{n}={v}" for n, v, _ in yade_law(self.law, contact)),
            "rolling": list(self._rolling()),
            "rolling_every": _ROLLING_EVERY,
            "after_step": list(self._after_step()),
            "film_every": self._film_steps,
            "film_file": FILM,
            "verlet_distance": self._verlet_distance(),
            "stages_header": STAGES_HEADER,
            "first_walls": first_walls,
            "stages": stages,
            "every": None,
            "saved": None,
        }

    # --- contacts ------------------------------------------------------------------------------

    def _between_particles(self) -> Contact:
        scene = self.scene
        material = scene.material_on("wall")
        return self._sphere.between(material, 1, 1, scene.weight_gravity, scene.typical_load)

    @property
    def _sphere(self) -> SphereTypes:
        """The sphere for which YADE computes rolling stiffness."""
        return SphereTypes.mean_of(self.scene.sizes)

    def _rolling(self) -> Iterator[tuple[str, list[YadeArgument]]]:
        """Iterate over surfaces and what contacts with them get that no functor gives them."""
        scene, gravity = self.scene, self.scene.weight_gravity
        for surface in self._surfaces():
            material = scene.material_on(surface)
            contact = self._sphere.on_wall(material, 1, gravity, scene.typical_load)
            attributes = yade_on_wall(self.law, contact)
            if attributes:
                yield surface, attributes

    def _after_step(self) -> Iterator[str]:
        """Iterate over the functions that every stage calls after a step."""
        if any(self._rolling()):
            yield "set_rolling_friction_sometimes"
        if self._film_steps:
            yield "film"

    @property
    def _film_steps(self) -> int:
        """Time steps between two frames of the whole run; 0 without any."""
        interval = self.scene.film_interval
        return 0 if interval is None else self.scene.steps(interval)

    def _wall_materials(self, particles: Contact) -> Iterator[tuple[str, str]]:
        """Iterate over surfaces and the values of their material."""
        scene, body = self.scene, yade_body(self.law)
        for surface in self._surfaces():
            material = scene.material_on(surface)
            contact = self._sphere.on_wall(material, 1, scene.weight_gravity, scene.typical_load)
            yield surface, ", ".join(a.value for a in body.wall(contact, particles))

    def _surfaces(self) -> list[str]:
        return list(dict.fromkeys(wall.surface for wall in self.scene.all_walls().values()))

    # --- box -----------------------------------------------------------------------------------

    def _repeats(self, axis: str) -> bool:
        return axis in self.scene.box.periodic

    def _lengths(self) -> list[float]:
        box = self.scene.box
        return [high - low for low, high in zip(box.low, box.high, strict=True)]

    def _periods(self) -> tuple[float, ...]:
        """Lengths of YADE's cell, m."""
        lengths = self._lengths()
        return tuple(
            length if self._repeats(axis) else _CELL * length
            for axis, length in zip("xyz", lengths, strict=True)
        )

    def _verlet_distance(self) -> float:
        """Return how far particles may move between two searches for neighbours, m.

        Raises
        ------
        InputError
            A period is so short that YADE would overlook contacts across it.
        """
        diameters = self.scene.sizes.diameters
        distance = _VERLET * self.scene.sizes.smallest_radius
        if not self.scene.box.periodic:
            return distance
        lengths = zip("xyz", self._lengths(), strict=True)
        shortest = min(length for axis, length in lengths if self._repeats(axis))
        room = (_SHARE_OF_PERIOD * shortest - max(diameters)) / 2
        if room < _SHARE_OF_PERIOD * distance / _VERLET / 10:
            least = 2.5 * max(diameters)
            raise InputError(messages.PERIOD_TOO_SHORT.fault("box", length=shortest, least=least))
        return min(distance, room)

    # --- walls ---------------------------------------------------------------------------------

    def _put(self, name: str, wall: Wall) -> Iterator[str]:
        shape = wall.shape
        if isinstance(shape, Plane) and not (self.scene.box.periodic or self._turns(name)):
            axis = "xyz".index(shape.axis)
            yield f"plane({name!r}, {wall.surface!r}, {axis}, {shape.at!r}, {shape.upwards})"
        elif isinstance(shape, Plane):
            yield self._block(name, wall, *self._behind(shape, 1.0 if self._turns(name) else 0.0))
        elif isinstance(shape, Block):
            yield self._block(name, wall, shape.low, shape.high)
        elif isinstance(shape, Prism):
            yield self._block(name, wall, shape.low, shape.high, shape.shift)
        elif isinstance(shape, Cylinder):
            bottom, top = shape.bottom, shape.top
            if self._repeats(shape.axis):
                top = _PERIODS * self._lengths()["xyz".index(shape.axis)]
                bottom = -top
            cone = Cone(shape.radius, shape.radius, bottom, top)
            yield self._tube(name, wall, cone, shape.axis)
        elif isinstance(shape, Cone):
            yield self._tube(name, wall, shape)
        else:
            assert isinstance(shape, Disc), "shapes that YADE does not have are refused before"
            sizes = f"{shape.radius!r}, {shape.z!r}, {_DISC_CORNERS}, {self._thickness}"
            yield f"disc({name!r}, {wall.surface!r}, {sizes})"

    @property
    def _thickness(self) -> float:
        return _THICKNESS * self.scene.sizes.sauter_diameter

    def _turns(self, name: str) -> bool:
        return any(isinstance(motion, Rotation) for motion in self.scene.motions_of(name))

    def _tube(self, name: str, wall: Wall, shape: Cone, axis: str = "z") -> str:
        width = _PANEL * self.scene.sizes.sauter_diameter
        widest = max(shape.lower_radius, shape.upper_radius)
        panels = max(_FEWEST_PANELS, math.ceil(2 * math.pi * widest / width))
        ends = f"{shape.lower_radius!r}, {shape.upper_radius!r}, {shape.bottom!r}, {shape.top!r}"
        number = "xyz".index(axis)
        return f"tube({name!r}, {wall.surface!r}, {number}, {ends}, {panels}, {self._thickness})"

    def _behind(self, plane: Plane, margin: float) -> tuple[Vector, Vector]:
        """Return the corners of a block with a plane as its face.

        YADE's periodic cells need it, and planes that turn. It is as large as the box, with a
        margin in its lengths.
        """
        axis, box = "xyz".index(plane.axis), self.scene.box
        beyond = [margin * length for length in self._lengths()]
        low = [value - more for value, more in zip(box.low, beyond, strict=True)]
        high = [value + more for value, more in zip(box.high, beyond, strict=True)]
        depth = self._lengths()[axis]
        start = plane.at - depth if plane.upwards else plane.at
        low[axis], high[axis] = start, start + depth
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    def _block(
        self, name: str, wall: Wall, low: Vector, high: Vector, shift: float | None = None
    ) -> str:
        """Return the line that puts a block or a prism, infinite along periodic axes."""
        ends = list(zip(low, high, strict=True))
        for number, (axis, length) in enumerate(zip("xyz", self._lengths(), strict=True)):
            if self._repeats(axis):
                ends[number] = (-_PERIODS * length, _PERIODS * length)
        lower, upper = zip(*((float(a), float(b)) for a, b in ends), strict=True)
        corners = f"{name!r}, {wall.surface!r}, {lower}, {upper}"
        return f"block({corners})" if shift is None else f"prism({corners}, {shift!r})"

    # --- stages --------------------------------------------------------------------------------

    def stage(self, stage: Stage) -> Iterator[str]:
        """Iterate over the lines of a stage."""
        yield heading(f"{stage.name}: {stage.remark}" if stage.remark else stage.name)
        yield ""
        if stage.take_away or stage.put or stage.strike_off is not None:
            yield "velocities = velocities_now()"
            yield from self._changes(stage)
            yield "go_on_with(velocities)"
        friction = stage.sliding_friction
        if friction is not None:
            yield f"set_friction({friction!r})"
        yield f"stage = Stage({stage.name!r}, is_closed={stage.is_closed})"
        for wall in stage.motions:
            for motion in stage.motions_of(wall):
                yield self._motion(wall, motion)
        yield from self._records(stage)
        yield self._until(stage)
        if friction is not None:
            yield "set_friction()"
        if stage.snapshot:
            yield f"snapshot({stage.snapshot!r})"

    def _changes(self, stage: Stage) -> Iterator[str]:
        """Iterate over what is taken away and put at the beginning of a stage."""
        if stage.strike_off is not None:
            yield f"strike_off({stage.strike_off!r})"
        yield from (f"take_away({name!r})" for name in stage.take_away)
        for item in stage.put.items():
            yield from self._put(*item)

    def _records(self, stage: Stage) -> Iterator[str]:
        """Iterate over the lines that have frames and series of a stage written."""
        if stage.frames is not None:
            every = self.scene.steps(stage.frames.every)
            yield f"stage.film({stage.frames.name!r}, {every})"
        if stage.series is not None:
            yield f"stage.record({self.scene.steps(stage.series.every)}, {{"
            for name, quantity in stage.series.columns.items():
                yield f"    {name!r}: {self._quantity(quantity)},"
            yield "})"

    def _movable(self, name: str) -> str:
        """Return the object of a wall or a glued set."""
        return f"{'glued' if name in self.scene.glued else 'walls'}[{name!r}]"

    def _motion(self, name: str, motion: Motion) -> str:
        movable, axis = self._movable(name), "xyz".index(motion.along)
        if isinstance(motion, Velocity):
            return f"{movable}.move({axis}, {motion.speed!r})"
        if isinstance(motion, Load):
            limits = f"largest_speed={motion.largest_speed!r}, gain={motion.gain!r}"
            return f"stage.load({movable}, {axis}, {self._force(motion)}, {limits})"
        if self._is_about_itself(name, motion):
            return f"{movable}.turn_in_place({axis}, {motion.speed!r})"
        return f"stage.turn({movable}, {axis}, {motion.speed!r}, {motion.through})"

    def _force(self, load: Load) -> str:
        """Return the force of a load, or a function that returns that on an area."""
        if not load.across:
            return repr(load.force)
        walls = self.scene.all_walls()
        pairs = [
            (low, high, "xyz".index(walls[low].shape.axis), self.scene.first_distance(low, high))  # type: ignore[union-attr]
            for low, high in load.across
        ]
        return f"lambda: {load.force!r} * stretch({', '.join(map(repr, pairs))})"

    def _is_about_itself(self, name: str, rotation: Rotation) -> bool:
        """Return whether it is the rotation of a tube about its axis."""
        wall = self.scene.all_walls().get(name)
        if wall is None or not isinstance(wall.shape, Cylinder):
            return False
        others = (
            place
            for axis, place in zip("xyz", rotation.through, strict=True)
            if axis != rotation.along
        )
        return wall.shape.axis == rotation.along and not any(others)

    def _quantity(self, quantity: Recorded) -> str:
        """Return a function that returns a recorded quantity."""
        if isinstance(quantity, MassAbove):
            return f"lambda: mass_above({quantity.height!r})"
        if isinstance(quantity, Force):
            axis = "xyz".index(quantity.along)
            return f"lambda: {self._movable(quantity.wall)}.force({axis})"
        if isinstance(quantity, Travel):
            movable = self._movable(quantity.wall)
            if self._turns(quantity.wall):
                return f"{movable}.angle"
            motions = list(self.scene.motions_of(quantity.wall))
            along = quantity.along or (motions[0].along if motions else "z")
            return f"lambda: {movable}.travel({'xyz'.index(along)})"
        if isinstance(quantity, RadialForce):
            self._require_tube(quantity.wall)
            return f"walls[{quantity.wall!r}].radial_force"
        return "kinetic_energy"

    def _require_tube(self, wall: str) -> None:
        shape = self.scene.all_walls()[wall].shape
        if not (isinstance(shape, Cylinder) and shape.axis == "z"):
            raise InputError(messages.NO_UPRIGHT_TUBE.fault(wall))

    def _until(self, stage: Stage) -> str:
        """Return the line that runs a stage to its end."""
        scene, until = self.scene, stage.until
        if isinstance(until, Elapsed):
            return f"stage.until_elapsed({scene.steps(until.time)})"
        limit = scene.steps(until.limit)
        if isinstance(until, AtRest | Drained):
            # Particles that have not begun to fall are not at rest.
            shortest = scene.check_interval if stage is scene.stages[0] else 0.0
            first = max(until.at_least, shortest)
            looks = f"first={scene.steps(first) if first > 0 else 0}, limit={limit}"
            if isinstance(until, AtRest):
                return f"stage.until_at_rest({looks})"
            left = until.left(scene.mass)
            return f"stage.until_drained({until.height!r}, {left!r}, {looks})"
        if isinstance(until, Clear):
            bottom = scene.all_walls()[until.wall].shape.bottom  # type: ignore[union-attr]
            clump = scene.clumps
            share = 0.5 if clump is None else float(clump.clump.radii.max())
            radius = share * max(scene.sizes.diameters)
            return f"stage.until_clear({until.wall!r}, {bottom!r}, {radius!r}, limit={limit})"
        assert isinstance(until, Loaded)
        load = load_on(stage, until.wall)
        assert load is not None
        axis = "xyz".index(load.along)
        wanted = f"{axis}, {self._force(load)}, within={until.within!r}, limit={limit}"
        return f"stage.until_loaded({self._movable(until.wall)}, {wanted})"
