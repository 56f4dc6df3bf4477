"""Clumps in decks for LIGGGHTS: bodies of ``fix multisphere``.

LIGGGHTS takes clumps from its own insertion only. Each is inserted by a fix of its own, into a
region that is a point for all purposes: it gets the place, the orientation and the motion of the
scene, and no seed has any effect. All are there after time steps of no duration.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grainfit.scenes.scene import Scene
from grainfit.scenes.spheres import ClumpSpheres
from grainfit.solvers.dem.card_clumps import CardClump, card_clump
from grainfit.solvers.dem.script_syntax import command, continued, heading

#: File that inserts all clumps, and file that marks those above the variable ``height``.
INSERTION, SURPLUS = "clumps.liggghts", "surplus.liggghts"
#: Column of a dump: the share of a sphere in the mass of its clump.
SHARE = "v_share"
#: Different primes above 10000, or LIGGGHTS refuses them: of templates, sizes and insertion.
_SEEDS = (15485863, 15485867, 32452843)
#: Half the width of the region of a clump over its diameter.
_POINT = 1e-9
#: s; LIGGGHTS inserts in a time step, during which nothing may move.
_NO_TIME = 1e-15
#: LIGGGHTS compares the name of each fix with those of all others: 55,000 at once take it half an
#: hour, most of it before the first step.
_TOGETHER = 1500
#: Points by which LIGGGHTS estimates shares of volume that nothing here uses.
_TRIES = 100000
#: Group of the spheres of clumps.
_GROUP = "clumps"


class Multispheres:
    """Commands and files of a deck for the clumps of a scene.

    Parameters
    ----------
    scene : Scene
        A scene with clumps.
    """

    #: Leaves out what is left of clumps of which a sphere has left the box.
    FILTER: ClassVar[str] = " thresh v_whole > 0.5"

    def __init__(self, scene: Scene) -> None:
        assert scene.clumps is not None, "a scene of spheres needs no bodies"
        self.scene = scene
        self.spheres: ClumpSpheres = scene.clumps
        self.each = len(self.spheres.clump)
        self.count = len(scene.particles.size_indices)
        # Not read with the box: fix multisphere takes spheres that are there for its own.
        self.glued = sum(len(body.size_indices) for body in scene.glued.values())

    # --- files ---------------------------------------------------------------------------------

    def data(self, types: int) -> str:
        """Return the data file: the box."""
        ends = zip("xyz", self.scene.box.low, self.scene.box.high, strict=True)
        return "\n".join(
            (
                "Box of clumps\n",
                f"0 atoms\n{types} atom types\n",
                *(f"{low!r} {high!r} {axis}lo {axis}hi" for axis, low, high in ends),
                "",
            )
        )

    def _create_glued(self) -> Iterator[str]:
        """Iterate over the commands that create glued spheres, which have the first numbers."""
        sizes, density = self.scene.sizes, self.scene.material["particle.density"]
        number = 0
        for body in self.scene.glued.values():
            for index, place in zip(body.size_indices, self._inside(body.positions), strict=True):
                number += 1
                yield command("create_atoms", f"1 single {_numbers(place)} units box")
                solid = f"diameter {sizes.diameters[index]!r} density {density!r}"
                yield command("set", f"atom {number} {solid}")

    def _inside(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return positions within the periods: LIGGGHTS creates nothing beyond."""
        box = self.scene.box
        low, high = np.array(box.low), np.array(box.high)
        periodic = np.array([axis in box.periodic for axis in "xyz"])
        wrapped = low + (positions - low) % (high - low)
        # Of a negative rounding error, the remainder is the period itself.
        wrapped = np.where(wrapped >= high, low, wrapped)
        found: NDArray[np.float64] = np.where(periodic, wrapped, positions)
        return found

    def insertion(self) -> str:
        """Return the file that creates glued spheres, and all clumps, each at its place."""
        groups = range(0, self.count, _TOGETHER)
        fixes = (
            line
            for first in groups
            for line in self._insert_all(range(first, min(first + _TOGETHER, self.count)))
        )
        return "\n".join([*self._create_glued(), *fixes, ""])

    def _insert_all(self, numbers: range) -> Iterator[str]:
        """Iterate over the commands that insert clumps at once, by their numbers from 0."""
        for number in numbers:
            yield from self._insert(number)
        yield command("run", "1 post no")
        for number in numbers:
            yield command("unfix", f"put{number + 1}")
            yield command("region", f"at{number + 1} delete")

    def _insert(self, number: int) -> Iterator[str]:
        """Iterate over the commands for a clump, by its number from 0."""
        column, name = self.scene.particles, number + 1
        index = int(column.size_indices[number])
        half = _POINT * self.spheres.diameters[index]
        ends = (f"{x - half!r} {x + half!r}" for x in column.positions[number].tolist())
        yield command("region", f"at{name} block {' '.join(ends)} units box volume_limit 0.0")
        x, y, z, scalar = column.turns[number].tolist()
        motions = (
            f"{keyword} constant {_numbers(None if values is None else values[number])}"
            for keyword, values in (("vel", column.velocities), ("omega", column.spins))
        )
        yield continued(
            command("fix", f"put{name} {_GROUP} insert/pack seed {_SEEDS[2]}"),
            [
                f"distributiontemplate size{index + 1} insert_every once overlapcheck no",
                f"verbose no {' '.join(motions)} orientation constant",
                _numbers([scalar, x, y, z]),
                f"region at{name} particles_in_region 1 ntry_mc 1001",
            ],
        )

    def surplus(self) -> str:
        """Return the file that marks the clumps whose centre is above a height."""
        weights, lines = self._weights(), []
        for number in range(self.count):
            first = self.glued + number * self.each + 1
            last = first + self.each - 1
            places = (f"{w!r}*z[{n}]" for n, w in enumerate(weights.tolist(), first))
            lines += [
                command("variable", f"above equal ({'+'.join(places)})>${{height}}"),
                f'if "${{above}}" then "set atom {first}*{last} property/atom delflag 1.0"',
            ]
        return "\n".join([*lines, ""])

    def _weights(self) -> NDArray[np.float64]:
        """Return the weights with which the centres of the spheres add up to that of the clump."""
        # Spheres on a line or in a plane have the centre there, too: there always is a solution.
        sums = np.vstack((self.spheres.clump.positions.T, np.ones(self.each)))
        found: NDArray[np.float64] = np.linalg.lstsq(sums, np.array([0.0, 0.0, 0.0, 1.0]))[0]
        return found

    # --- commands ------------------------------------------------------------------------------

    def define(self) -> Iterator[str]:
        """Iterate over the commands that insert the clumps."""
        yield heading("clumps: one template for each diameter")
        yield command("group", f"{_GROUP} subtract all all")
        density = self.scene.material["particle.density"]
        for index in range(len(self.spheres.diameters)):
            yield from _template(card_clump(self.spheres, index, density), index + 1)
        yield "# fix multisphere has the last word on clumps: this moves only what is left"
        yield "# of one, when a sphere of it has left the box, and lets it follow."
        yield command("fix", f"remains {_GROUP} nve/sphere")
        # Without the option, nothing can be removed by a strike-off.
        yield command("fix", f"bodies {_GROUP} multisphere allow_group_and_set yes")
        yield f"# Time steps of no duration; then the clumps of {INSERTION} are where they should."
        yield command("timestep", f"{_NO_TIME}")
        yield command("include", INSERTION)
        yield command("reset_timestep", "0")
        expected = self.glued + self.count * self.each
        yield command("variable", "inserted equal atoms")
        # LIGGGHTS ends well after quit; refusing its argument, it fails, as it is meant to.
        message = f"ERROR: only ${{inserted}} of {expected} spheres found a place"
        yield command("if", f"\"${{inserted}} != {expected}\" then 'print \"{message}\"' 'quit 1'")

    def integration(self, loose: str) -> Iterator[str]:
        """Iterate over gravity, the energies, and the masses of spheres."""
        gravity = f"gravity {loose} gravity {self.scene.gravity} vector 0.0 0.0 -1.0"
        yield command("fix", gravity)
        yield "# Of clumps, too, rotation does not count: one may spin on a point for ever."
        yield command("compute", "translation all ke/multisphere")
        yield "# What is left of a clump has no number any more."
        glued = "+gmask(glued)" if self.glued else ""
        yield command("compute", f"clump {loose} property/atom mol")
        yield command("variable", f"whole atom (c_clump>0){glued}")
        yield command("compute", f"whole {loose} reduce sum v_whole")
        yield "# Each sphere has the mass of its clump, for the dashpots; this is its share of it."
        clump, density = self.spheres.clump, self.scene.material["particle.density"]
        share = f"{4 / 3 * math.pi * density * clump.overlap_factor!r}*r*r*r"
        if self.glued:
            share = f"({share}*gmask({loose})+mass*gmask(glued))"
        yield command("variable", f"share atom {share}*v_whole")

    @staticmethod
    def strike_off(height: float) -> Iterator[str]:
        """Iterate over the commands that remove clumps whose centre is above a height."""
        yield command("variable", f"height equal {height}")
        yield command("include", SURPLUS)
        yield command("run", "0 post no")

    @staticmethod
    def mass_above(height: float, loose: str, name: str) -> Iterator[str]:
        """Iterate over the commands that define a variable: the mass above a height."""
        yield command("region", f"{name} block INF INF INF INF {height} INF units box")
        yield command("compute", f"{name} {loose} reduce/region {name} sum {SHARE}")
        yield command("variable", f"{name} equal c_{name}")

    @staticmethod
    def forget_mass_above(name: str) -> list[str]:
        """Return the commands that remove the helpers of a mass above a height."""
        return [command("uncompute", name), command("region", f"{name} delete")]


def _template(clump: CardClump, number: int) -> Iterator[str]:
    """Iterate over the commands that define the clumps of a diameter, by its number from 1."""
    x, y, z = clump.inertia
    density = clump.mass / (math.pi / 6 * clump.diameter**3)
    spheres = (f"{' '.join(map(repr, sphere))}" for sphere in clump.spheres)
    yield continued(
        command("fix", f"clump{number} {_GROUP} particletemplate/multisphere {_SEEDS[0]}"),
        [
            f"atom_type 1 density constant {density!r}",
            f"nspheres {len(clump.spheres)} ntry {_TRIES} spheres",
            *spheres,
            f"type {number} mass {clump.mass!r}",
            f"inertia_tensor {x!r} 0.0 0.0 {y!r} 0.0 {z!r} use_density",
        ],
    )
    first = f"size{number} {_GROUP} particledistribution/discrete {_SEEDS[1]}"
    yield command("fix", f"{first} 1 clump{number} 1.0")


def _numbers(values: NDArray[np.float64] | list[float] | None) -> str:
    return " ".join(repr(float(value)) for value in (np.zeros(3) if values is None else values))
