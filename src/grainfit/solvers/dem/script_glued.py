"""Glued sets in decks for LAMMPS and its relatives: a group of particles that ``fix move`` moves.

Only loose particles are integrated, so a set stands still unless it is moved. A load is a servo:
the more force is missing, the faster. The travel under it is the running mean of that speed times
the time, which both LAMMPS and LIGGGHTS have (``fix ave/time``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from grainfit.scenes.records import Force, Travel
from grainfit.scenes.scene import Load, Motion, Rotation, Scene, Stage
from grainfit.solvers.dem.script_syntax import command

#: Group of all particles that are not glued, and column of a dump with the number of the set.
LOOSE, COLUMN = "loose", "v_glued"


class GluedSets:
    """Commands of a deck for the glued sets of a scene.

    Parameters
    ----------
    scene : Scene
        A scene with glued sets.
    follow, hold : callable
        Commands that let the variable ``NAME_travel`` grow with a speed, and stay as it is.
    no_spin : str
        Arguments of ``set`` that take the angular velocity from particles.
    loose : int
        Number of spheres of loose particles, which have the first numbers.
    """

    def __init__(
        self,
        scene: Scene,
        follow: Callable[[str, float], Iterator[str]],
        hold: Callable[[str], Iterator[str]],
        no_spin: str,
        loose: int,
    ) -> None:
        self._scene = scene
        self._follow = follow
        self._hold = hold
        self._no_spin = no_spin
        self._loose = loose
        #: Sets that moved in the last stage: they keep their velocity until it is set to zero.
        self._moved: list[str] = []

    def define(self) -> Iterator[str]:
        """Define groups, and variables of forces and travels."""
        first = self._loose + 1
        for name, body in self._scene.glued.items():
            last = first + len(body.size_indices) - 1
            yield command("group", f"{name} id {first}:{last}")
            first = last + 1
        names = " ".join(self._scene.glued)
        yield command("group", f"glued union {names}")
        yield command("group", f"{LOOSE} subtract all glued")
        yield command("neigh_modify", "exclude group glued glued")
        numbers = [f"{n}*gmask({name})" for n, name in enumerate(self._scene.glued, 1)]
        yield command("variable", f"glued atom {'+'.join(numbers)}")
        yield command("variable", "still equal 0.0")
        for name in self._scene.glued:
            for axis in self._axes(name, Force):
                yield command("compute", f"{name}_{axis} {name} reduce sum f{axis}")
            for axis in self._axes(name, Travel):
                yield command("variable", f"{name}_{axis}_travel equal 0.0")

    def _axes(self, name: str, kind: type[Force] | type[Travel]) -> list[str]:
        """Return the axes along which a set moves, or a quantity of it is recorded."""
        moved = [
            motion.along
            for motion in self._scene.motions_of(name)
            if kind is Travel or isinstance(motion, Load)
        ]
        series = [stage.series for stage in self._scene.stages if stage.series is not None]
        quantities = [q for one in series for q in one.columns.values()]
        recorded = [q.along for q in quantities if isinstance(q, kind) and q.wall == name]
        return list(dict.fromkeys([*moved, *recorded]))

    def stop_moved(self, stage: Stage) -> Iterator[str]:
        """Stop the sets of the last stage that do not move in this one."""
        for name in self._moved:
            if name not in stage.motions:
                yield command("velocity", f"{name} set 0.0 0.0 0.0")
                if any(isinstance(m, Rotation) for m in self._scene.motions_of(name)):
                    yield command("set", f"group {name} {self._no_spin}")
        self._moved = [name for name in stage.motions if name in self._scene.glued]

    def start_motion(self, name: str, motions: Sequence[Motion]) -> Iterator[str]:
        """Start the motions of a set in a stage."""
        if isinstance(motions[0], Rotation):
            yield from self._turn(name, motions[0])
            return
        ways, speeds = dict.fromkeys("xyz", "v_still"), dict.fromkeys("xyz", "v_still")
        for motion in motions:
            body = f"{name}_{motion.along}"
            if isinstance(motion, Load):
                yield from self._servo(name, motion)
            else:
                yield command("variable", f"{body}_speed equal {motion.speed}")
                yield command("variable", f"{body}_way equal {motion.speed}*(step-${{start}})*dt")
                yield from self._follow(body, motion.speed)
            ways[motion.along], speeds[motion.along] = f"v_{body}_way", f"v_{body}_speed"
        paths = " ".join([*ways.values(), *speeds.values()])
        yield command("fix", f"{name}_motion {name} move variable {paths}")

    def _turn(self, name: str, rotation: Rotation) -> Iterator[str]:
        """Start a rotation of a set, which moves in no other way."""
        axis = [0.0, 0.0, 0.0]
        axis["xyz".index(rotation.along)] = math.copysign(1.0, rotation.speed)
        numbers = [*rotation.through, *axis, 2 * math.pi / abs(rotation.speed)]
        path = " ".join(str(value) for value in numbers)
        yield command("fix", f"{name}_motion {name} move rotate {path}")
        yield from self._follow(f"{name}_{rotation.along}", rotation.speed)

    def _servo(self, name: str, load: Load) -> Iterator[str]:
        """Define speed and travel of a set under a load."""
        body = f"{name}_{load.along}"
        yield f"# The more force is missing, the faster; at most {load.largest_speed} m/s."
        yield command("variable", f"{name}_force equal c_{body}")
        share = load.gain / load.largest_speed
        yield command("variable", f"{body}_lack equal {share}*({load.force}+c_{body})")
        lack = f"v_{body}_lack"
        speed = f"{load.largest_speed}*{lack}/sqrt(1.0+{lack}*{lack})"
        yield command("variable", f"{body}_speed equal {speed}")
        yield command("fix", f"{body}_mean all ave/time 1 1 1 v_{body}_speed ave running")
        yield command("variable", f"{body}_way equal f_{body}_mean*(step-${{start}})*dt")
        yield command("variable", f"{body}_from equal ${{{body}_travel}}")
        yield command("variable", f"{body}_travel equal ${{{body}_from}}+v_{body}_way")

    def stop_motion(self, name: str, motions: Sequence[Motion]) -> Iterator[str]:
        """Stop the motions of a set at the end of a stage."""
        for motion in motions:
            body = f"{name}_{motion.along}"
            yield from self._hold(body)
            if isinstance(motion, Load):
                yield command("unfix", f"{body}_mean")
        yield command("unfix", f"{name}_motion")

    @staticmethod
    def force(name: str, along: str) -> str:
        """Return the expression of the force of the loose particles on a set."""
        return f"c_{name}_{along}"

    @staticmethod
    def travel(name: str, along: str) -> str:
        """Return the expression of the distance that a set has moved."""
        return f"v_{name}_{along}_travel"
