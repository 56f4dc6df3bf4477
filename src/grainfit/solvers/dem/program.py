"""Run the deck of a bulk test with a DEM program."""

from __future__ import annotations

import math
import re
import shlex
import shutil
import subprocess
import tempfile
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property, lru_cache
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar, Self

from typing_extensions import override

from grainfit import platforms
from grainfit.bulk_tests.abilities import material_faults, user_functions, worse_ends
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.conditions import conditions_of
from grainfit.bulk_tests.outline import concepts
from grainfit.bulk_tests.response_info import absent_responses
from grainfit.bulk_tests.time_steps import with_safe_time_step
from grainfit.bulk_tests.workload import workload
from grainfit.contact_models.cohesive_contacts import overlap_faults
from grainfit.contact_models.registry import (
    COHESION,
    MATERIAL_PARAMETERS,
    contact_law,
    contact_law_faults,
    default_values,
    inactive_faults,
    inactive_parameters,
    is_load_dependent,
    material_parameter,
    non_default_models,
    parameters_of_walls,
    simulated_material,
    size_faults,
    unfit_faults,
    with_defaults,
)
from grainfit.errors import (
    Fault,
    InputError,
    NotMeasurableError,
    RunFailedError,
    SolverNotFoundError,
)
from grainfit.evaluation import Measured
from grainfit.files import log_tail, text_of
from grainfit.formatting import in_a_row
from grainfit.ground_messages import NOT_ACCEPTED
from grainfit.materials.particle_shape import ASPECT_RATIO, aspect_ratio_faults
from grainfit.materials.walls import plain_name, wall_of
from grainfit.messages import Message
from grainfit.one_line import shortened
from grainfit.scenes.film import filmed
from grainfit.scenes.run_output import SNAPSHOTS, RunOutput
from grainfit.scenes.scene import Scene
from grainfit.solvers.base import Solver, Workspace
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.deck import SceneDeck
from grainfit.solvers.dem.parts import PartsOnWalls
from grainfit.solvers.dem.restarting_deck import RestartingDeck
from grainfit.solvers.dem.restarts import (
    IS_READ,
    clear,
    join_series,
    note,
    saved_states,
    steps_between,
)
from grainfit.solvers.dem.sphere_types import is_one_size
from grainfit.solvers.process.process import LOG_NAME, recorded_faults, run_process
from grainfit.solvers.run_cost import RunCost
from grainfit.units import UnitError, to_unit
from grainfit.validation import as_number, kind_faults, mapping_faults, plain, whole_number_faults

_HELP_SECONDS = 60.0
#: A run that takes this much longer than estimated hangs, even on a slow and busy machine, s.
_LEAST_TIMEOUT = 600.0
_PATIENCE = 100.0


