"""The material card: what is known of a calibrated material and where it comes from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Literal

from grainfit.bulk_tests.heap import HeapTest
from grainfit.errors import StoreError
from grainfit.export.answer import read_answer
from grainfit.material import MATERIAL_PARAMETERS, ParticleSizes
from grainfit.reading import CalibrationReading
from grainfit.result import ResponseResult
from grainfit.timestep import RayleighTimeStep

Origin = Literal["calibrated", "not calibrated", "given"]

_STATUS_WORDS = {
    "calibrated": "calibrated: every target is met within its tolerance",
    "out_of_tolerance": "NOT CALIBRATED: finished without meeting every target",
    "unreachable": "NOT CALIBRATED: out of reach within the given intervals",
    "interrupted": "NOT CALIBRATED: interrupted before it was decided",
}
_NOT_ENDED = "NOT CALIBRATED: it was started again and has not come to its end"


@dataclass(frozen=True)
class CardParameter:
    """A parameter of the material.

    Parameters
    ----------
    name, symbol, unit, description : str
        As in the calibration file; symbol and description are empty for one of the user's own.
    value : float
        SI.
    origin : {"calibrated", "not calibrated", "given"}
        Whether it was free, and if so whether the calibration met its targets.
    interval : pair of float, optional
        95 % credible interval.
    """

    name: str
    symbol: str
    unit: str
    description: str
    value: float
    origin: Origin
    interval: tuple[float, float] | None = None


@dataclass(frozen=True)
class CardResponse:
    """What the material gives in a bulk test, against what was measured.

    Parameters
    ----------
    name, unit : str
        Of the target.
    target, tolerance : float
        Measured value and largest accepted deviation.
    expected : float
        Mean of the verification runs; without any, what the metamodel predicts.
    interval : pair of float
        95 % interval of the expected value.
    deviation_percent : float
        Of the expected value from the target.
    verified : bool
        Whether it is that of verification runs.
    met : bool
        Whether it is verified that the target is met within its tolerance.
    in_doubt : bool
        Whether the verification runs meet it unsurely, and all runs together do not.
    """

    name: str
    unit: str
    target: float
    tolerance: float
    expected: float
    interval: tuple[float, float]
    deviation_percent: float
    verified: bool
    met: bool
    in_doubt: bool


@dataclass(frozen=True)
class Program:
    """What made the runs: ``lammps``, ``liggghts``, or the kind of the user's own model."""

    name: str
    version: str


@dataclass(frozen=True)
class MaterialCard:
    """A material, how well it is known, and how it was found.

    Parameters
    ----------
    name : str
        What was calibrated.
    status : str
        ``calibrated``, or how it ended otherwise.
    parameters : tuple of CardParameter
        The free ones and those that were given, those of `grainfit.material` first.
    responses : tuple of CardResponse
        In the order of the targets.
    sizes : ParticleSizes, optional
        Of the particles, as far as they are known.
    gravity : float
        In the tests, m/s^2.
    rayleigh_time_step, recommended_time_step : float, optional
        s.
    time_step_fraction : float
        Recommended time step over the Rayleigh time step: that of the tests.
    programs : tuple of Program
        What it was calibrated with.
    runs, failed_runs : int
        DEM runs that it rests on, and how many of them gave no responses.
    date : str
        When the last of them ended, ISO 8601 in UTC; empty when that is not known.
    calibration_file, identity, version : str
        Name of the calibration file (empty when it was started from Python), identity of the
        calibration, and version of grainfit.
    notices : tuple of str
        What the user should know.
    """

    name: str
    status: str
    parameters: tuple[CardParameter, ...]
    responses: tuple[CardResponse, ...]
    sizes: ParticleSizes | None
    gravity: float
    rayleigh_time_step: float | None
    recommended_time_step: float | None
    time_step_fraction: float
    programs: tuple[Program, ...]
    runs: int
    failed_runs: int
    date: str
    calibration_file: str
    identity: str
    version: str
    notices: tuple[str, ...]

    @property
    def calibrated(self) -> bool:
        """Whether every target is met, and that is verified."""
        return self.status == "calibrated"

    @property
    def verdict(self) -> str:
        """How the calibration ended, in words, with the targets that are not met."""
        words = _STATUS_WORDS.get(self.status, _NOT_ENDED)
        missed = [
            f"{response.name}, which is in doubt" if response.in_doubt else response.name
            for response in self.responses
            if not response.met
        ]
        return f"{words} (not met: {', '.join(missed)})" if missed else words

    @property
    def values(self) -> dict[str, float]:
        """Values of all parameters by name, SI."""
        return {parameter.name: parameter.value for parameter in self.parameters}


