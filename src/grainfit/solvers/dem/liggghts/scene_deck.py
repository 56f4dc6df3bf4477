"""Scenes as decks for LIGGGHTS: walls are triangle meshes, one type for each surface."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import ClassVar

from grainfit.contact_models.contact import Contact
from grainfit.contact_models.liggghts import (
    LiggghtsProperties,
    liggghts_model,
    liggghts_properties,
)
from grainfit.errors import InputError
from grainfit.scenes.conditions import Condition, Drained
from grainfit.scenes.run_output import snapshot_file
from grainfit.scenes.scene import WALL, Load, Motion, Rotation, Scene, Stage, Wall
from grainfit.scenes.shapes import Cylinder
from grainfit.scenes.triangles import triangles_of, write_stl
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.liggghts.multispheres import INSERTION, SHARE, SURPLUS, Multispheres
from grainfit.solvers.dem.script import PARTICLES, UNDRAINED, ScriptDeck
from grainfit.solvers.dem.script_syntax import command, continued, heading
from grainfit.solvers.dem.sphere_types import SphereTypes

#: Concepts that LIGGGHTS does not have, with the reason and what to use instead.
MISSING: Mapping[str, str] = {
    "velocity and load": (
        "LIGGGHTS moves a wall either at a velocity or under a load, not the same wall in turn; "
        "use a load in every stage, its largest speed is the velocity of the approach"
    ),
    "load on an area": (
        "the servo of LIGGGHTS holds a force that is a number, and the area between moving walls "
        'changes; use solver = "lammps" or "yade"'
    ),
    "friction of a stage": (
        "LIGGGHTS reads the friction between particles once, before the first stage; use "
        'solver = "lammps" or "yade"'
    ),
}

#: Variables that looks define again.
_LOOKS = ("energy", "passed", "count", "since", "before", "near", "top", "below")


class LiggghtsSceneDeck(ScriptDeck):
    """A scene as a deck for LIGGGHTS-PUBLIC; see `ScriptDeck`."""

    file_name: ClassVar[str] = "in.liggghts"
    no_spin: ClassVar[str] = "omegax 0.0 omegay 0.0 omegaz 0.0"
    introduction: ClassVar[tuple[str, ...]] = (
        "LIGGGHTS-PUBLIC 3.8",
        "By hand, in this folder:  liggghts -in in.liggghts",
        f"Reads {PARTICLES} and *.stl; writes stages.csv, snapshots/*.dump and series_*.csv.",
    )

    def __init__(self, scene: Scene, folder: Path) -> None:
        self.clumps = None if scene.clumps is None else Multispheres(scene)
        super().__init__(scene, folder)
        if self.clumps is not None:
            # In the first half step after a setup, no wall holds a body of fix multisphere.
            self.without = "pre no post no"

    @property
    def _surfaces(self) -> list[str]:
        """Surfaces of all walls, at least one; their types are 2, 3, ..."""
        return list(dict.fromkeys(w.surface for w in self.scene.all_walls().values())) or [WALL]

    def head(self) -> Iterator[str]:
        """Iterate over the settings of the simulation."""
        yield command(
            "soft_particles", "yes".ljust(23) + " # or a Young's modulus below 5 MPa is refused"
        )
        yield command("hard_particles", "yes".ljust(23) + " # or one above 1 GPa is (the wall's)")
        yield command("units", "si")
        yield command("atom_style", "granular")
        yield command("atom_modify", "map array")
        yield command("boundary", self.boundary())
        yield command("newton", "off")
        yield command("communicate", "single vel yes")
        yield command("processors", "* * 1".ljust(23) + " # a bed is split from above only")
        yield self.read_particles()
        yield command("neighbor", f"{0.3 * self.scene.sizes.sauter_diameter} bin")
        yield command("neigh_modify", "delay 0 every 1 check yes")

    def particle_types(self) -> tuple[int, list[int]]:
        """Return a type for the particles and one for each surface."""
        return 1 + len(self._surfaces), [1] * len(self.size_indices)

    # --- clumps --------------------------------------------------------------------------------

    def write_particles(self) -> None:
        """Write the particles of the beginning; of clumps, how they are inserted and struck off."""
        if self.clumps is None:
            super().write_particles()
            return
        types, _ = self.particle_types()
        files = {PARTICLES: self.clumps.data(types), INSERTION: self.clumps.insertion()}
        if any(stage.strike_off is not None for stage in self.scene.stages):
            files[SURPLUS] = self.clumps.surplus()
        for name, text in files.items():
            (self.folder / name).write_text(text, encoding="ascii")

    @property
    def loose_spheres(self) -> int:
        """Number of spheres of loose particles before the first glued one: clumps come later."""
        return super().loose_spheres if self.clumps is None else 0

    @property
    def largest_radius(self) -> float:
        """Radius of the largest sphere, m."""
        if self.clumps is None:
            return super().largest_radius
        return max(self.clumps.spheres.radii_of_kinds)

    @property
    def kinetic(self) -> str:
        """Expression of the kinetic energy of the translation of the loose particles."""
        return super().kinetic if self.clumps is None else "c_translation"

    @property
    def shown_energy(self) -> str:
        """Keywords of the kinetic energy in the log; variables of computes must be in it."""
        return super().shown_energy if self.clumps is None else "v_kinetic v_remaining"

    @property
    def count(self) -> str:
        """Expression of the number of loose particles."""
        return super().count if self.clumps is None else f"c_whole/{self.clumps.each}"

    @property
    def snapshot_columns(self) -> str:
        """Columns of a snapshot; of clumps, the number of the clump and the share of its mass."""
        return super().snapshot_columns + ("" if self.clumps is None else f" mol {SHARE}")

    @property
    def snapshot_filter(self) -> str:
        """Further arguments of ``dump_modify`` that leave out what is no particle."""
        return "" if self.clumps is None else self.clumps.FILTER

    def integration(self) -> Iterator[str]:
        """Iterate over gravity and the integration of the loose particles."""
        if self.clumps is None:
            return super().integration()
        return self.clumps.integration(self.loose)

    def stage(self, stage: Stage) -> Iterator[str]:
        """Iterate over the commands of a stage."""
        if self.clumps is not None:
            # A new definition goes to the end of LIGGGHTS' list of variables. Without a setup, runs
            # know variables by their places: those of looks must come after those of the stage.
            yield ""
            yield from (command("variable", f"{name} delete") for name in _LOOKS)
        yield from super().stage(stage)

    def motion(self) -> Iterator[str]:
        """Iterate over gravity, integration, and the variables that stages look at."""
        yield from super().motion()
        if self.clumps is not None:
            # A stage that is closed counts its particles before its first run.
            yield command("run", "0 post no")

    def strike_off(self, height: float) -> Iterator[str]:
        """Remove the loose particles whose centre is above a height."""
        if self.clumps is None:
            return super().strike_off(height)
        return self.clumps.strike_off(height)

    def before(self, stage: Stage) -> Iterator[str]:
        """Iterate over the commands before the first look; of clumps, there is a run among them."""
        lines = list(super().before(stage))
        yield from lines
        if self.clumps is not None and not any(line.startswith("run") for line in lines):
            yield command("run", "0 post no")

    def looked_at(self, until: Condition, near: str = "0") -> Iterator[str]:
        """Define the variables that looks of a stage need; that of a compute is in the log."""
        yield from super().looked_at(until, near)
        if self.clumps is not None and isinstance(until, Drained):
            yield from self.log_columns(f"{self.shown_energy} v_{UNDRAINED}")
            self.undo = [*self.log_columns(self.shown_energy), *self.undo]

    def record_mass_above(self, height: float, name: str) -> Iterator[str]:
        """Define a variable: the mass of the loose particles above a height."""
        if self.clumps is None:
            yield from super().record_mass_above(height, name)
            return
        yield from self.clumps.mass_above(height, self.loose, name)
        self.undo += self.clumps.forget_mass_above(name)

    # --- contacts ------------------------------------------------------------------------------

    def contacts(self) -> Iterator[str]:
        """Iterate over the properties of particles and surfaces."""
        surfaces = self._surfaces
        names = "".join(f", {n} {name}" for n, name in enumerate(surfaces, 2))
        yield heading(f"materials: 1 particles{names}")
        properties = self.properties()
        for name, values in properties.bodies.items():
            row = " ".join(map(str, values))
            key = properties.keys[name]
            yield command("fix", f"{key} all property/global {name} peratomtype {row}")
        for name, matrix in properties.pairs.items():
            first = f"{name} all property/global {name} peratomtypepair {len(matrix)}"
            yield continued(command("fix", first), [" ".join(map(str, row)) for row in matrix])
        yield command("pair_style", f"gran model {liggghts_model(self.law)}")
        yield command("pair_coeff", "* *")
        if self.clumps is not None:
            yield from self.clumps.define()

    def properties(self) -> LiggghtsProperties[float]:
        """Return the properties of particles and surfaces, in the order of their types."""
        materials = [self.scene.material_on(name) for name in self._surfaces]
        return liggghts_properties(self.law, materials, list(self._kinds_of_contact(materials)))

    def _kinds_of_contact(self, materials: Iterable[Mapping[str, float]]) -> Iterator[Contact]:
        """Iterate over the contact of two particles, and those with walls of some materials."""
        sphere, gravity = SphereTypes.mean_of(self.scene.sizes), self.scene.weight_gravity
        yield sphere.between(self.scene.material_on(WALL), 1, 1, gravity)
        yield from (sphere.on_wall(material, 1, gravity) for material in materials)

    # --- walls ---------------------------------------------------------------------------------

    def first_walls(self) -> Iterator[str]:
        """Iterate over the walls of the beginning."""
        for name, wall in self.scene.walls.items():
            yield from self.put(name, wall)
        yield from self.all_walls()

    def change_walls(self, stage: Stage) -> Iterator[str]:
        """Take away and put walls: the one fix of all walls is made again."""
        if not (stage.take_away or stage.put):
            return
        if self._meshes:
            yield command("unfix", "walls")
        for name in stage.take_away:
            yield from self.forget_sums(name)
            yield command("unfix", name)
            del self.walls[name]
        for name, wall in stage.put.items():
            yield from self.put(name, wall)
        yield from self.all_walls()

    def put(self, name: str, wall: Wall) -> Iterator[str]:
        """Put a wall; `all_walls` follows."""
        self.walls[name] = wall
        if self._is_through(name):
            yield from self.put_tube(name, wall)
            if name in self.moving_walls():
                yield command("variable", f"{name}_travel equal {self.travels.get(name, '0.0')}")
            return
        path = self.folder / f"{name}.stl"
        edge = 0.95 * self.scene.sizes.sauter_diameter
        write_stl(path, triangles_of(wall.shape, self.scene.box, edge))
        number = 2 + self._surfaces.index(wall.surface)
        loads = [m for m in self.scene.motions_of(name) if isinstance(m, Load)]
        style = "mesh/surface/stress" if name in self.measured_walls() else "mesh/surface"
        servo = ""
        if loads:
            style, servo = "mesh/surface/stress/servo", f" {self._servo(loads[0])}"
        yield command("fix", f"{name} {self.loose} {style} file {path.name} type {number}{servo}")
        if loads:
            yield command("fix_modify", f"{name} integrate stop")
        elif name in self.moving_walls():
            yield command("variable", f"{name}_travel equal {self.travels.get(name, '0.0')}")

    def _is_through(self, name: str) -> bool:
        """Return whether a wall is a tube through the box that stays, or turns about its axis."""
        shape, box = self.scene.all_walls()[name].shape, self.scene.box
        if not isinstance(shape, Cylinder):
            return False
        if not all(_turns_on_itself(shape, motion) for motion in self.scene.motions_of(name)):
            return False
        if shape.axis in box.periodic:
            return True
        axis = self.component(shape.axis)
        return shape.bottom <= box.low[axis] and shape.top >= box.high[axis]

    def put_tube(self, name: str, wall: Wall, speed: float = 0.0) -> Iterator[str]:
        """Put a tube through the box: it is exact, and has the forces of its own contacts.

        It turns about its axis with a speed, rad/s.
        """
        assert isinstance(wall.shape, Cylinder)
        number = 2 + self._surfaces.index(wall.surface)
        stored = " store_force yes" if name in self.measured_walls() else ""
        axis = wall.shape.axis
        # Shear along another axis is a rotation about the tube's own.
        turns = f" shear y {speed}" if speed else ""
        style = f"{axis}cylinder {wall.shape.radius} 0.0 0.0"
        shape = f"primitive type {number} {style}{turns}{stored}"
        first = f"{name} {self.loose} wall/gran model {liggghts_model(self.law)}"
        yield continued(command("fix", first), [shape])

    def put_tube_again(self, name: str, speed: float) -> Iterator[str]:
        """Put a tube through the box with another speed: its contacts lose their history."""
        yield from self.forget_sums(name)
        yield command("unfix", name)
        yield from self.put_tube(name, self.walls[name], speed)

    @property
    def _meshes(self) -> list[str]:
        return [name for name in self.walls if not self._is_through(name)]

    def _servo(self, load: Load) -> str:
        axis = [0.0, 0.0, 0.0]
        axis[self.component(load.along)] = 1.0 if load.force > 0 else -1.0
        return (
            f"com 0.0 0.0 0.0 ctrlPV force axis {axis[0]} {axis[1]} {axis[2]} "
            f"target_val {abs(load.force)} vel_max {load.largest_speed} kp {_gain(load)}"
        )

    def all_walls(self) -> Iterator[str]:
        """Iterate over the one fix of all walls that are meshes."""
        if not self._meshes:
            return
        meshes = f"mesh n_meshes {len(self._meshes)} meshes {' '.join(self._meshes)}"
        first = f"walls {self.loose} wall/gran model {liggghts_model(self.law)}"
        yield continued(command("fix", first), [meshes])

    # --- motions -------------------------------------------------------------------------------

    def start_motion(self, wall: str, motion: Motion) -> Iterator[str]:
        """Start a motion of a wall."""
        if isinstance(motion, Load):
            yield command("fix_modify", f"{wall} target_val {abs(motion.force)}")
            yield command("fix_modify", f"{wall} ctrlParam {_gain(motion)} 0.0 0.0")
            yield command("fix_modify", f"{wall} integrate start")
            yield from self.record_force(wall, motion.along, f"{wall}_force")
            yield self.travel_of_servo(wall, motion.along)
            return
        if self._is_through(wall):
            assert isinstance(motion, Rotation)
            yield from self.put_tube_again(wall, motion.speed)
            yield from self.follow(wall, motion.speed)
            return
        vector = [0.0, 0.0, 0.0]
        if isinstance(motion, Rotation):
            vector[self.component(motion.along)] = math.copysign(1.0, motion.speed)
            moved = f"rotate origin {_numbers(motion.through)} axis {_numbers(vector)} "
            moved += f"period {2 * math.pi / abs(motion.speed)}"
        else:
            vector[self.component(motion.along)] = motion.speed
            moved = f"linear {_numbers(vector)}"
        yield command("fix", f"{wall}_motion all move/mesh mesh {wall} {moved}")
        yield from self.follow(wall, motion.speed)

    def travel_of_servo(self, wall: str, along: str) -> str:
        """Return the command that defines the variable of the travel of a wall under a load."""
        return command("variable", f"{wall}_travel equal f_{wall}[{7 + self.component(along)}]")

    def stop_motion(self, wall: str, motion: Motion) -> Iterator[str]:
        """Stop a motion of a wall where it is."""
        if isinstance(motion, Load):
            yield command("fix_modify", f"{wall} integrate stop")
            return
        if self._is_through(wall):
            yield from self.put_tube_again(wall, 0.0)
        else:
            yield command("unfix", f"{wall}_motion")
        yield from self.hold(wall)

    # --- records -------------------------------------------------------------------------------

    def snapshot(self, name: str) -> Iterator[str]:
        """Write the particles into a file."""
        dump = f"{name} all custom 1 {snapshot_file(name)} {self.snapshot_columns}"
        yield command("dump", dump)
        yield command("dump_modify", f"{name} sort id{self.snapshot_filter}")
        yield command("run", "0 post no")
        yield command("undump", name)

    def record_force(self, wall: str, along: str, name: str) -> Iterator[str]:
        """Define a variable: the force of the particles on a wall along an axis."""
        number = 1 + self.component(along)
        if not self._is_through(wall):
            yield command("variable", f"{name} equal f_{wall}[{number}]")
            return
        sum_ = f"{wall}_{along}"
        if self.is_new_sum(wall, sum_):
            force = f"reduce sum f_force_{wall}[{number}]"
            yield command("compute", f"{sum_} {self.loose} {force}")
        yield command("variable", f"{name} equal -c_{sum_}")

    def record_radial_force(self, wall: str, name: str) -> Iterator[str]:
        """Define a variable: the force of the particles on a wall away from the z axis.

        Raises
        ------
        InputError
            The wall is a mesh: LIGGGHTS knows the sum of its forces only.
        """
        if not self._is_through(wall):
            raise InputError(messages.RADIAL_FORCE_OF_MESH.fault(wall))
        sum_ = f"{wall}_radial"
        if self.is_new_sum(wall, sum_):
            force = f"f_force_{wall}"
            # A particle on the axis must not divide by zero.
            radial = f"({force}[1]*x+{force}[2]*y)/sqrt(x*x+y*y+1e-30)"
            yield command("variable", f"{sum_}_of atom {radial}")
            yield command("compute", f"{sum_} {self.loose} reduce sum v_{sum_}_of")
        yield command("variable", f"{name} equal -c_{sum_}")


def _numbers(values: Iterable[float]) -> str:
    return " ".join(str(value) for value in values)


def _turns_on_itself(shape: Cylinder, motion: Motion) -> bool:
    """Return whether a motion leaves a tube in its place, and a primitive can have it."""
    # About the y axis, LIGGGHTS moves a primitive along its normal.
    is_lengthwise = shape.axis == "x" and motion.along == "x"
    return isinstance(motion, Rotation) and is_lengthwise and not any(motion.through[1:])


def _gain(load: Load) -> float:
    """Gain of the servo: share of the largest speed over share of the force that is missing."""
    return load.gain * abs(load.force) / load.largest_speed
