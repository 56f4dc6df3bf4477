"""Bulk tests: options in, a scene out, responses measured on the output of a run.

A bulk test declares its options and responses, describes the experiment as a scene
(`grainfit.scenes`), measures the output of a run, and shows it in a report. It knows nothing of
campaigns and of solvers: every solver translates scenes. Everything else follows from these
declarations: the keys of ``[[test]]`` in the calibration file, JSON Schema, checks, tables in the
documentation, units of tables of runs, and labels of plots.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from copy import copy
from dataclasses import InitVar, dataclass, fields, replace
from functools import cache, cached_property
from typing import Any, ClassVar, Self

from grainfit.bulk_tests import messages
from grainfit.bulk_tests.abilities import material_faults
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.refused_factor import with_factor
from grainfit.bulk_tests.response_info import CurveInfo, ResponseInfo
from grainfit.bulk_tests.setup import Setup
from grainfit.bulk_tests.shared.filling import Filling
from grainfit.checks import Check
from grainfit.errors import InputError
from grainfit.evaluation import Measured
from grainfit.materials.diameters import Diameters
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.materials.sizes import ParticleSizes
from grainfit.one_line import OneLine
from grainfit.options.fields import Amount, Derived, option, option_keys, read_options
from grainfit.options.kinds import Quantity
from grainfit.options.tables import Key
from grainfit.registration import gaps
from grainfit.scenes.packing import Column, Footprint, random_column
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import SCENES_REVISION, Scene, time_step

#: Gravity on Earth, m/s^2.
GRAVITY = 9.81
#: Below it, m/s^2, hardly anything falls: no bed fills and none comes to rest in a sensible time.
LOWEST_GRAVITY = 1e-3
#: Share of the Rayleigh time step at which beds of nearly every material come to rest: the default
#: of tests that do not know their material.
TIME_STEP_FRACTION = 0.12
#: Parts of a test that can be of different materials, each with its walls in the scene.
Parts = Mapping[str, tuple[str, ...]]
#: Checks of a test.
Checks = tuple[Check[CheckedTest[Any]], ...]
_DIAMETER = Key("diameter", Diameters(), "Particle diameter.", example='"10 mm"')


@dataclass(frozen=True)
class BulkTest(OneLine, ABC):
    """A laboratory test of a bulk solid, ready to be simulated.

    A subclass is a frozen dataclass whose fields are its options, each declared by
    `grainfit.options.fields.option`. Quantities are given as numbers in SI units or with a unit.

    Parameters
    ----------
    sizes : ParticleSizes, optional
        Particle size distribution.
    diameter : float, str or list, optional
        Instead of sizes: ``"10 mm"``, or a list of ``{"value": ..., "mass_fraction": ...}``.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.
    """

    #: Name in the calibration file, ``type = "..."``.
    type: ClassVar[str]
    #: A few words beside the name, such as ``"lifted cylinder"``.
    title: ClassVar[str]
    #: Responses by name.
    responses: ClassVar[Mapping[str, ResponseInfo]]
    #: Responses that are curves, by name.
    curves: ClassVar[Mapping[str, CurveInfo]] = {}
    #: Options of a test with measured curves, where their defaults are of tests without.
    curve_options: ClassVar[Mapping[str, str]] = {}
    #: Parts that can be of different materials, each with its walls in the scene, the part that
    #: touches most particles first; None where every wall of the scene is a part.
    parts: ClassVar[Parts | None] = None
    #: Option that says how large the apparatus is; "" where none does.
    vessel: ClassVar[str] = ""
    #: What to enter instead of measured quantities that are no responses, by their names.
    enter_instead: ClassVar[Mapping[str, str]] = {}
    #: Checks of the test in a calibration, before any run.
    checks: ClassVar[Checks] = ()
    #: Raised whenever the procedure or its evaluation change the outcome of a run.
    revision: ClassVar[int] = 1

    sizes: ParticleSizes = None  # type: ignore[assignment]  # given as diameter instead
    diameter: InitVar[Amount | list[dict[str, Amount]] | None] = None
    gravity: Amount = option(
        Quantity("m/s^2", lowest=LOWEST_GRAVITY), "Gravity.", example="9.81", default=GRAVITY
    )
    time_step_fraction: Amount | None = option(
        Quantity("", highest=1.0, above_zero=True),
        "Time step over the Rayleigh time step. With larger ones than the default, which follows "
        "from restitution, rolling, cohesion and the stress on the bed, beds may never come to "
        "rest, or are too dense.",
        example="0.2",
        default=Derived("what is safe with contact law and bed", lambda _: TIME_STEP_FRACTION),
    )

    def __post_init__(self, diameter: Amount | list[dict[str, Amount]] | None) -> None:
        object.__setattr__(self, "sizes", read_sizes(self.sizes, diameter))
        for name, value in read_options(self.option_keys(), self.given_options()).items():
            object.__setattr__(self, name, value)
        try:
            self._require_possible()
        except InputError as error:
            if self.sizes.coarse_graining == 1:
                raise
            raise with_factor(error, self.sizes.coarse_graining, self._is_possible_at) from None

    def _is_possible_at(self, factor: float) -> bool:
        """Return whether the test is possible with the real particles enlarged by a factor.

        It is not known of clumps whose aspect ratio, and so their extent, is that of a material.
        """
        if self.sizes.shape is not None and self.sizes.clump is None:
            return False
        trial = copy(self)
        object.__setattr__(trial, "sizes", self.sizes.real.coarse_grained(factor))
        vars(trial).pop("setup", None)
        try:
            trial._require_possible()
        except InputError:
            return False
        return not any(material_faults(trial, {}))

    @classmethod
    def missing(cls) -> list[str]:
        """Return what the class lacks to be used."""
        found = gaps(cls, ("type", "title", "responses"))
        responses = getattr(cls, "responses", {})
        found += [f"{name} is a response and a curve" for name in responses if name in cls.curves]
        if cls.footprint is BulkTest.footprint and cls.column is BulkTest.column:
            found.append("footprint is missing")
        counted = cls.number_of_particles is not BulkTest.number_of_particles
        if not counted and not hasattr(getattr(cls.setup, "func", None), "filling"):
            found.append("number_of_particles is missing")
        return found

    @cached_property
    def setup(self) -> Setup:
        """Geometry and procedure, with every default resolved.

        Overridden by tests with more of it than their options.
        """
        return Setup(self)

    def _require_possible(self) -> None:
        """Raise `InputError` with every fault of the first stage that has any."""
        for stage in self.setup.fault_stages():
            InputError.raise_for(stage)
        self.setup.resolve()

    @classmethod
    def option_keys(cls) -> tuple[Key, ...]:
        """Return the options, with kind, default in words, help and example."""
        return _option_keys(cls)

    def definition(self) -> dict[str, Any]:
        """Return everything in the test that affects a run's outcome, as JSON."""
        return {
            "type": self.type,
            "revision": self.revision,
            "scenes": SCENES_REVISION,
            **self.sizes.definition(),
            **self.resolved_options(),
        }

    def resolved_options(self) -> dict[str, Any]:
        """Return the value of every option, defaults included.

        A default that is given explicitly is the same run, and another default is another run.
        """
        return {key.name: getattr(self.setup, key.name) for key in self.option_keys()}

    def given_options(self) -> dict[str, Any]:
        """Return the value of every option as it was given, None for many of the defaults."""
        return {key.name: getattr(self, key.name) for key in self.option_keys()}

    @classmethod
    def from_definition(cls, definition: Mapping[str, Any]) -> Self:
        """Rebuild the test from the definition in the record of a run.

        Raises
        ------
        KeyError, TypeError, ValueError, AttributeError
            The definition is damaged or incomplete.
        """
        sizes = ParticleSizes.from_definition(definition)
        return cls(sizes, **{key.name: definition[key.name] for key in cls.option_keys()})

    @property
    def response_names(self) -> tuple[str, ...] | None:
        """Names of the responses; None if they are known only after a run."""
        return (*self.responses, *self.curves)

    def time_step(self, material: Mapping[str, float]) -> float:
        """Return the time step of a run with this material, s."""
        return time_step(self._sizes_of(material), material, self.setup.time_step_fraction)

    def of_material(self, material: Mapping[str, float]) -> Self:
        """Return the test with what a material decides: the aspect ratio of its particles."""
        sizes = self._sizes_of(material)
        return self if sizes == self.sizes else self.with_sizes(sizes)

    def _sizes_of(self, material: Mapping[str, float]) -> ParticleSizes:
        return self.sizes.with_aspect_ratio(material.get(ASPECT_RATIO))

    def with_sizes(self, sizes: ParticleSizes) -> Self:
        """Return the test with other particles; defaults that follow from particles follow these.

        Raises
        ------
        InputError
            The test is impossible with them; names every option at fault.
        """
        return replace(self, sizes=sizes)

    def with_time_step_fraction(self, fraction: float) -> Self:
        """Return the test with another share of the Rayleigh time step."""
        return replace(self, time_step_fraction=fraction)

    def scene(self, material: Mapping[str, float], seed: int) -> Scene:
        """Return the experiment with a material.

        Parameters
        ----------
        material : mapping of str to float
            Material parameters by dotted name; those with a default may be missing.
        seed : int
            Insertion seed.
        """
        test = self.of_material(material)
        return test.scene_of(test.column(seed), material)

    def column(self, seed: int) -> Column:
        """Return the particles at the beginning: by default a column that falls.

        Parameters
        ----------
        seed : int
            Insertion seed.
        """
        return random_column(self.sizes, self.number_of_particles, self.footprint, seed)

    @property
    def footprint(self) -> Footprint:
        """Cross-section of the container that a column fills."""
        raise NotImplementedError(f"{self.type} places its particles itself")

    @abstractmethod
    def scene_of(self, column: Column, material: Mapping[str, float]) -> Scene:
        """Return the experiment with a column of particles.

        Parameters
        ----------
        column : Column
            Particles that fill the container; its height decides how high walls must be.
        material : mapping of str to float
            Material parameters by dotted name; those with a default may be missing.
        """

    def scene_with(
        self, material: Mapping[str, float], filling: Filling | None = None, **described: Any
    ) -> Scene:
        """Return a scene with the particles, the gravity and the time step of the test.

        Parameters
        ----------
        material : mapping of str to float
            Material parameters by dotted name.
        filling : Filling, optional
            Says when particles are at rest, unless the scene does.
        **described
            Everything else of the `Scene`.
        """
        shared: dict[str, Any] = {
            "material": material,
            "sizes": self.sizes,
            "gravity": float(self.gravity),
            "time_step": self.time_step(material),
        }
        if filling is not None:
            shared |= {"quiet_speed": filling.quiet_speed, "check_interval": filling.check_interval}
        return Scene(**(shared | described))

    @abstractmethod
    def measure(self, run: RunOutput) -> Mapping[str, Measured]:
        """Measure the responses on the output of a run.

        Raises
        ------
        RunFailedError
            The simulation did not end as the test requires.
        NotMeasurableError
            A response has no value there, with the reason.
        """

    @property
    def number_of_glued(self) -> int:
        """Number of particles that are glued to the apparatus."""
        return 0

    @property
    def number_of_particles(self) -> int:
        """Number of particles at the beginning of a run, glued ones included.

        Overridden by tests whose setup has no `Filling`.
        """
        return int(self.setup.filling.particle_count)

    @abstractmethod
    def simulated_time(self, material: Mapping[str, float]) -> float:
        """Estimate the simulated time of a run, s."""


@cache
def _option_keys(test: type[BulkTest]) -> tuple[Key, ...]:
    shared = {field.name for field in fields(BulkTest)}
    # Those that all tests have come last.
    return tuple(sorted(option_keys(test), key=lambda key: key.name in shared))


def read_sizes(sizes: ParticleSizes | None, diameter: Any) -> ParticleSizes:
    """Return the particle sizes of a test, given as such or as a diameter.

    Raises
    ------
    InputError
        Neither is given, or both are, or one is impossible.
    """
    if (sizes is None) == (diameter is None):
        message = messages.NO_DIAMETER if sizes is None else messages.DIAMETER_BESIDE_SIZES
        raise InputError(message.fault("diameter"))
    if sizes is None:
        read: ParticleSizes = read_options([_DIAMETER], {"diameter": diameter})["diameter"]
        return _as_sizes(read)
    return _as_sizes(sizes)


def _as_sizes(sizes: Any) -> ParticleSizes:
    if isinstance(sizes, ParticleSizes):
        return sizes
    raise InputError(messages.NO_SIZES.fault("sizes", sizes=sizes))
