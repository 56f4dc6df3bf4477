"""A test of the user's own: a scene and its measurement, as functions in a Python file."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, NoReturn, Self

from grainfit.bulk_tests.base import GRAVITY, BulkTest, Checks, read_sizes
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.own_scene import messages
from grainfit.bulk_tests.own_scene.checks import forces_after_fill, particles_not_held
from grainfit.bulk_tests.own_scene.picture import ParticlesView, draw_particles
from grainfit.bulk_tests.own_scene.trial import require_return
from grainfit.bulk_tests.own_scene.user_function import call, name_of
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.bulk_tests.view import Shown
from grainfit.checks import Found, check
from grainfit.contact_models.registry import with_defaults
from grainfit.errors import Fault, InputError, NotMeasurableError, RunFailedError
from grainfit.evaluation import Measured, scalars
from grainfit.evaluation.exchange import read_responses
from grainfit.files import LARGEST_MODEL, read_within, write_atomically
from grainfit.materials.sizes import ParticleSizes
from grainfit.options.fields import Amount, read_options
from grainfit.options.functions import Function
from grainfit.options.kinds import Kind, ListOf, Quantity, Schema, Text, note_wrong_kind
from grainfit.options.paths import Located
from grainfit.options.places import Place
from grainfit.options.python_file import PythonFile
from grainfit.options.tables import Key, Named
from grainfit.scenes.duration import expected_duration
from grainfit.scenes.packing import Column
from grainfit.scenes.run_output import RunOutput, snapshot_file
from grainfit.scenes.scene import Scene, Wall
from grainfit.scenes.scene_faults import scene_faults
from grainfit.scenes.shapes import Mesh, Shape
from grainfit.units import UnitError, to_si

#: Name of the snapshot of the last stage, which every run leaves.
END = "end"
#: Folder of a run's copies of the functions.
FUNCTIONS = "functions"
_PICTURE = "particles.png"
_SAME = 1e-6


@dataclass(frozen=True)
class OptionValue(Kind):
    """A number, a quantity with a unit, a text, true or false."""

    def read(self, value: Any, place: Place) -> bool | int | float | str | None:
        """Read a value; a quantity with a unit becomes a number in SI units."""
        if isinstance(value, bool):
            return value
        if isinstance(value, int | float):
            good = Quantity("").read(value, place) is not None
            return value if good else None
        if not isinstance(value, str):
            note_wrong_kind(value, place, "a number, a text, true or false")
            return None
        text = Text().read(value, place)
        try:
            return text if text is None else to_si(text)[0]
        except UnitError:
            return text

    def schema(self) -> Schema:
        """Return the JSON Schema of a plain value."""
        return {"type": ["number", "string", "boolean"]}


#: Arguments that the two functions can take.
_OF_SCENE = ("material", "sizes", "seed", "gravity", "time_step", "options")
_OF_MEASURE = ("run", "sizes", "gravity", "options")
_KEYS = (
    Key(
        "scene",
        Function(_OF_SCENE),
        "Function that returns the experiment as a Scene. It gets those of material, sizes, seed, "
        "gravity, time_step and options that it names.",
        required=True,
        example='"blade.py:scene"',
    ),
    Key(
        "measure",
        Function(_OF_MEASURE),
        "Function that returns the responses by name: numbers, pairs of value and standard error, "
        "or Response. It gets those of run, sizes, gravity and options that it names.",
        required=True,
        example='"blade.py:measure"',
    ),
    Key(
        "options",
        Named(OptionValue(), is_whole=True),
        "Options of the two functions: numbers, quantities with a unit (passed in SI units), "
        "texts, true and false.",
        example='{ blade_speed = "50 mm/s" }',
        default="none",
    ),
    Key(
        "files",
        ListOf(Located()),
        "Other files that the functions read, such as STL files and modules: a run is another one "
        "when they change.",
        example='["hopper.stl"]',
        default="none",
    ),
)


@check("coarse-grained-scene")
def coarse_grained_scene(checked: CheckedTest[OwnScene]) -> Iterator[Found]:
    """Scenes of your own that coarse graining may enlarge, apparatus included."""
    test = checked.test
    if test.sizes.coarse_graining > 1 and "scene" in test.functions:
        yield (
            "scene",
            messages.MAY_BE_ENLARGED(
                factor=test.sizes.coarse_graining, file=test.functions["scene"].path.name
            ),
        )


@dataclass(frozen=True, init=False, eq=False)
class OwnScene(BulkTest):
    """A test of your own: two functions in a Python file describe it and measure it.

    ``scene(material, sizes, seed) -> Scene`` describes the experiment in the words of
    `grainfit.scenes`, ``measure(run) -> dict`` measures the output of a run. Any DEM program that
    has the concepts of the scene runs it. The contents of the files are part of the identity of
    runs.

    Parameters
    ----------
    sizes : ParticleSizes, optional
        Particle size distribution.
    diameter : float, str or list, optional
        Instead of sizes: ``"10 mm"``, or a list of ``{"value": ..., "mass_fraction": ...}``.
    scene, measure : str
        The functions, ``"blade.py:scene"``.
    options : mapping, optional
        Options of the functions: numbers, quantities with a unit, texts, true and false.
    files : sequence of path, optional
        Other files that the functions read: STL files, modules.
    gravity, time_step_fraction : float or str
        As of all tests. The scene must have them; the functions get ``gravity`` and ``time_step``.

    Raises
    ------
    InputError
        A file is missing, or has not the function.
    """

    type: ClassVar[str] = "scene"
    checks: ClassVar[Checks] = (
        coarse_grained_scene,
        particles_not_held,
        forces_after_fill,
    )
    title: ClassVar[str] = "a scene of your own"
    responses: ClassVar[Mapping[str, ResponseInfo]] = {}
    shown: ClassVar[Shown] = Shown("particles", "", snapshot_file(END), _PICTURE)

    #: Functions by their option; empty for a test from the record of a run.
    functions: Mapping[str, PythonFile] = field(default_factory=dict)
    #: Identities of functions and files.
    identities: Mapping[str, Any] = field(default_factory=dict)
    #: Options of the functions.
    options: Mapping[str, Any] = field(default_factory=dict)
    #: Other files that the functions read.
    files: tuple[Path, ...] = ()
    #: Responses that the measurement must give; None: any.
    targets: tuple[str, ...] | None = None
    _planned: tuple[dict[str, float], Scene] | None = None

    def __init__(
        self,
        sizes: ParticleSizes | None = None,
        *,
        scene: str,
        measure: str,
        diameter: Any = None,
        options: Mapping[str, Any] | None = None,
        files: Sequence[str | Path] = (),
        gravity: Amount = GRAVITY,
        time_step_fraction: Amount | None = None,
    ) -> None:
        given = {
            "scene": scene,
            "measure": measure,
            "options": dict(options or {}) or None,
            "files": [str(path) for path in files] or None,
            "gravity": gravity,
            "time_step_fraction": time_step_fraction,
        }
        read = read_options(self.option_keys(), given)
        self._set(
            sizes=read_sizes(sizes, diameter),
            gravity=read["gravity"],
            time_step_fraction=read["time_step_fraction"],
            functions={name: PythonFile(read[name]) for name in ("scene", "measure")},
            identities={},
            options=read["options"] or {},
            files=tuple(Path(path).resolve() for path in read["files"] or ()),
        )

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def option_keys(cls) -> tuple[Key, ...]:
        """Return the keys of the functions, and those of all tests."""
        return (*_KEYS, *super().option_keys())

    # --- identity ------------------------------------------------------------------------------

    def resolved_options(self) -> dict[str, Any]:
        """Return the contents of the functions' files, the options, and what all tests have."""
        return {
            **self._identities(),
            "options": dict(self.options),
            "gravity": self.gravity,
            "time_step_fraction": self.setup.time_step_fraction,
        }

    def _identities(self) -> Mapping[str, Any]:
        """Return functions and files by their names and contents."""
        if not self.identities:
            functions = {name: function.identity() for name, function in self.functions.items()}
            self._set(identities={**functions, "files": _contents(self.files)})
        return self.identities

    @classmethod
    def from_definition(cls, definition: Mapping[str, Any]) -> Self:
        """Rebuild the test from the definition in the record of a run.

        It can measure runs, each of which has a copy of its functions, but has no scene.
        """
        test = cls.__new__(cls)
        test._set(
            sizes=ParticleSizes.from_definition(definition),
            gravity=float(definition["gravity"]),
            time_step_fraction=float(definition["time_step_fraction"]),
            functions={},
            identities={
                "scene": _identity(definition["scene"]),
                "measure": _identity(definition["measure"]),
                "files": list(definition["files"]),
            },
            options=dict(definition["options"]),
            files=(),
        )
        return test

    # --- calibration ---------------------------------------------------------------------------

    @property
    def response_names(self) -> tuple[str, ...] | None:
        """Names of the responses that have a target; None without targets."""
        return self.targets or None

    def with_targets(self, names: Sequence[str]) -> Self:
        """Return the test that requires these responses of the user's function."""
        return self._with(targets=tuple(names))

    def with_sizes(self, sizes: ParticleSizes) -> Self:
        """Return the test with other particles."""
        return self._with(sizes=sizes)

    def with_time_step_fraction(self, fraction: float) -> Self:
        """Return the test with another share of the Rayleigh time step."""
        return self._with(time_step_fraction=fraction)

    def _with(self, **values: Any) -> Self:
        test = copy(self)
        vars(test).pop("setup", None)
        test._set(**values)
        return test

    def executes(self) -> tuple[str, ...]:
        """Describe the two functions, each by its file."""
        return tuple(
            f"{function.path}:{function.function}   (within grainfit itself)"
            for function in self.functions.values()
        )

    # --- the experiment ------------------------------------------------------------------------

    def scene(self, material: Mapping[str, float], seed: int) -> Scene:
        """Return the experiment that the user's function describes.

        Raises
        ------
        RunFailedError
            The function failed, or its scene cannot be simulated as it is meant.
        """
        if "scene" not in self.functions:
            raise RunFailedError(messages.NO_FUNCTION_RECORDED())
        function = self.functions["scene"]
        possible = {
            "material": with_defaults(material),
            "sizes": self._sizes_of(material),
            "seed": seed,
            "gravity": self.gravity,
            "time_step": self.time_step(material),
            "options": dict(self.options),
        }
        words = name_of(function)
        require_return(function, possible)
        found = call(function, possible)
        if not isinstance(found, Scene):
            reason = messages.NOT_A_SCENE(function=words, kind=type(found).__name__)
            raise RunFailedError(reason, kind="evaluation")
        try:
            completed = self._completed(found)
            faults = [*self._condition_faults(completed, material), *scene_faults(completed)]
        except (TypeError, AttributeError) as error:
            # A value of another type is found where it is first used.
            reason = messages.WRONG_TYPE(function=words, reason=error)
            raise RunFailedError(reason, kind="evaluation") from error
        if faults:
            reason = "; ".join(map(str, faults))
            raise RunFailedError(
                messages.SCENE_FAULTS(function=words, reason=reason), kind="evaluation"
            )
        return completed

    def _completed(self, scene: Scene) -> Scene:
        """Return the scene with absolute paths of meshes, and a snapshot at its end."""
        stages = [replace(stage, put=self._located(stage.put)) for stage in scene.stages]
        if stages and not stages[-1].snapshot:
            stages[-1] = replace(stages[-1], snapshot=END)
        return replace(scene, walls=self._located(scene.walls), stages=tuple(stages))

    def _located(self, walls: Mapping[str, Wall]) -> dict[str, Wall]:
        """Return walls whose STL files are found from the folder of the scene's file."""
        return {name: replace(wall, shape=self._shape(wall.shape)) for name, wall in walls.items()}

    def _shape(self, shape: Shape) -> Shape:
        if not isinstance(shape, Mesh):
            return shape
        folder = self.functions["scene"].path.parent
        return replace(shape, path=(folder / shape.path).resolve())

    def _condition_faults(self, scene: Scene, material: Mapping[str, float]) -> Iterator[Fault]:
        """Yield what the identity of runs and material cards would not know of the scene."""
        if not math.isclose(scene.gravity, float(self.gravity), rel_tol=_SAME):
            message = f"is {scene.gravity:g} m/s^2 in the scene and {self.gravity:g} in the test."
            remedy = "Write it into [[test]], and gravity=gravity into the scene."
            yield Fault("gravity", message, remedy)
        wanted = self.time_step(material)
        if not math.isclose(scene.time_step, wanted, rel_tol=_SAME):
            message = f"is {scene.time_step:.4g} s in the scene and {wanted:.4g} s in the test."
            remedy = "Take time_step as an argument, and write time_step_fraction into [[test]]."
            yield Fault("time_step", message, remedy)
        for name, wall in scene.all_walls().items():
            if isinstance(wall.shape, Mesh) and wall.shape.path not in self.files:
                message = f"is the file {wall.shape.path.name}, which the test does not name."
                remedy = f'Write files = ["{wall.shape.path.name}"] into [[test]].'
                yield Fault(f"wall {name}", message, remedy)
        if scene.stages and scene.stages[-1].snapshot != END:
            message = f"the last one leaves the snapshot {scene.stages[-1].snapshot!r}."
            yield Fault("stages", message, f'Call it "{END}", or leave it out.')

    def planned(self, material: Mapping[str, float]) -> Scene:
        """Return the scene of seed 1, made once for the same material.

        Raises
        ------
        InputError
            See `scene`.
        """
        if self._planned is None or self._planned[0] != dict(material):
            try:
                self._set(_planned=(dict(material), self.scene(material, 1)))
            except RunFailedError as error:
                raise InputError(messages.NO_SCENE.fault("scene", reason=error.reason)) from error
        assert self._planned is not None
        return self._planned[1]

    @property
    def last_planned(self) -> Scene | None:
        """The scene that was planned last; None before."""
        return None if self._planned is None else self._planned[1]

    def simulated_time(self, material: Mapping[str, float]) -> float:
        """Estimate the simulated time of a run, s."""
        return expected_duration(self.planned(material))

    # --- the measurement -----------------------------------------------------------------------

    def measure(self, run: RunOutput) -> Mapping[str, Measured]:
        """Measure the responses with the user's function; leave a picture, and the functions.

        Raises
        ------
        RunFailedError
            The simulation went wrong or ended early, the function failed, or gave no numbers.
        NotMeasurableError
            The particles at the end cannot be read.
        """
        run.require_good()
        if not run.path_of(snapshot_file(END)).is_file():
            done = ", ".join(stage.name for stage in run.stages) or "none"
            reason = f"the simulation ended early (stages done: {done})"
            raise RunFailedError(reason, run.log_tail())
        particles = run.snapshot(END)
        self._keep_functions(run.folder)
        function = self._measure_function(run.folder)
        possible = {
            "run": run,
            "sizes": self.sizes,
            "gravity": self.gravity,
            "options": dict(self.options),
        }
        found = call(function, possible)
        words = name_of(function)
        responses = read_responses(found, self.targets, words)
        if len(particles):
            numbers = scalars(responses)
            draw_particles(run.folder / _PICTURE, particles, function.path.stem, numbers)
        return responses

    def _keep_functions(self, folder: Path) -> None:
        """Write copies of the functions' files into the folder of a run."""
        (folder / FUNCTIONS).mkdir(exist_ok=True)
        for function in self.functions.values():
            write_atomically(folder / FUNCTIONS / function.path.name, function.source.decode())

    def _measure_function(self, folder: Path) -> PythonFile:
        """Return the function; for a test from a record, that of the copy in the run's folder."""
        if "measure" in self.functions:
            return self.functions["measure"]
        known = self.identities["measure"]
        function = PythonFile(f"{FUNCTIONS}/{known['file']}:{known['function']}", folder)
        try:
            unchanged = function.identity() == known
        except InputError as error:
            raise NotMeasurableError(messages.NOT_KEPT(reason=error)) from error
        if not unchanged:
            raise NotMeasurableError(messages.FUNCTION_CHANGED(path=function.path))
        return function

    def view(self, run: RunOutput) -> ParticlesView:
        """Read the particles at the end of a run, to be drawn."""
        particles = run.snapshot(END)
        if not len(particles):
            raise NotMeasurableError(messages.EMPTY_BOX())
        return ParticlesView.of(particles)

    # --- tests that fill a container by themselves have these ----------------------------------

    def scene_of(self, column: Column, material: Mapping[str, float]) -> NoReturn:  # noqa: ARG002
        """The scene places its particles itself."""
        raise AttributeError("a scene of the user places its particles itself")

    @property
    def number_of_particles(self) -> int:
        """Number of particles of the scene that was planned last, glued ones included; 0 before."""
        scene = self.last_planned
        return 0 if scene is None else scene.number_of_particles


def _contents(files: Iterable[Path]) -> list[list[str]]:
    """Return the names and the hashes of files."""
    try:
        return [
            [path.name, hashlib.sha256(read_within(path, LARGEST_MODEL)).hexdigest()]
            for path in files
        ]
    except OSError as error:
        remedy = "Give the path of a file."
        raise InputError(Fault("files", f"{error.filename}: {error.strerror}.", remedy)) from error


def _identity(recorded: Mapping[str, str]) -> dict[str, str]:
    return {key: str(recorded[key]) for key in ("file", "function", "source")}
