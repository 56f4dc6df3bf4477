"""Decks for LAMMPS and its relatives: what their script languages have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grainfit.scenes.conditions import AtRest, Clear, Condition, Drained, Elapsed, Loaded
from grainfit.scenes.film import FILM
from grainfit.scenes.records import (
    Force,
    KineticEnergy,
    MassAbove,
    RadialForce,
    Recorded,
    Series,
    Travel,
)
from grainfit.scenes.run_output import STAGES, STAGES_HEADER, series_file, snapshot_file
from grainfit.scenes.scene import Load, Motion, Scene, Stage, Wall, load_on
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.script_glued import COLUMN, LOOSE, GluedSets
from grainfit.solvers.dem.script_syntax import command, continued, heading

PARTICLES = "particles.data"
#: Name of the dump of the whole run: one that no snapshot of a scene has.
_FILM_DUMP = "film.of.run"
#: Region and variable of the mass that a stage waits for to drain.
UNDRAINED = "undrained"
_AXES = {"x": 0, "y": 1, "z": 2}


def _recorded(column: str) -> str:
    """Return the name of a column's variable, apart from the variables of decks themselves."""
    return f"record_{column}"


class ScriptDeck(SceneDeck):
    """A scene as a script that LAMMPS or one of its relatives reads.

    Parameters
    ----------
    scene : Scene
        The scene to translate.
    folder : Path
        Folder of the run; everything that the solver reads is written there.
    """

    #: Arguments of ``set`` that take the angular velocity from particles.
    no_spin: ClassVar[str]
    #: What a run leaves out that goes on with the stage.
    without: str = "post no"
    #: Remarks in the first lines of a deck.
    introduction: ClassVar[tuple[str, ...]]

    def __init__(self, scene: Scene, folder: Path) -> None:
        super().__init__(scene, folder)
        #: Walls that are there, by name.
        self.walls: dict[str, Wall] = {}
        #: Commands that remove the helpers of records at the end of a stage: the next stage may
        #: record the same quantities, or take away the wall that they look at.
        self.undo: list[str] = []
        #: Computes that sum quantities of the particles at a wall, by wall: they stay from stage to
        #: stage, and go with the wall.
        self._sums: dict[str, list[str]] = {}
        #: Travels that walls begin with, m or rad; 0 for those without.
        self.travels: Mapping[str, str] = {}
        self._glued = GluedSets(scene, self.follow, self.hold, self.no_spin, self.loose_spheres)
        #: Group of the particles that move, are counted, and touch walls.
        self.loose = LOOSE if scene.glued else "all"

    def text(self) -> str:
        """Return the deck; write other files that it reads."""
        return "\n".join(self.lines()) + "\n"

    def lines(self) -> Iterator[str]:
        """Iterate over the lines of the deck."""
        yield f"# {self.scene.title}, for {self.introduction[0]}. SI units."
        yield from (f"# {line}" for line in self.introduction[1:])
        yield ""
        yield from self.head()
        yield from self.contacts()
        if self.scene.glued:
            yield heading("glued sets")
            yield from self._glued.define()
        yield heading("walls")
        yield from self.first_walls()
        yield heading("motion, and what is looked at")
        yield from self.motion()
        yield command("print", f'"{STAGES_HEADER}" file {STAGES}')
        yield from self.film_run()
        for stage in self.scene.stages:
            yield from self.stage(stage)
        yield command("jump", "SELF end")
        yield from self.ends()

    def read_particles(self) -> str:
        """Return the command that reads the particles."""
        return command("read_data", PARTICLES)

    # --- what solvers write differently --------------------------------------------------------

    @abstractmethod
    def head(self) -> Iterator[str]:
        """Iterate over the settings of the simulation."""

    @abstractmethod
    def contacts(self) -> Iterator[str]:
        """Iterate over the contact law."""

    @abstractmethod
    def first_walls(self) -> Iterator[str]:
        """Iterate over the walls of the beginning."""

    @abstractmethod
    def change_walls(self, stage: Stage) -> Iterator[str]:
        """Take away and put walls at the beginning of a stage."""

    @abstractmethod
    def snapshot(self, name: str) -> Iterator[str]:
        """Write the particles into a file."""

    @abstractmethod
    def start_motion(self, wall: str, motion: Motion) -> Iterator[str]:
        """Start a motion of a wall; its variable ``{wall}_travel`` must follow it."""

    @abstractmethod
    def stop_motion(self, wall: str, motion: Motion) -> Iterator[str]:
        """Stop a motion of a wall where it is."""

    @abstractmethod
    def record_force(self, wall: str, along: str, name: str) -> Iterator[str]:
        """Define a variable: the force of the particles on a wall along an axis."""

    @abstractmethod
    def record_radial_force(self, wall: str, name: str) -> Iterator[str]:
        """Define a variable: the force of the particles on a wall away from the z axis."""

    @abstractmethod
    def particle_types(self) -> tuple[int, list[int]]:
        """Return the number of types, and the type of every particle, loose and glued."""

    def between_particles(self, sliding_friction: float | None = None) -> Iterator[str]:
        """Iterate over the contact law between particles, with another sliding friction."""
        raise NotImplementedError("scenes with the friction of a stage are refused before")

    # --- particles -----------------------------------------------------------------------------

    def write_particles(self) -> None:
        """Write the particles of the beginning."""
        scene = self.scene
        low, high = scene.box.low, scene.box.high
        types, kinds = self.particle_types()
        header = (
            f"Random column of particles: id type diameter density x y z\n\n"
            f"{len(kinds)} atoms\n{types} atom types\n\n"
            f"{low[0]!r} {high[0]!r} xlo xhi\n{low[1]!r} {high[1]!r} ylo yhi\n"
            f"{low[2]!r} {high[2]!r} zlo zhi\n\nAtoms\n"
        )
        diameters = np.array(scene.sizes.diameters)[self.size_indices].tolist()
        positions = [scene.particles.positions, *(g.positions for g in scene.glued.values())]
        density = scene.material["particle.density"]
        rows = (
            f"{number} {kind} {diameter!r} {density!r} {x:.12g} {y:.12g} {z:.12g}"
            for number, (kind, diameter, (x, y, z)) in enumerate(
                zip(kinds, diameters, np.vstack(positions).tolist(), strict=True), 1
            )
        )
        text = header + "\n" + "\n".join(rows) + "\n" + self._velocities()
        (self.folder / PARTICLES).write_text(text, encoding="ascii")

    @property
    def loose_spheres(self) -> int:
        """Number of spheres of loose particles: the first glued one has the next number."""
        return len(self.scene.particles.size_indices)

    @property
    def size_indices(self) -> NDArray[np.int64]:
        """Index of every particle's diameter, loose ones before glued ones."""
        glued = (body.size_indices for body in self.scene.glued.values())
        return np.concatenate([self.scene.particles.size_indices, *glued])

    def _velocities(self) -> str:
        """Return the section of the particles' velocities, with no spin; empty at rest."""
        velocities = self.scene.particles.velocities
        if velocities is None:
            return ""
        glued = len(self.size_indices) - len(velocities)
        velocities = np.vstack([velocities, np.zeros((glued, 3))])
        rows = (
            f"{number} {x!r} {y!r} {z!r} 0 0 0"
            for number, (x, y, z) in enumerate(velocities.tolist(), 1)
        )
        return "\nVelocities\n\n" + "\n".join(rows) + "\n"

    # --- settings ------------------------------------------------------------------------------

    @property
    def kinetic(self) -> str:
        """Expression of the kinetic energy of the loose particles."""
        return f"ke({self.loose})" if self.scene.glued else "ke"

    @property
    def count(self) -> str:
        """Expression of the number of loose particles."""
        return f"count({self.loose})" if self.scene.glued else "atoms"

    @property
    def shown_energy(self) -> str:
        """Keyword of the kinetic energy in the log."""
        return "ke"

    @property
    def snapshot_columns(self) -> str:
        """Columns of a snapshot; where there are glued sets, the last is 0 for loose particles."""
        columns = "id type x y z radius mass"
        return f"{columns} {COLUMN}" if self.scene.glued else columns

    @property
    def snapshot_filter(self) -> str:
        """Further arguments of ``dump_modify`` that leave out what is no particle."""
        return ""

    @property
    def largest_radius(self) -> float:
        """Radius of the largest sphere, m."""
        return max(self.scene.sizes.diameters) / 2

    def boundary(self) -> str:
        """Return the arguments of ``boundary``."""
        return " ".join("p" if axis in self.scene.box.periodic else "f" for axis in "xyz")

    def integration(self) -> Iterator[str]:
        """Iterate over gravity and the integration of the loose particles."""
        gravity = f"gravity {self.loose} gravity {self.scene.gravity} vector 0.0 0.0 -1.0"
        yield command("fix", gravity)
        yield command("fix", f"motion {self.loose} nve/sphere")

    def motion(self) -> Iterator[str]:
        """Iterate over gravity, integration, and the variables that stages look at."""
        scene = self.scene
        yield from self.integration()
        yield command("timestep", f"{scene.time_step}")
        yield ""
        yield command("variable", f"kinetic equal {self.kinetic}")
        yield command("variable", "now equal step")
        yield command("variable", "elapsed equal step*dt")
        yield command("variable", f"remaining equal {self.count}")
        yield from self.log_columns(self.shown_energy)
        yield command("thermo", f"{scene.steps(scene.check_interval)}")

    @staticmethod
    def log_columns(shown: str) -> Iterator[str]:
        """Have keywords in the log, beside steps and times."""
        yield command("thermo_style", f"custom step atoms time {shown} cpu")
        yield command("thermo_modify", "lost ignore norm no")

    # --- stages --------------------------------------------------------------------------------

    def stage(self, stage: Stage) -> Iterator[str]:
        """Iterate over the commands of a stage."""
        yield heading(f"{stage.name}: {stage.remark}" if stage.remark else stage.name)
        yield command("variable", f"stage string {stage.name}")
        if stage.sliding_friction is not None:
            yield from self.between_particles(stage.sliding_friction)
        if stage.strike_off is not None:
            yield from self.strike_off(stage.strike_off)
        yield from self.change_walls(stage)
        yield command("variable", "start equal ${now}")
        yield from self.start_motions(stage)
        yield from self.record(stage)
        if stage.is_closed:
            yield command("variable", "expected equal ${remaining}")
        yield from self.before(stage)
        yield from self.until(stage)

    def until(self, stage: Stage) -> Iterator[str]:
        """Iterate over the commands of a stage from its first look on."""
        yield from self._looks(stage)
        if stage.series is not None:
            yield command("unfix", "series")
        if stage.frames is not None:
            yield command("undump", stage.frames.name)
        yield from self._stop_motions(stage)
        if stage.sliding_friction is not None:
            yield from self.between_particles()
        yield from self.undo
        self.undo = []
        yield self._note_end(stage.name, self._end_of(stage))
        if stage.snapshot:
            yield from self.snapshot(stage.snapshot)

    def strike_off(self, height: float) -> Iterator[str]:
        """Remove the loose particles whose centre is above a height."""
        yield command("region", f"above block INF INF INF INF {height} INF units box")
        yield command("group", "surplus region above")
        if self.scene.glued:
            yield command("group", "surplus subtract surplus glued")
        yield command("delete_atoms", "group surplus compress no")
        yield command("group", "surplus delete")
        yield command("region", "above delete")

    def start_motions(self, stage: Stage) -> Iterator[str]:
        """Start the motions of a stage."""
        yield from self._glued.stop_moved(stage)
        for name in stage.motions:
            if name in self.scene.glued:
                yield from self._glued.start_motion(name, stage.motions_of(name))
            else:
                yield from self.start_motion(name, stage.motions_of(name)[0])

    def _stop_motions(self, stage: Stage) -> Iterator[str]:
        for name in stage.motions:
            if name in self.scene.glued:
                yield from self._glued.stop_motion(name, stage.motions_of(name))
            else:
                yield from self.stop_motion(name, stage.motions_of(name)[0])

    def _looks(self, stage: Stage) -> Iterator[str]:
        """Iterate over the looks at a stage, and the runs between them."""
        scene, until, name = self.scene, stage.until, stage.name
        if isinstance(until, Elapsed):
            yield from self._look()
            if stage.is_closed:
                yield self._jump("${count} < ${expected}", "broken")
            yield self._jump(f"${{energy}} > {scene.energy_limit}", "unstable")
            return
        yield command("label", name)
        yield from self._look()
        if stage.is_closed:
            yield self._jump("${count} < ${expected}", "broken")
        yield self._jump(f"${{energy}} > {scene.energy_limit}", "unstable")
        yield from self._conditions(until, name)
        yield command("variable", "since equal ${passed}-${start}")
        late = f"{name}_done" if isinstance(until, Clear) else "restless"
        if isinstance(until, Loaded):
            late = "unloaded"
        yield self._jump(f"${{since}} >= {scene.steps(until.limit)}", late)
        yield from self.steps(stage, scene.steps(scene.check_interval), self.without)
        yield command("jump", f"SELF {name}")
        yield command("label", f"{name}_done")

    def before(self, stage: Stage) -> Iterator[str]:
        """Iterate over the commands before the first look."""
        scene, until = self.scene, stage.until
        if isinstance(until, Elapsed):
            yield from self.steps(stage, scene.steps(until.time))
            return
        yield from self.looked_at(until)
        if isinstance(until, AtRest | Drained):
            # Particles that have not begun to fall are not at rest.
            first = scene.check_interval if stage is scene.stages[0] else 0.0
            if max(until.at_least, first) > 0:
                yield from self.steps(stage, scene.steps(max(until.at_least, first)))
            return
        yield from self.steps(stage, scene.steps(scene.check_interval))

    def looked_at(self, until: Condition, near: str = "0") -> Iterator[str]:
        """Define the variables that looks of a stage need beside those of all stages.

        Whether the load was reached at the last look is ``near``.
        """
        if isinstance(until, Clear):
            yield command("variable", f"highest equal bound({self.loose},zmax)")
        elif isinstance(until, Loaded):
            yield command("variable", f"near equal {near}")
        elif isinstance(until, Drained):
            yield from self.record_mass_above(until.height, UNDRAINED)

    def steps(self, stage: Stage, number: int, without: str = "post no") -> Iterator[str]:  # noqa: ARG002
        """Simulate time steps of a stage."""
        yield command("run", f"{number} {without}")

    def _look(self) -> Iterator[str]:
        yield command("variable", "energy equal ${kinetic}")
        yield command("variable", "passed equal ${now}")
        yield command("variable", "count equal ${remaining}")

    def _conditions(self, until: AtRest | Clear | Loaded | Drained, name: str) -> Iterator[str]:
        """Iterate over the conditions that end a stage well."""
        rest = f"${{energy}} < {self.scene.energy_at_rest}"
        if isinstance(until, AtRest):
            yield self._jump(rest, f"{name}_done")
        elif isinstance(until, Drained):
            left = until.left(self.scene.mass)
            yield self._jump(f"(${{{UNDRAINED}}} <= {left}) || ({rest})", f"{name}_done")
        elif isinstance(until, Clear):
            bottom = self.scene.all_walls()[until.wall].shape.bottom  # type: ignore[union-attr]
            radius = self.largest_radius
            yield command("variable", f"top equal ${{highest}}+{radius}")
            yield command("variable", f"below equal {bottom}+${{{until.wall}_travel}}")
            yield self._jump(f"({rest}) && (${{top}} < ${{below}})", f"{name}_done")
        else:
            load = self._load_on(until.wall, name)
            times = f"*${{{until.wall}_stretch}}" if load.across else ""
            most = f"{until.within * abs(load.force)}{times}"
            yield command("variable", "before equal ${near}")
            yield command(
                "variable",
                f"near equal abs(${{{until.wall}_force}}-({-load.force}){times})<{most}",
            )
            held = "(${near} > 0.5) && (${before} > 0.5)"
            yield self._jump(f"{held} && ({rest})", f"{name}_done")

    def _load_on(self, wall: str, stage: str) -> Load:
        load = load_on(next(s for s in self.scene.stages if s.name == stage), wall)
        assert load is not None, "scenes refuse to wait for a load that is not there"
        return load

    @staticmethod
    def _jump(condition: str, label: str) -> str:
        return command("if", f'"{condition}" then "jump SELF {label}"')

    @staticmethod
    def _end_of(stage: Stage) -> str:
        return "at_rest" if isinstance(stage.until, AtRest) else "done"

    @staticmethod
    def _note_end(name: str, end: str) -> str:
        row = f"{name},{end},${{passed}},${{elapsed}},${{count}},${{energy}}"
        return command("print", f'"{row}" append {STAGES}')

    def ends(self) -> Iterator[str]:
        """Iterate over what is written when a run goes wrong."""
        yield heading("what went wrong")
        for end in ("restless", "unloaded", "broken", "unstable"):
            yield command("label", end)
            yield self._note_end("${stage}", end)
            yield command("jump", "SELF end")
        yield command("label", "end")

    # --- motions -------------------------------------------------------------------------------

    @staticmethod
    def follow(wall: str, speed: float) -> Iterator[str]:
        """Let the variable of a wall's travel grow with its speed from the stage's start on."""
        yield command("variable", f"{wall}_from equal ${{{wall}_travel}}")
        path = f"${{{wall}_from}}+({speed})*(step-${{start}})*dt"
        yield command("variable", f"{wall}_travel equal {path}")

    @staticmethod
    def hold(wall: str) -> Iterator[str]:
        """Let the variable of a wall's travel stay as it is."""
        yield command("variable", f"{wall}_to equal ${{{wall}_travel}}")
        yield command("variable", f"{wall}_travel equal ${{{wall}_to}}")

    # --- records -------------------------------------------------------------------------------

    def record(self, stage: Stage, *, more: bool = False) -> Iterator[str]:
        """Record the series and the frames of a stage; append ``more`` to those that are there."""
        if stage.series is not None:
            yield from self._record(stage, stage.series, more=more)
        if stage.frames is not None:
            name = stage.frames.name
            yield from self._dump(name, snapshot_file(name), stage.frames.every, more=more)

    def _record(self, stage: Stage, series: Series, *, more: bool) -> Iterator[str]:
        """Define the variables of a stage's series, and record them."""
        columns = series.columns
        for name, quantity in columns.items():
            yield from self._quantity(quantity, _recorded(name))
        row = ",".join(f"${{{name}}}" for name in ("elapsed", *map(_recorded, columns)))
        title = ",".join(("time", *columns))
        every = self.scene.steps(series.every)
        path = series_file(stage.name)
        file = f'append {path} title ""' if more else f'file {path} title "{title}"'
        yield continued(
            command("fix", f"series all print {every}"), [f'"{row}"', f"{file} screen no"]
        )

    def film_run(self, *, more: bool = False) -> Iterator[str]:
        """Write the frames of the whole run."""
        if self.scene.film_interval is not None:
            yield heading("frames of all stages")
            yield from self._dump(_FILM_DUMP, FILM, self.scene.film_interval, more=more)

    def _dump(self, name: str, file: str, every: float, *, more: bool) -> Iterator[str]:
        """Write the particles into one file from now on, at an interval in s."""
        steps, appended = self.scene.steps(every), " append yes" if more else ""
        yield command("dump", f"{name} all custom {steps} {file} {self.snapshot_columns}")
        yield command("dump_modify", f"{name} sort id{self.snapshot_filter}{appended}")

    def _quantity(self, quantity: Recorded, name: str) -> Iterator[str]:
        """Define the variable of a recorded quantity."""
        if isinstance(quantity, Force) and quantity.wall in self.scene.glued:
            force = self._glued.force(quantity.wall, quantity.along)
            yield command("variable", f"{name} equal {force}")
        elif isinstance(quantity, Travel) and quantity.wall in self.scene.glued:
            travel = self._glued.travel(quantity.wall, quantity.along)
            yield command("variable", f"{name} equal {travel}")
        elif isinstance(quantity, Force):
            yield from self.record_force(quantity.wall, quantity.along, name)
        elif isinstance(quantity, RadialForce):
            yield from self.record_radial_force(quantity.wall, name)
        elif isinstance(quantity, Travel):
            yield command("variable", f"{name} equal v_{quantity.wall}_travel")
        elif isinstance(quantity, MassAbove):
            yield from self.record_mass_above(quantity.height, name)
        elif isinstance(quantity, KineticEnergy):
            yield command("variable", f"{name} equal {self.kinetic}")

    def record_mass_above(self, height: float, name: str) -> Iterator[str]:
        """Define a variable: the mass of the loose particles above a height."""
        yield command("region", f"{name} block INF INF INF INF {height} INF units box")
        yield command("variable", f"{name} equal mass({self.loose},{name})")
        self.undo.append(command("region", f"{name} delete"))

    def is_new_sum(self, wall: str, sum_: str) -> bool:
        """Note a sum of forces on a wall; return whether no earlier stage has defined it."""
        known = self._sums.setdefault(wall, [])
        if sum_ in known:
            return False
        known.append(sum_)
        return True

    def forget_sums(self, wall: str) -> Iterator[str]:
        """Delete the sums of a wall: a compute of a fix that is gone would stop the next run."""
        yield from (command("uncompute", sum_) for sum_ in self._sums.pop(wall, []))

    def measured_walls(self) -> set[str]:
        """Return the walls whose force is recorded or wanted."""
        found = {
            wall
            for stage in self.scene.stages
            for wall, motion in stage.all_motions()
            if isinstance(motion, Load)
        }
        for stage in self.scene.stages:
            columns: Mapping[str, Recorded] = {} if stage.series is None else stage.series.columns
            found |= {q.wall for q in columns.values() if isinstance(q, Force | RadialForce)}
        return found

    def moving_walls(self) -> dict[str, Motion]:
        """Return the last motion of each moving wall: all are along or about one axis."""
        return {wall: motion for stage in self.scene.stages for wall, motion in stage.all_motions()}

    def is_loaded(self, wall: str) -> bool:
        """Return whether a wall is under a load in some stage."""
        return any(isinstance(motion, Load) for motion in self.scene.motions_of(wall))

    @staticmethod
    def component(along: str) -> int:
        """Return the number of an axis, from 0."""
        return _AXES[along]