class DeckSolver(Solver):
    """Base class of the DEM programs.

    Parameters
    ----------
    test : BulkTest
        The test that is simulated.
    material : mapping of str to float or str
        Fixed material parameters by dotted name.
    ranks : int
        MPI ranks of one run. Several runs at once use a machine better than several ranks.
    executable : str, optional
        The program, if it is not found by its usual name. `check` does not start it, because it may
        be named in a calibration file from somebody else.
    contact_models : iterable of str
        Contact models that replace the usual ones of their kind, such as ``"epsd2"``.
    walls : mapping of str to str, optional
        Walls with a name, by the parts of the test that are made of them, such as
        ``{"plate": "steel"}``; the other parts are of the plain wall.

    Raises
    ------
    InputError
        A parameter is unknown, physically impossible, or belongs to a contact model that the solver
        does not have, the test means nothing with the material, it has no such part, or the number
        of ranks is below one.
    """

    #: Name of the program for people, its usual name on the search path, and how to install it.
    title: ClassVar[str]
    usual_name: ClassVar[str]
    install: ClassVar[str]
    #: Option that makes it tell its version, and the version in its output.
    version_option: ClassVar[str] = "-h"
    version_pattern: ClassVar[str]
    #: Log that the program itself writes into the run folder.
    _own_log: ClassVar[str] = LOG_NAME
    #: Beginning of a line with an error message of the program.
    _error: ClassVar[re.Pattern[str]] = re.compile("ERROR")
    #: Translator of scenes into its decks.
    deck: ClassVar[type[SceneDeck]]
    #: Translator into decks that write restart files; None if runs cannot be continued.
    restarting: ClassVar[type[RestartingDeck] | None] = None
    #: Concepts of scenes that it does not have, with the reason and what to use instead.
    missing: ClassVar[Mapping[str, str]] = {}
    #: Material parameters that can only be 0, because it has nothing of the kind.
    absent_parameters: ClassVar[tuple[str, ...]] = ()

    def __init__(
        self,
        test: BulkTest,
        material: Mapping[str, float | str],
        ranks: int = 1,
        executable: str | None = None,
        contact_models: Iterable[str] = (),
        walls: Mapping[str, str] | None = None,
    ) -> None:
        ranks = plain(ranks)
        walls = {} if walls is None else walls
        InputError.raise_for(_faults_of_kinds(test, material, ranks, executable, walls))
        named = _names(contact_models)
        if (refusal := self._ranks_refusal(test, ranks)) is not None:
            raise InputError(refusal.fault("ranks", ranks=ranks))
        self.test = test
        self._parts = PartsOnWalls(test, walls)
        self.material = _in_si(material)
        self.contact_models = non_default_models(named)
        shape = test.sizes.shape
        if shape is not None and shape.aspect_ratio is not None:
            self.material.setdefault(ASPECT_RATIO, shape.aspect_ratio)
        self._require_possible(self.material)
        law = contact_law(self.material, self.contact_models)
        one_size = is_one_size(test.sizes)
        InputError.raise_for(
            [
                *self._material_faults(self.material),
                *inactive_faults(self.material, named),
                *size_faults(law, self.name, is_one_size=one_size),
            ]
        )
        #: The test as it was given: without a time step, intervals may need a shorter one.
        self._given_test = test
        self.test = self._safe({})
        self.ranks = ranks
        self.executable = executable
        #: Frames that a run is to be shown with, and its simulated time if that is known. No part
        #: of the model: frames change nothing of a run.
        self._film: tuple[int, float | None] | None = None

    @classmethod
    def _ranks_refusal(cls, test: BulkTest, ranks: int) -> Message | None:  # noqa: ARG003
        """Return why the program does not run a test on that many ranks; None if it does."""
        return messages.TOO_FEW_RANKS if ranks < 1 else None

    @property
    @override
    def response_names(self) -> tuple[str, ...] | None:
        return self.test.response_names

    @property
    @override
    def bulk_test(self) -> BulkTest:
        return self.test

    @override
    def of_test(self, test: BulkTest) -> Self:
        return type(self)(
            test, self.material, self.ranks, self.executable, self.contact_models, self.walls
        )

    @override
    def within(self, intervals: Mapping[str, tuple[float, float]]) -> Self:
        """Return the solver with a time step that is safe in all of the intervals.

        One that was given stays; so does the usual one, if it is short enough.

        Raises
        ------
        InputError
            A parameter cannot have a value at an end of its interval.
        """
        own = {name: intervals[name] for name in self.depends_on(list(intervals))}
        known = {name: ends for name, ends in own.items() if material_parameter(name) is not None}
        for end in (0, 1):
            InputError.raise_for(_impossible({name: ends[end] for name, ends in known.items()}))
        test = self._safe(own)
        return self if test == self.test else self.of_test(test)

    def _safe(self, intervals: Mapping[str, tuple[float, float]]) -> BulkTest:
        """Return the test as it was given, with a safe time step unless it was given one."""
        test = self._given_test
        is_given = test.setup.is_given("time_step_fraction")
        return test if is_given else self._with_safe_step(test, intervals)

    def _with_safe_step(
        self, test: BulkTest, intervals: Mapping[str, tuple[float, float]]
    ) -> BulkTest:
        """Return a test with a time step that is safe, as far as the material is known."""
        fixed = {name: (value, value) for name, value in self.material.items()}
        try:
            return with_safe_time_step(test, {**fixed, **intervals}, self.contact_models)
        except KeyError:
            # A value is missing, which is said where it is needed.
            return test

    @property
    @override
    def absent(self) -> Mapping[str, str]:
        return absent_responses(self.test)

    @override
    def filming(self, frames: int, duration: float | None = None) -> Self:
        solver = copy(self)
        solver._film = (frames, duration)
        return solver

    @property
    @override
    def walls(self) -> Mapping[str, str]:
        return self._parts.walls

    @override
    def model(self) -> Mapping[str, Any]:
        """Return solver, version, ranks and test."""
        return self._model

    @cached_property
    def _model(self) -> Mapping[str, Any]:
        return {
            "solver": self.name,
            "version": self.version(),
            # Another number of ranks sums forces in another order, which gives another heap.
            "ranks": self.ranks,
            "test": self.test.definition(),
            # Without a choice, runs keep the identity that they had before there were any.
            **({"contact_models": list(self.contact_models)} if self.contact_models else {}),
            **({"walls": dict(sorted(self.walls.items()))} if self.walls else {}),
        }

    @property
    @override
    def defaults(self) -> Mapping[str, float]:
        return default_values(self._parts.named)

    @override
    def depends_on(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return the parameters of the particles, and of walls that a part is made of."""
        used = self._parts.used({*self.material, *names})
        return tuple(name for name in names if wall_of(name) in (None, *used))

    @override
    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return all material parameters, given the values of the free ones.

        Those of walls are those of the walls that a part of the test is made of.

        Raises
        ------
        InputError
            A name is not a material parameter, a value is missing or physically impossible, or it
            belongs to a contact model that the solver does not have.
        """
        given = {**self.material, **parameters}
        used = self._parts.used(given)
        values = with_defaults(given)
        self._require_possible(values)
        idle = inactive_parameters(self.contact_models)
        needed = [name for name in parameters_of_walls(used) if plain_name(name) not in idle]
        missing = [name for name in needed if name not in values]
        if missing:
            raise InputError([messages.NO_VALUE.fault(name) for name in missing])
        return {name: float(values[name]) for name in needed}

    def _require_possible(self, material: Mapping[str, float]) -> None:
        law_faults = contact_law_faults(material, self.name, self.contact_models)
        shape, ratio = self.test.sizes.shape, material.get(ASPECT_RATIO, 1.0)
        InputError.raise_for(
            [*_impossible(material), *law_faults, *aspect_ratio_faults(shape, ratio)]
        )

    @override
    def raw_output(self, folder: Path) -> Sequence[Path]:
        """Return the snapshots of the particles."""
        return sorted((folder / SNAPSHOTS).glob("*.dump"))

    @override
    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> Mapping[str, Measured]:
        material = self.run_parameters(parameters)
        for fault in self._material_faults(material):
            raise RunFailedError(str(fault))
        with recorded_faults(workspace):
            scene = self._filmed(self._scene(material, seed), material)
            every = steps_between(
                self.estimate_cost_of(self.test, self._parts.material_of_test(material))
            )
            run = self.simulate(scene, workspace, every)
            try:
                return self.test.measure(run)
            except NotMeasurableError as error:
                tail = log_tail(workspace.folder / self._own_log)
                raise RunFailedError(str(error), tail, kind="evaluation") from error

    def _filmed(self, scene: Scene, material: Mapping[str, float]) -> Scene:
        if self._film is None:
            return scene
        frames, duration = self._film
        expected = self.test.simulated_time(self._parts.material_of_test(material))
        return filmed(scene, frames, duration or expected)

    def simulate(
        self, scene: Scene, workspace: Workspace, restart_every: int | None = None
    ) -> RunOutput:
        """Translate a scene, run the program, and return the output.

        A program that can do so writes restart files, ``restart_every`` time steps apart, and
        continues from the one that it finds in the folder.

        Raises
        ------
        InputError
            The program lacks a concept of the scene.
        RunFailedError
            The program failed. Stages that ended badly are left to `RunOutput.require_complete`.
        """
        self._require_concepts(scene.concepts())
        if self.contact_models:
            scene = replace(scene, contact_models=self.contact_models)
        deck = self.deck(scene, workspace.folder)
        try:
            if restart_every is None:
                self._simulate(deck.write(), workspace)
            else:
                self._simulate_long(scene, workspace, restart_every)
        except RunFailedError as error:
            if not self._ended_empty(error, scene, deck):
                raise
        struck = [stage.name for stage in scene.stages if stage.strike_off is not None]
        return RunOutput(workspace.folder, len(scene.particles.size_indices), struck)

    def _simulate_long(self, scene: Scene, workspace: Workspace, every: int) -> None:
        """Run the program so that a run that is killed can be continued, if it can be."""
        folder, restarting = workspace.folder, self.restarting
        why = self._why_anew(scene.concepts())
        if restarting is None or why:
            note(folder, messages.NO_RESTARTS(why=why))
            self._simulate(self.deck(scene, folder).write(), workspace)
            return
        deck = restarting(scene, folder, every)
        states = saved_states(folder, scene)
        if states and deck.is_written():
            for saved in states:
                if self._continues(restarting(scene, folder, every, saved), workspace):
                    return
        elif states:
            note(folder, messages.OTHER_DECK())
        if states:
            clear(folder)
        self._simulate(deck.write(), workspace)

    def _continues(self, deck: RestartingDeck, workspace: Workspace) -> bool:
        """Continue a run; return False if its restart file cannot be used."""
        folder, saved = workspace.folder, deck.saved
        (folder / IS_READ).unlink(missing_ok=True)
        note(folder, messages.CONTINUED(step=saved.step, stage=saved.stage, file=saved.file))
        try:
            self._simulate(deck.write_continuation(), workspace)
            join_series(folder, saved)
            return True
        except RunFailedError as error:
            if (folder / IS_READ).exists() or error.kind != "simulation":
                raise
            reason = error.reason
        except (OSError, ValueError) as error:
            reason = str(error)
        note(folder, messages.UNUSABLE_RESTART(file=saved.file, reason=reason))
        return False

    @override
    def starts_anew(self, parameters: Mapping[str, float]) -> str:
        material = self._parts.material_of_test(self.run_parameters(parameters))
        if steps_between(self.estimate_cost_of(self.test, material)) is None:
            return ""
        return self._why_anew(concepts(self.test, material))

    def _why_anew(self, concepts: Iterable[str]) -> str:
        """Return why runs with these concepts start anew after a kill; empty if they go on."""
        if self.restarting is None:
            return messages.NO_RESTARTS_OF_SOLVER(solver=self.title)
        inexact = self.restarting.inexact
        what = [inexact[name] for name in sorted(concepts) if name in inexact]
        return messages.NO_RESTARTS_OF(solver=self.title, what=in_a_row(what)) if what else ""

    def _ended_empty(
        self,
        error: RunFailedError,  # noqa: ARG002
        scene: Scene,  # noqa: ARG002
        deck: SceneDeck,  # noqa: ARG002
    ) -> bool:
        """Return whether the program failed only because its box is empty, and the run is whole."""
        return False

    @override
    def interval_faults(self, intervals: Mapping[str, tuple[float, float]]) -> list[Fault]:
        """Return why the test means nothing with a material at an end of the intervals."""
        faults: list[Fault] = []
        worse = worse_ends(self.test)
        for ratio in intervals.get(ASPECT_RATIO, ()):
            faults += aspect_ratio_faults(self.test.sizes.shape, ratio)
        for end in (0, 1):
            values = {name: ends[worse.get(name, end)] for name, ends in intervals.items()}
            material = self._parts.material_of_test({**self.material, **values})
            faults += material_faults(self.test, material)
        # The most slender clumps have the smallest spheres.
        largest = {*COHESION, ASPECT_RATIO}
        softest = {name: ends[plain_name(name) in largest] for name, ends in intervals.items()}
        faults += self._cohesion_faults({**self.material, **softest})
        largest_values = {**self.material, **{name: ends[1] for name, ends in intervals.items()}}
        law = contact_law(largest_values, self.contact_models)
        faults += unfit_faults(law, largest_values, self.name)
        faults += self._time_step_faults(intervals)
        return list(dict.fromkeys(faults))

    def _time_step_faults(self, intervals: Mapping[str, tuple[float, float]]) -> list[Fault]:
        """Return why the time step is too long for linear springs, which no stress makes softer."""
        if is_load_dependent(self.contact_models):
            return []
        share = self.test.setup.time_step_fraction
        safe = self._with_safe_step(self.test, intervals).setup.time_step_fraction
        if share <= safe:
            return []
        return [messages.LONG_TIME_STEP.fault("time_step_fraction", share=share, safe=safe)]

    def _material_faults(self, material: Mapping[str, float]) -> Iterator[Fault]:
        """Iterate over why the test means nothing with a material."""
        yield from material_faults(self.test, self._parts.material_of_test(material))
        yield from self._cohesion_faults(material)

    def _cohesion_faults(self, material: Mapping[str, float]) -> list[Fault]:
        values, conditions = with_defaults(material), conditions_of(self.test)
        law = contact_law(values, self.contact_models)
        sizes, ratio = conditions.sizes.real, values.get(ASPECT_RATIO, 1.0)
        if law.cohesion is None or aspect_ratio_faults(sizes.shape, ratio):
            return []
        sizes = sizes.with_aspect_ratio(ratio)
        return overlap_faults(law, values, sizes.sphere_diameters, conditions.gravity)

    @classmethod
    def concept_faults(cls, type_of_test: str, concepts: Iterable[str]) -> list[Fault]:
        """Return why the program cannot simulate a test: concepts that it lacks, with its reasons.

        Parameters
        ----------
        type_of_test : str
            For the message.
        concepts : iterable of str
            Those of the test's scene, see `Scene.concepts`.
        """
        lacks = messages.LACKS_CONCEPT
        return [
            lacks.fault("solver", solver=cls.name, test=type_of_test, reason=cls.missing[name])
            for name in sorted(concepts)
            if name in cls.missing
        ]

    def _require_concepts(self, concepts: Iterable[str]) -> None:
        InputError.raise_for(self.concept_faults(self.test.type, concepts))

    def _simulate(self, deck: Path, workspace: Workspace) -> None:
        """Run the program; a failure has the error message of the program, if there is one."""
        own_log = workspace.folder / self._own_log
        try:
            command, variables = self._start(deck)
            run_process(command, workspace, variables)
        except RunFailedError as error:
            message = self._error_line(workspace.folder / LOG_NAME) or self._error_line(own_log)
            reason = f"{self.name}: {message}"
            if error.kind != "simulation" or not message:
                reason = error.reason
            # The log may be empty when a program is killed before it has written its output.
            tail = error.log_tail or log_tail(own_log)
            raise RunFailedError(reason, tail, error.kind) from error

    def _error_line(self, log: Path) -> str:
        """Return the error message of the program, or an empty text."""
        lines = text_of(log).splitlines()
        return next((line.strip() for line in lines if self._error.match(line)), "")

    @override
    def check(self) -> None:
        """Raise `SolverNotFoundError` unless the program is found.

        `InputError` if it cannot simulate the test, such as a round orifice with YADE. The
        default program is asked for its version. A program given by `executable` is started by the
        first run only.
        """
        if self.missing:
            self._require_concepts(concepts(self.test))
        self.executes()
        if self.executable is None:
            self.version()

    def _program(self) -> str:
        """Return the path of the program; raise `SolverNotFoundError` if it is not found."""
        found = self._find(self.executable or self.usual_name)
        if found is None:
            name = self.executable or self.usual_name
            if not platforms.HAS_FORK:
                raise SolverNotFoundError(
                    messages.NOT_FOUND_ON_WINDOWS(title=self.title, program=name)
                )
            raise SolverNotFoundError(
                messages.NOT_FOUND(title=self.title, program=name, install=self.install)
            )
        return str(Path(found).absolute())

    def _find(self, program: str) -> str | None:
        """Return the path of a program on the search path; None if it is not found."""
        return shutil.which(program)

    @override
    def executes(self) -> tuple[str, ...]:
        return (shlex.join(self._command(Path(self.deck.file_name))), *user_functions(self.test))

    @override
    def readiness(self) -> str:
        """Return the message that the solver is ready; does not start a given executable."""
        if self.executable is None:
            return super().readiness()
        return messages.FOUND(solver=self.name)

    @override
    def estimate_cost(self, parameters: Mapping[str, float]) -> RunCost:
        """Estimate the cost of a run.

        Raises
        ------
        InputError
            The material is impossible, or the program lacks a concept of its scene.
        """
        values = self.run_parameters(parameters)
        material = self._parts.material_of_test(values)
        self._parts.require_parts(values)
        if self.missing:
            self._require_concepts(concepts(self.test, material))
        return self.estimate_cost_of(self.test, material)

    @override
    def estimate_cost_of(self, test: BulkTest, material: Mapping[str, float]) -> RunCost:
        return self.speed.cost(workload(test, material), self.ranks)

    @override
    def seconds_on(self, ranks: int, parameters: Mapping[str, float]) -> float | None:
        if self._ranks_refusal(self.test, ranks) is not None:
            return None
        material = self._parts.material_of_test(self.run_parameters(parameters))
        return self.speed.cost(workload(self.test, material), ranks).wall_seconds

    @override
    def experiment(self, parameters: Mapping[str, float], seed: int) -> Scene:
        return self._scene(self.run_parameters(parameters), seed)

    def scene(self, parameters: Mapping[str, float], seed: int) -> Scene:
        """Return the scene of a run.

        Raises
        ------
        InputError
            The material is impossible, or the program lacks a concept of its scene.
        """
        scene = self.experiment(parameters, seed)
        self._require_concepts(scene.concepts())
        return scene

    def _scene(self, material: Mapping[str, float], seed: int) -> Scene:
        factor = self.test.sizes.coarse_graining
        return self._parts.scene(simulated_material(material, factor), seed)

    @override
    def default_timeout(self, parameters: Mapping[str, float]) -> float:
        return _LEAST_TIMEOUT + _PATIENCE * self.estimate_cost(parameters).wall_seconds

    @override
    def version(self) -> str:
        program = self._program()
        output = program_help(program, self.install, self.version_option)
        found = re.search(self.version_pattern, output)
        if found is None:
            raise SolverNotFoundError(
                messages.IS_ANOTHER_PROGRAM(program=program, title=self.title, install=self.install)
            )
        self._require_packages(program, output)
        return found.group(1).strip()

    def _require_packages(self, program: str, output: str) -> None:
        """Raise `SolverNotFoundError` if the program was built without what the decks need."""

    def _start(self, deck: Path) -> tuple[list[str], Mapping[str, str]]:
        """Return the command of a run, and the environment variables that it takes."""
        return self._command(deck), {}

    @abstractmethod
    def _command(self, deck: Path) -> list[str]:
        """Return the command by which a user runs a deck in its own folder."""


@lru_cache(maxsize=8)
def program_help(program: str, install: str, option: str = "-h") -> str:
    """Return the output of a DEM program with an option that makes it tell its version.

    Raises
    ------
    SolverNotFoundError
        The program does not run; ``install`` says how to install it.
    """
    try:
        # LIGGGHTS writes a log into the current folder, even to show its help.
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [program, option],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=_HELP_SECONDS,
                check=False,
            )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SolverNotFoundError(
            messages.DOES_NOT_RUN(program=program, error=error, install=install)
        ) from error
    return done.stdout