def make_card(
    reading: CalibrationReading, intervals: Mapping[str, tuple[float, float]]
) -> MaterialCard:
    """Make the card of a calibration.

    Parameters
    ----------
    reading : CalibrationReading
        What the work folder tells.
    intervals : mapping of str to pair of float
        95 % credible intervals of free parameters, as far as there are any.

    Raises
    ------
    InputError
        There is no answer yet.
    StoreError
        The result is damaged.
    """
    answer = read_answer(reading)
    # A start that came to no end leaves the result of the one before.
    status = reading.state if answer.status == "calibrated" else answer.status
    conditions = _heap_conditions(reading)
    origin: Origin = "calibrated" if status == "calibrated" else "not calibrated"
    parameters = tuple(_parameters(reading, answer.parameters, origin, intervals))
    sizes = _sizes(reading, conditions)
    rayleigh = _rayleigh_time_step(parameters, sizes)
    fraction = min(
        (found.time_step_fraction for found in conditions), default=HeapTest.time_step_fraction
    )
    return MaterialCard(
        name=reading.name,
        status=status,
        parameters=parameters,
        responses=tuple(_response(name, found) for name, found in answer.responses.items()),
        sizes=sizes,
        gravity=conditions[0].gravity if conditions else HeapTest.gravity,
        rayleigh_time_step=rayleigh,
        recommended_time_step=None if rayleigh is None else fraction * rayleigh,
        time_step_fraction=fraction,
        programs=tuple(_programs(reading)),
        runs=sum(len(evaluation.runs) for evaluation in reading.known),
        failed_runs=sum(len(evaluation.failures) for evaluation in reading.known),
        date=_date(reading),
        calibration_file=reading.source,
        identity=reading.identity,
        version=reading.version,
        notices=answer.notices,
    )


def _parameters(
    reading: CalibrationReading,
    found: Mapping[str, float],
    origin: Origin,
    intervals: Mapping[str, tuple[float, float]],
) -> Iterator[CardParameter]:
    rayleigh = reading.problem.rayleigh
    given = {**(rayleigh.fixed if rayleigh else {}), **reading.fixed}
    values = {**given, **found}
    first = [name for name in MATERIAL_PARAMETERS if name in values]
    for name in dict.fromkeys([*first, *values]):
        known = MATERIAL_PARAMETERS.get(name)
        interval = intervals.get(name)
        yield CardParameter(
            name,
            known.symbol if known else "",
            known.unit if known else reading.units.get(name, ""),
            known.description if known else "",
            float(values[name]),
            origin if name in found else "given",
            None if interval is None else (float(interval[0]), float(interval[1])),
        )


def _response(name: str, found: ResponseResult) -> CardResponse:
    expected, half = found.expected
    return CardResponse(
        name,
        found.unit,
        found.target,
        found.tolerance,
        expected,
        (expected - half, expected + half),
        found.deviation_percent,
        found.is_verified,
        found.verdict == "met",
        found.verdict == "in doubt",
    )


@dataclass(frozen=True)
class _Conditions:
    """What a heap test says of how the material was used."""

    sizes: ParticleSizes
    gravity: float
    time_step_fraction: float


def _heap_conditions(reading: CalibrationReading) -> list[_Conditions]:
    """Conditions of the heap tests among the runs, in their order, each once."""
    tests = (record.definition.get("test") for record in reading.runs.values())
    try:
        found = [
            _Conditions(
                ParticleSizes(tuple(test["diameters"]), tuple(test["mass_fractions"])),
                float(test["setup"]["gravity"]),
                float(test["time_step_fraction"]),
            )
            for test in tests
            if isinstance(test, Mapping) and test.get("type") == HeapTest.type
        ]
    except (KeyError, TypeError, ValueError) as error:
        raise StoreError(
            f"a run of the heap test in {str(reading.folder)!r} is defined in another way than "
            f"this version of grainfit does: {error}."
        ) from error
    return list(dict.fromkeys(found))


def _sizes(reading: CalibrationReading, conditions: list[_Conditions]) -> ParticleSizes | None:
    if conditions:
        return conditions[0].sizes
    rayleigh = reading.problem.rayleigh
    return None if rayleigh is None else ParticleSizes((2 * rayleigh.radius,))


def _programs(reading: CalibrationReading) -> list[Program]:
    definitions = [record.definition for record in reading.runs.values()]
    found = [Program(str(d.get("solver", "")), str(d.get("version", ""))) for d in definitions]
    return list(dict.fromkeys(found))


def _date(reading: CalibrationReading) -> str:
    seconds = max((record.ended for record in reading.runs.values()), default=0.0)
    try:
        return datetime.fromtimestamp(seconds or reading.started, UTC).isoformat(timespec="seconds")
    except (ValueError, OverflowError, OSError):
        return ""


def _rayleigh_time_step(
    parameters: Iterable[CardParameter], sizes: ParticleSizes | None
) -> float | None:
    if sizes is None:
        return None
    values = {parameter.name: parameter.value for parameter in parameters}
    time_step = RayleighTimeStep(sizes.smallest_radius, values)
    return None if time_step.faults({}) else time_step({})
