"""Scenes as decks for LAMMPS: walls are regions, one fix for each wall and particle size."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import ClassVar

from grainfit.contact_models.lammps import lammps_clauses, lammps_keywords
from grainfit.scenes.run_output import snapshot_file
from grainfit.scenes.scene import Load, Motion, Rotation, Scene, Stage, Wall
from grainfit.scenes.shapes import Annulus, Block, Cone, Cylinder, Disc, Plane, Prism, Shape
from grainfit.solvers.dem.lammps.rigid_clumps import BODIES, RigidClumps
from grainfit.solvers.dem.script import PARTICLES, ScriptDeck
from grainfit.solvers.dem.script_syntax import command, continued, heading
from grainfit.solvers.dem.sphere_types import SphereTypes

#: Concepts that LAMMPS does not have, with the reason and what to use instead.
MISSING: Mapping[str, str] = {
    "mesh": 'LAMMPS has no friction on walls from STL files; use solver = "liggghts"',
}
#: Height of the nearly flat cone that is a ring, over its outer radius.
_FLAT = 1e-6

#: Remark on the coefficients of walls.
_ABOUT_WALLS = (
    "# LAMMPS gives a wall the stiffness of the particle; the modulus below is the one at",
    "# which that makes the contact as stiff as that of a particle with the real wall.",
)


class LammpsSceneDeck(ScriptDeck):
    """A scene as a deck for LAMMPS with its GRANULAR package; see `ScriptDeck`."""

    file_name: ClassVar[str] = "in.lammps"
    no_spin: ClassVar[str] = "omega 0.0 0.0 0.0"
    introduction: ClassVar[tuple[str, ...]] = (
        "LAMMPS with its GRANULAR package",
        "By hand, in this folder:  lmp -in in.lammps",
        f"Reads {PARTICLES}; writes stages.csv, snapshots/*.dump and series_*.csv.",
    )

    def __init__(self, scene: Scene, folder: Path) -> None:
        self.clumps = None if scene.clumps is None else RigidClumps(scene)
        super().__init__(scene, folder)

    def head(self) -> Iterator[str]:
        """Iterate over the settings of the simulation."""
        yield command("units", "si")
        yield command("atom_style", "sphere")
        yield command("atom_modify", "map array")
        yield command("boundary", self.boundary())
        yield command("newton", "off")
        cutoff = "" if self.clumps is None else f" cutoff {self.clumps.reach}"
        yield command("comm_modify", f"vel yes{cutoff}")
        yield command("processors", "* * 1".ljust(23) + " # a bed is split from above only")
        if self.clumps is None:
            yield self.read_particles()
        else:
            yield from self.clumps.read(PARTICLES)
        yield command("neighbor", f"{0.3 * self.scene.sizes.sauter_diameter} bin")
        yield command("neigh_modify", "delay 0 every 1 check yes")
        if self.clumps is not None:
            yield command("neigh_modify", "exclude molecule/intra all")
            return
        yield "# Particles are no molecules: without this, one alone would have no kinetic energy."
        yield command("compute_modify", "thermo_temp extra/dof 0")

    def particle_types(self) -> tuple[int, list[int]]:
        """Return one type for each diameter."""
        kinds = (self.size_indices + 1).tolist()
        return len(self.scene.sizes.diameters), kinds

    # --- clumps --------------------------------------------------------------------------------

    def write_particles(self) -> None:
        """Write the particles of the beginning; of clumps, the bodies, too."""
        if self.clumps is None:
            super().write_particles()
            return
        (self.folder / PARTICLES).write_text(self.clumps.data(), encoding="ascii")
        (self.folder / BODIES).write_text(self.clumps.bodies(), encoding="ascii")

    @property
    def loose_spheres(self) -> int:
        """Number of spheres of loose particles: the first glued one has the next number."""
        return super().loose_spheres if self.clumps is None else self.clumps.number_of_spheres

    @property
    def largest_radius(self) -> float:
        """Radius of the largest sphere, m."""
        return max(self.kinds.radii)

    @property
    def kinetic(self) -> str:
        """Expression of the kinetic energy of the translation of the loose particles."""
        return super().kinetic if self.clumps is None else "c_translation"

    @property
    def shown_energy(self) -> str:
        """Keyword of the kinetic energy in the log."""
        return super().shown_energy if self.clumps is None else "v_kinetic"

    @property
    def count(self) -> str:
        """Expression of the number of loose particles."""
        if self.clumps is None:
            return super().count
        return f"count({self.loose})/{len(self.clumps.spheres.clump)}"

    def integration(self) -> Iterator[str]:
        """Iterate over gravity and the integration of the loose particles."""
        if self.clumps is None:
            return super().integration()
        return self.clumps.integration(self.loose)

    def strike_off(self, height: float) -> Iterator[str]:
        """Remove the loose particles whose centre is above a height."""
        if self.clumps is None:
            return super().strike_off(height)
        return self.clumps.strike_off(self.loose, height)

    @property
    def snapshot_columns(self) -> str:
        """Columns of a snapshot; of clumps, the number of the clump, too."""
        return super().snapshot_columns + ("" if self.clumps is None else " mol")

    # --- contacts ------------------------------------------------------------------------------

    @cached_property
    def kinds(self) -> SphereTypes:
        """Types of spheres."""
        if self.clumps is None:
            return SphereTypes.of(self.scene.sizes)
        return self.clumps.kinds

    def contacts(self) -> Iterator[str]:
        """Iterate over the contact law of each pair of sizes."""
        yield heading("particles: one type for each diameter")
        yield from (f"# {one.legend}" for one in lammps_keywords(self.law) if one.legend)
        yield command("pair_style", "granular")
        yield from self.between_particles()
        for number in self._numbers():
            yield command("group", f"size{number} type {number}")

    def between_particles(self, sliding_friction: float | None = None) -> Iterator[str]:
        """Iterate over the contact law between particles, with another sliding friction."""
        scene, kinds = self.scene, self.kinds
        material = scene.material_on("wall")
        if sliding_friction is not None:
            material["particle_particle.sliding_friction"] = sliding_friction
        for i in self._numbers():
            for j in self._numbers()[i - 1 :]:
                contact = kinds.between(material, i, j, scene.weight_gravity, scene.typical_load)
                yield continued(
                    command("pair_coeff", f"{i} {j}"), lammps_clauses(self.law, contact)
                )

    # --- walls ---------------------------------------------------------------------------------

    def first_walls(self) -> Iterator[str]:
        """Iterate over the walls of the beginning."""
        if self.law.is_load_dependent:
            yield from _ABOUT_WALLS
        if self.scene.glued:
            for number in self._numbers():
                yield command("group", f"size{number} subtract size{number} glued")
        for name, wall in self.scene.walls.items():
            yield from self.put(name, wall)

    def change_walls(self, stage: Stage) -> Iterator[str]:
        """Take away and put walls; each has its own fixes, so that the others stay as they are."""
        for name in stage.take_away:
            yield from self.forget_sums(name)
            yield from (command("unfix", f"{name}{n}") for n in self._numbers())
        for name, wall in stage.put.items():
            yield from self.put(name, wall)

    def _numbers(self) -> range:
        return range(1, len(self.kinds.radii) + 1)

    def put(self, name: str, wall: Wall) -> Iterator[str]:
        """Put a wall."""
        motion = self.moving_walls().get(name)
        move = ""
        if motion is not None:
            style = "internal" if self.is_loaded(name) else "equal"
            yield command("variable", f"{name}_travel {style} {self.travels.get(name, '0.0')}")
            move = f" {self._moved(name, motion)}"
        yield command("region", f"{name} {self._region(wall.shape)}{move}")
        material = self.scene.material_on(wall.surface)
        measured = " contacts" if name in self.measured_walls() else ""
        for number in self._numbers():
            contact = self.kinds.on_wall(
                material, number, self.scene.weight_gravity, self.scene.typical_load
            )
            clauses = lammps_clauses(self.law, contact)
            clauses[-1] += f" region {name}{measured}"
            yield continued(
                command("fix", f"{name}{number} size{number} wall/gran/region granular"), clauses
            )

    def _moved(self, wall: str, motion: Motion) -> str:
        """Return the arguments with which the region of a wall follows its variable."""
        if isinstance(motion, Rotation):
            axis = [0.0] * 3
            axis[self.component(motion.along)] = 1.0
            return f"rotate v_{wall}_travel {_numbers([*motion.through])} {_numbers(axis)}"
        along = ["NULL", "NULL", "NULL"]
        along[self.component(motion.along)] = f"v_{wall}_travel"
        return f"move {' '.join(along)}"

    def _region(self, shape: Shape) -> str:
        if isinstance(shape, Plane):
            axis = self.component(shape.axis)
            point, normal = [0.0] * 3, [0.0] * 3
            point[axis], normal[axis] = shape.at, 1.0 if shape.upwards else -1.0
            return f"plane {_numbers(point)} {_numbers(normal)} units box"
        if isinstance(shape, Block):
            sides = " ".join(
                "INF INF" if axis in self.scene.box.periodic else f"{low} {high}"
                for axis, low, high in zip("xyz", shape.low, shape.high, strict=True)
            )
            return f"block {sides} units box side out"
        if isinstance(shape, Cylinder):
            ends = f"{shape.bottom} {shape.top}"
            if shape.axis in self.scene.box.periodic:
                ends = "INF INF"
            return f"cylinder {shape.axis} 0 0 {shape.radius} {ends} units box open 1 open 2"
        if isinstance(shape, Prism):
            return f"prism {_numbers(self._prism(shape))} units box side out"
        if isinstance(shape, Annulus):
            # Without ends, a cone is met from both sides and at its rims: a flat one is a ring.
            bottom = shape.z - _FLAT * shape.outer_radius
            return self._region(Cone(shape.inner_radius, shape.outer_radius, bottom, shape.z))
        if isinstance(shape, Cone):
            radii = f"{shape.lower_radius} {shape.upper_radius}"
            return f"cone z 0 0 {radii} {shape.bottom} {shape.top} units box open 1 open 2"
        assert isinstance(shape, Disc), "shapes that LAMMPS does not have are refused before"
        # A solid cylinder met from outside: far below, or its lower side would count.
        bottom = shape.z - 2 * (shape.z - self.scene.box.low[2])
        return f"cylinder z 0 0 {shape.radius} {bottom} {shape.z} units box side out"

    def _prism(self, shape: Prism) -> list[float]:
        """Return the limits of a prism and its shifts, m.

        Along a periodic axis it ends beyond the box: the edges of an infinite one are lost to
        rounding.
        """
        ends: list[float] = []
        box = self.scene.box
        for axis, low, high in zip("xyz", shape.low, shape.high, strict=True):
            ends += box.beyond(axis) if axis in box.periodic else (low, high)
        return [*ends, 0.0, shape.shift, 0.0]

    # --- motions -------------------------------------------------------------------------------

    def start_motion(self, wall: str, motion: Motion) -> Iterator[str]:
        """Start a motion of a wall."""
        travel = f"{wall}_travel"
        if isinstance(motion, Rotation) or not self.is_loaded(wall):
            yield from self.follow(wall, motion.speed)  # type: ignore[union-attr]
            return
        yield from self.record_force(wall, motion.along, f"{wall}_force")
        if isinstance(motion, Load):
            yield f"# The more force is missing, the faster; at most {motion.largest_speed} m/s."
            share = motion.gain / motion.largest_speed
            force = f"{motion.force}"
            if motion.across:
                yield command("variable", f"{wall}_stretch equal {self._stretch(motion)}")
                force += f"*v_{wall}_stretch"
            missing = f"({force}+v_{wall}_force)"
            yield command("variable", f"{wall}_lack equal {share}*{missing}")
            lack = f"v_{wall}_lack"
            speed = f"{-motion.largest_speed}*{lack}/sqrt(1.0+{lack}*{lack})"
        else:
            speed = f"{-motion.speed}"
        yield command("variable", f"{wall}_speed equal {speed}")
        yield command(
            "fix", f"{wall}_motion all controller 1 1.0 1.0 0.0 0.0 v_{wall}_speed 0.0 {travel}"
        )

    def _stretch(self, load: Load) -> str:
        """Return the expression of an area over what it was where its walls were put."""
        moving = self.moving_walls()
        factors = []
        for low, high in load.across:
            ways = "".join(
                f"{sign}v_{wall}_travel"
                for sign, wall in (("+", high), ("-", low))
                if wall in moving
            )
            factors.append(f"(1.0+(0.0{ways})/{self.scene.first_distance(low, high)})")
        return "*".join(factors)

    def stop_motion(self, wall: str, motion: Motion) -> Iterator[str]:  # noqa: ARG002
        """Stop a motion of a wall where it is."""
        if self.is_loaded(wall):
            yield command("unfix", f"{wall}_motion")
        else:
            yield from self.hold(wall)

    # --- records -------------------------------------------------------------------------------

    def snapshot(self, name: str) -> Iterator[str]:
        """Write the particles into a file."""
        dump = f"all custom {snapshot_file(name)} {self.snapshot_columns} modify sort id"
        yield command("write_dump", dump)

    def record_force(self, wall: str, along: str, name: str) -> Iterator[str]:
        """Define a variable: the force of the particles on a wall along an axis."""
        # Column 1 says whether there is a contact; columns 2 to 4 are the force on the particle.
        column = 2 + self.component(along)
        sums = [f"{wall}_{along}{n}" for n in self._numbers()]
        for n, sum_ in zip(self._numbers(), sums, strict=True):
            if self.is_new_sum(wall, sum_):
                yield command("compute", f"{sum_} size{n} reduce sum f_{wall}{n}[{column}]")
        yield command("variable", f"{name} equal {_minus(sums)}")

    def record_radial_force(self, wall: str, name: str) -> Iterator[str]:
        """Define a variable: the force of the particles on a wall away from the z axis."""
        sums = [f"{wall}_radial{n}" for n in self._numbers()]
        for n, sum_ in zip(self._numbers(), sums, strict=True):
            if self.is_new_sum(wall, sum_):
                # A particle on the axis must not divide by zero.
                force = f"(f_{wall}{n}[2]*x+f_{wall}{n}[3]*y)/sqrt(x*x+y*y+1e-30)"
                yield command("variable", f"{sum_}_of atom {force}")
                yield command("compute", f"{sum_} size{n} reduce sum v_{sum_}_of")
        yield command("variable", f"{name} equal {_minus(sums)}")


def _minus(sums: list[str]) -> str:
    return "".join(f"-c_{sum_}" for sum_ in sums)


def _numbers(values: list[float]) -> str:
    return " ".join(str(value) for value in values)
