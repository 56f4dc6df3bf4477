"""Clumps in decks for LAMMPS: molecules that ``fix rigid/small`` moves.

LAMMPS reads mass, centre and inertia of every clump from a file: those that it would sum from
overlapping spheres are too large. The spheres have a lower density, so that their masses add up to
that of the clump, and gravity acts on the clump as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grainfit.scenes.scene import Scene
from grainfit.scenes.spheres import ClumpSpheres
from grainfit.solvers.dem.rigid_bodies import rigid_bodies
from grainfit.solvers.dem.script_syntax import command, continued
from grainfit.solvers.dem.sphere_types import SphereTypes

BODIES = "clumps.txt"
#: Time steps between two searches for clumps that have left the box.
_LOOK_OUTSIDE = 20
#: Speed of a fall from the top of the column, times this, is one that no clump exceeds.
_FASTEST = 3.0


class RigidClumps:
    """Commands and files of a deck for the clumps of a scene.

    Parameters
    ----------
    scene : Scene
        A scene with clumps.
    """

    def __init__(self, scene: Scene) -> None:
        assert scene.clumps is not None, "a scene of spheres needs no rigid bodies"
        self.scene = scene
        self.spheres: ClumpSpheres = scene.clumps
        self.kinds = SphereTypes.of(scene.sizes, with_spheres=bool(scene.glued))
        self.count = len(scene.particles.size_indices)

    # --- particles -----------------------------------------------------------------------------

    @property
    def number_of_spheres(self) -> int:
        """Number of spheres of all clumps."""
        return self.count * len(self.spheres.clump)

    @cached_property
    def types(self) -> NDArray[np.int64]:
        """Type of every sphere, those of glued particles last."""
        loose = self.spheres.kinds(self.scene.particles.size_indices).reshape(-1) + 1
        first = len(self.spheres.radii_of_kinds) + 1
        glued = [first + body.size_indices for body in self.scene.glued.values()]
        return np.concatenate([loose, *glued])

    def data(self) -> str:
        """Return the data file: all spheres, and the clump of each."""
        (x, y, z), (x2, y2, z2) = self.corners()
        return "\n".join(
            (
                "Random column of clumps: id type diameter density x y z, images; sphere clump\n",
                f"{len(self.types)} atoms",
                f"{len(self.kinds.radii)} atom types\n",
                f"{x!r} {x2!r} xlo xhi\n{y!r} {y2!r} ylo yhi\n{z!r} {z2!r} zlo zhi\n",
                "Atoms\n",
                *self._rows(),
                "\nClumps\n",
                *self._molecules(),
                "",
            )
        )

    def _rows(self) -> Iterator[str]:
        """Iterate over the atoms: id, type, diameter, density, place, image flags."""
        scene = self.scene
        places, radii = scene.particles.outlines(self.spheres)
        low, high = np.array(scene.box.low), np.array(scene.box.high)
        periodic = np.array([axis in scene.box.periodic for axis in "xyz"])
        images = np.where(periodic, np.floor((places - low) / (high - low)), 0.0)
        places = places - images * (high - low)
        diameters = 2 * radii
        solid = scene.material["particle.density"]
        density = solid * self.spheres.clump.overlap_factor
        rows = zip(
            self.types.tolist(), diameters.tolist(), places.tolist(), images.tolist(), strict=False
        )
        number = 0
        for number, (kind, diameter, (x, y, z), (i, j, k)) in enumerate(rows, 1):
            place = f"{x:.12g} {y:.12g} {z:.12g} {int(i)} {int(j)} {int(k)}"
            yield f"{number} {kind} {diameter!r} {density!r} {place}"
        types = self.types.tolist()
        for body in scene.glued.values():
            for index, (x, y, z) in zip(body.size_indices, body.positions.tolist(), strict=True):
                number += 1
                diameter = scene.sizes.diameters[index]
                place = f"{x:.12g} {y:.12g} {z:.12g} 0 0 0"
                yield f"{number} {types[number - 1]} {diameter!r} {solid!r} {place}"

    def _molecules(self) -> Iterator[str]:
        """Iterate over the clump of every sphere; 0 for glued particles."""
        each = len(self.spheres.clump)
        for number in range(1, len(self.types) + 1):
            yield f"{number} {(number - 1) // each + 1 if number <= self.number_of_spheres else 0}"

    def bodies(self) -> str:
        """Return the file of bodies: mass, centre, inertia, velocity, angular momentum, images."""
        bodies, column = rigid_bodies(self.scene), self.scene.particles
        momenta = np.einsum("nij,nj->ni", bodies.inertia, bodies.spins)
        upper = bodies.upper_inertia
        table = np.column_stack(
            (bodies.masses, column.positions, upper, bodies.velocities, momenta)
        )
        rows = (
            f"{number} {' '.join(f'{value:.15g}' for value in row)} 0 0 0"
            for number, row in enumerate(table.tolist(), 1)
        )
        return "\n".join([str(self.count), *rows]) + "\n"

    # --- box -----------------------------------------------------------------------------------

    @property
    def _outermost(self) -> float:
        return max(self.scene.sizes.outer_diameters)

    @staticmethod
    def read(file: str) -> Iterator[str]:
        """Iterate over the commands that read the data file."""
        yield command("fix", "clump all property/atom mol ghost yes")
        yield command("read_data", f"{file} fix clump NULL Clumps")

    def corners(self) -> tuple[list[float], list[float]]:
        """Return the corners of LAMMPS' box, beyond which a part of a clump must never get.

        Clumps that leave the scene's box are deleted as a whole in the space between both.
        """
        scene = self.scene
        drop = scene.gravity * (scene.particles.height - scene.box.low[2])
        velocities = scene.particles.velocities
        start = 0.0 if velocities is None else float(np.abs(velocities).max())
        moving = max(
            (abs(m.speed) for s in scene.stages for _, m in s.all_motions() if hasattr(m, "speed")),
            default=0.0,
        )
        speed = _FASTEST * (math.sqrt(2 * drop) + start + moving)
        margin = self._outermost + speed * scene.time_step * _LOOK_OUTSIDE
        margins = [0.0 if axis in scene.box.periodic else margin for axis in "xyz"]
        low = [value - more for value, more in zip(scene.box.low, margins, strict=True)]
        high = [value + more for value, more in zip(scene.box.high, margins, strict=True)]
        return low, high

    def _inside(self) -> str:
        box = self.scene.box
        return " ".join(
            "INF INF" if axis in box.periodic else f"{low} {high}"
            for axis, low, high in zip("xyz", box.low, box.high, strict=True)
        )

    # --- commands ------------------------------------------------------------------------------

    @property
    def reach(self) -> float:
        """Return the distance up to which a processor must know particles, m."""
        return self._outermost + 0.3 * self.scene.sizes.sauter_diameter

    def integration(self, loose: str) -> Iterator[str]:
        """Iterate over gravity, the motion of a group of clumps, and its end beyond the box."""
        yield f"# Masses, centres and moments of inertia of the clumps are those of {BODIES}."
        gravity = f"gravity {loose} gravity {self.scene.gravity} vector 0.0 0.0 -1.0"
        yield command("fix", f"{gravity} disable")
        first = f"motion {loose} rigid/small molecule"
        yield continued(command("fix", first), [f"infile {BODIES} gravity gravity"])
        yield "# Of clumps, too, rotation does not count: one may spin on a point for ever."
        yield command("compute", f"translation {loose} ke/rigid motion")
        yield "# A clump of which a part leaves the box is gone: LAMMPS stops at half a clump."
        yield command("region", f"beyond block {self._inside()} units box side out")
        every = f"{_LOOK_OUTSIDE} {self.number_of_spheres} beyond 1 molecule yes"
        yield command("fix", f"leave {loose} evaporate {every}")

    def strike_off(self, loose: str, height: float) -> Iterator[str]:
        """Iterate over the commands that remove clumps whose centre is above a height."""
        yield command("compute", f"clump {loose} chunk/atom molecule nchunk every")
        yield command("compute", f"centres {loose} com/chunk clump")
        yield command("compute", f"centre {loose} chunk/spread/atom clump c_centres[3]")
        yield command("run", "0 post no")
        yield command("variable", f"surplus atom c_centre>{height}")
        yield command("group", "surplus variable surplus")
        yield command("group", f"surplus intersect surplus {loose}")
        yield command("delete_atoms", "group surplus compress no mol yes")
        yield command("group", "surplus delete")
        yield command("variable", "surplus delete")
        yield from (command("uncompute", name) for name in ("centre", "centres", "clump"))
