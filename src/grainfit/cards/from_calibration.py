"""Build the material card of a calibration."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from datetime import UTC, datetime

from grainfit.analysis.soft_particles import of_hertz, stiffness_notes
from grainfit.bulk_tests.apparatus import apparatus_lines, apparatus_of, as_smaller
from grainfit.bulk_tests.base import GRAVITY, TIME_STEP_FRACTION, BulkTest
from grainfit.bulk_tests.conditions import Conditions, conditions_of
from grainfit.bulk_tests.parameter_names import RESTITUTION
from grainfit.bulk_tests.registry import recreate_test
from grainfit.bulk_tests.time_steps import fraction_in_any_bed, rounded_down
from grainfit.cards import messages
from grainfit.contact_models.registry import (
    contact_law,
    in_order,
    material_parameter,
    with_defaults,
)
from grainfit.errors import InputError, StoreError
from grainfit.materials.card import CardParameter, CardResponse, MaterialCard, Origin, Program
from grainfit.materials.particle_shape import ASPECT_RATIO, ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.result import ParameterInterval, ResponseResult
from grainfit.work_folder.saved_calibration import (
    SavedCalibration,
    bulk_tests_of,
    read_answer,
    twins_of,
)


def make_card(
    reading: SavedCalibration, intervals: Mapping[str, ParameterInterval]
) -> MaterialCard:
    """Build the card of a calibration.

    It has the 95 % intervals of free parameters, as far as there are any.

    Raises
    ------
    InputError
        There is no answer yet.
    StoreError
        The result is damaged.
    """
    answer = read_answer(reading)
    # A start that was interrupted leaves the result of the previous one.
    status = reading.state if answer.status == "calibrated" else answer.status
    conditions = _conditions(reading)
    origin: Origin = "calibrated" if status == "calibrated" else "not calibrated"
    parameters = tuple(_parameters(reading, answer.parameters, origin, intervals))
    ratio = next((p.value for p in parameters if p.name == ASPECT_RATIO), 1.0)
    sizes = _sizes(reading, conditions, ratio)
    rayleigh = _rayleigh_time_step(parameters, sizes)
    fraction = _time_step_fraction(reading, conditions, parameters, sizes)
    tests = of_hertz(bulk_tests_of(reading), reading.contact_models)
    stiff = stiffness_notes(reading.problem, tests, reading.fixed, answer.parameters)
    return MaterialCard(
        name=reading.name,
        status=status,
        parameters=parameters,
        responses=tuple(_response(name, found) for name, found in answer.responses.items()),
        sizes=sizes,
        gravity=conditions[0].gravity if conditions else GRAVITY,
        rayleigh_time_step=rayleigh,
        recommended_time_step=None if rayleigh is None else fraction * rayleigh,
        time_step_fraction=fraction,
        programs=tuple(_programs(reading)),
        runs=answer.runs.total,
        failed_runs=answer.runs.failed,
        date=_date(reading),
        calibration_file=reading.source,
        identity=reading.identity,
        version=reading.version,
        notices=(*answer.notices, *map(str, answer.holdouts), *stiff),
        contact_models=_contact_models(reading, parameters, conditions),
        apparatus=tuple(_apparatus(reading, tests, parameters)),
        earlier_runs=answer.runs.warm_start_runs,
    )


def _parameters(
    reading: SavedCalibration,
    found: Mapping[str, float],
    origin: Origin,
    intervals: Mapping[str, ParameterInterval],
) -> Iterator[CardParameter]:
    rayleigh = reading.problem.rayleigh
    given = {**(rayleigh.fixed if rayleigh else {}), **reading.fixed}
    values = {**given, **found}
    own = {parameter.name for parameter in reading.problem.measured}
    for name in dict.fromkeys([*in_order(values), *values]):
        known = material_parameter(name)
        interval = intervals.get(name)
        yield CardParameter(
            name,
            known.symbol if known else "",
            known.unit if known else reading.units.get(name, ""),
            known.description if known else "",
            float(values[name]),
            "measured" if name in own else origin if name in found else "given",
            None if interval is None else (interval.low, interval.high),
            None if interval is None else interval.determination,
            "" if interval is None else interval.bias,
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
        found.verdict,
        found.verified_mean,
    )


def _conditions(reading: SavedCalibration) -> list[Conditions]:
    """Conditions of the bulk tests among the runs, in their order, each once."""
    definitions = {
        record.definition.model_hash: record.definition for record in reading.records.values()
    }
    try:
        tests = [recreate_test(definition) for definition in definitions.values()]
    except InputError as error:
        folder = str(reading.folder)
        raise StoreError(messages.OTHER_DEFINITION(folder=folder, error=error)) from error
    return list(dict.fromkeys(conditions_of(test) for test in tests if test is not None))


def _sizes(
    reading: SavedCalibration, conditions: list[Conditions], aspect_ratio: float
) -> ParticleSizes | None:
    if conditions:
        return conditions[0].sizes.with_aspect_ratio(aspect_ratio).without_noise
    if reading.sizes is not None:
        return reading.sizes.with_aspect_ratio(aspect_ratio).without_noise
    rayleigh = reading.problem.rayleigh
    if rayleigh is None:
        return None
    shape = ParticleShape(rayleigh.shape, aspect_ratio=aspect_ratio) if rayleigh.shape else None
    return ParticleSizes((2 * rayleigh.radius,), shape=shape)


def _programs(reading: SavedCalibration) -> list[Program]:
    models = [record.definition.model for record in reading.records.values()]
    found = [Program(str(d.get("solver", "")), str(d.get("version", ""))) for d in models]
    return list(dict.fromkeys(found))


def _apparatus(
    reading: SavedCalibration, tests: Mapping[str, BulkTest], parameters: Iterable[CardParameter]
) -> Iterator[str]:
    """Yield the apparatus of every bulk test, and the smaller one that was simulated for it."""
    values = {parameter.name: parameter.value for parameter in parameters}
    walls = {
        record.test: record.definition.model.get("walls", {}) for record in reading.records.values()
    }
    twins = twins_of(reading)
    for name, test in tests.items():
        shown = name or "the test"
        given = reading.options.get(name)
        yield from apparatus_lines(shown, apparatus_of(test, given, values, walls[name]))
        if name in twins:
            smaller = apparatus_of(twins[name], None, values, walls[name])
            yield from apparatus_lines(as_smaller(shown), smaller)


def _contact_models(
    reading: SavedCalibration, parameters: Iterable[CardParameter], conditions: list[Conditions]
) -> tuple[str, ...]:
    """Chosen contact models and usual ones; none of an own model whose file chooses none."""
    if not conditions and not reading.contact_models:
        return ()
    values = {parameter.name: parameter.value for parameter in parameters}
    law = contact_law(values, reading.contact_models)
    return tuple(model.name for model in law.models)


def _date(reading: SavedCalibration) -> str:
    seconds = max((record.ended for record in reading.records.values()), default=0.0)
    try:
        return datetime.fromtimestamp(seconds or reading.started, UTC).isoformat(timespec="seconds")
    except (ValueError, OverflowError, OSError):
        return ""


def _time_step_fraction(
    reading: SavedCalibration,
    conditions: list[Conditions],
    parameters: Iterable[CardParameter],
    sizes: ParticleSizes | None,
) -> float:
    # The bed that the card is for is not known: it may be deeper than those of the tests.
    fraction = min([TIME_STEP_FRACTION, *(found.time_step_fraction for found in conditions)])
    values = with_defaults({parameter.name: parameter.value for parameter in parameters})
    if conditions or sizes is None or RESTITUTION not in values:
        return fraction
    with suppress(InputError):
        return rounded_down(fraction_in_any_bed(sizes, values, reading.contact_models))
    return fraction


def _rayleigh_time_step(
    parameters: Iterable[CardParameter], sizes: ParticleSizes | None
) -> float | None:
    if sizes is None:
        return None
    values = {parameter.name: parameter.value for parameter in parameters}
    time_step = RayleighTimeStep(sizes.rayleigh_radius, values)
    return None if time_step.faults({}) else time_step({})