def _faults_of_kinds(
    test: object, material: object, ranks: object, executable: object, walls: object
) -> list[Fault]:
    """Return a fault for every argument that is of a kind that a solver cannot take."""
    names = walls.values() if isinstance(walls, Mapping) else ()
    return [
        *kind_faults("test", test, BulkTest, 'a bulk test, such as Heap(diameter="10 mm")'),
        *mapping_faults("material", material, '{"particle.density": 2500}'),
        *whole_number_faults({"ranks": ranks}),
        *kind_faults("executable", executable, str | PathLike | None, "the name of a program"),
        *mapping_faults("walls", walls, '{"plate": "steel"}'),
        *(fault for name in names for fault in kind_faults("walls", name, str, "names of walls")),
    ]


def _names(contact_models: Iterable[str]) -> tuple[str, ...]:
    """Return the names of contact models."""
    if isinstance(contact_models, Iterable) and not isinstance(contact_models, str):
        return tuple(contact_models)
    wanted = 'a list of names, such as ["epsd2"]'
    given = shortened(contact_models)
    raise InputError(NOT_ACCEPTED.fault("contact_models", given=given, wanted=wanted))


def _in_si(material: Mapping[str, float | str]) -> dict[str, float]:
    """Read quantities such as ``"0.36 MPa"`` among the values of a material."""
    values: dict[str, float] = {}
    faults: list[Fault] = []
    for name, value in material.items():
        try:
            values[name] = to_unit(value, _unit(name)) if isinstance(value, str) else value
        except UnitError as error:
            faults.append(Fault(name, error.message, error.remedy))
            continue
        if isinstance(value, bool) or not isinstance(value, Real | str):
            wanted = "a number, or a quantity with its unit"
            faults.append(NOT_ACCEPTED.fault(name, given=shortened(value), wanted=wanted))
    InputError.raise_for(faults)
    return values


def _unit(name: str) -> str:
    known = material_parameter(name)
    return "" if known is None else known.unit


def _impossible(material: Mapping[str, float]) -> Iterator[Fault]:
    for name, value in material.items():
        known = material_parameter(name)
        if known is None:
            yield messages.NO_PARAMETER.fault(name, known=", ".join(MATERIAL_PARAMETERS))
            continue
        if not (math.isfinite(as_number(value)) and known.lowest <= value <= known.highest):
            yield messages.OUTSIDE_LIMITS.fault(
                name,
                value=as_number(value),
                lowest=known.lowest,
                highest=known.highest,
                unit=f" {known.unit}" if known.unit else "",
            )
