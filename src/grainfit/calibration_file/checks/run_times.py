"""Runs that would be stopped before their end, and what shortens a calibration of days."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from grainfit.analysis.recorded_size import changes_in_words
from grainfit.bulk_tests.abilities import is_of_user, material_faults
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import coarse_grained, factor_words, sized_for
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.bulk_tests.size import TWIN, twin_of
from grainfit.bulk_tests.stiffness import overlap_law, stiffness_number
from grainfit.bulk_tests.time_steps import with_safe_time_step
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.contact_models.registry import is_load_dependent
from grainfit.errors import InputError
from grainfit.formatting import counted, duration, number
from grainfit.solvers.base import Solver

#: Largest share of the time that is worth a sentence.
_WORTH_IT = 0.8
#: Excess of bulk densities from overlaps that the offered modulus leaves.
_TOLERATED_EXCESS = 0.02
_COARSER = 2.0


@check("short-timeout", "warning")
def short_timeout(context: FileContext) -> Iterator[Found]:
    """Time-outs that stop runs before their estimated end."""
    for test, limit in context.file.timeouts.items():
        seconds = context.costs.get(test)
        if seconds is not None and limit < seconds:
            found = messages.SHORT_TIMEOUT(
                test=test, limit=duration(limit), seconds=duration(seconds)
            )
            yield context.key(test, "timeout"), found


@check("mpi-ranks", "warning")
def mpi_ranks(context: FileContext) -> Iterator[Found]:
    """MPI ranks that more runs at a time would beat, or that there are no cores for."""
    file, time = context.file, context.time
    if file.ranks == 1 or file.cluster is not None:
        return
    workers = file.strategy.workers or file.runs_at_once
    if workers * file.ranks > file.cores:
        yield (
            "",
            messages.MORE_RANKS_THAN_CORES(
                runs=counted(workers, "run"),
                ranks=file.ranks,
                needed=workers * file.ranks,
                cores=file.cores,
            ),
        )
    elif time is not None and (costs := _costs_on(context, 1)):
        alone = replace(time, costs=costs, workers=file.cores)
        if alone.seconds[1] <= _WORTH_IT * time.seconds[1]:
            yield (
                "",
                messages.RANKS_DO_NOT_PAY(
                    ranks=file.ranks,
                    runs=counted(workers, "run"),
                    time=time,
                    more=counted(file.cores, "run"),
                    alone=alone,
                ),
            )


@check("more-ranks")
def more_ranks(context: FileContext) -> Iterator[Found]:
    """Cores that runs at a time leave idle, and that MPI ranks of each run would use."""
    file, time = context.file, context.time
    if file.ranks > 1 or file.cluster is not None or time is None:
        return
    faster = []
    ranks = 2
    while ranks <= file.cores and (costs := _costs_on(context, ranks)):
        workers = min(time.workers, file.cores // ranks)
        faster.append((ranks, replace(time, costs=costs, workers=workers)))
        ranks *= 2
    best = min(faster, key=lambda one: one[1].seconds[1], default=None)
    if best is not None and best[1].seconds[1] <= _WORTH_IT * time.seconds[1]:
        ranks, shared = best
        runs = counted(shared.workers, "run")
        yield "", messages.RANKS_PAY(ranks=ranks, runs=runs, shared=shared, time=time)


def _costs_on(context: FileContext, ranks: int) -> dict[str, float]:
    """Return the wall time of a run of each test on so many MPI ranks, s; empty if one is none."""
    middle = context.problem.middle
    try:
        found = {name: one.seconds_on(ranks, middle) for name, one in context.solvers.items()}
    except InputError:
        # The plan says why a cost is not known.
        return {}
    known = {name: seconds for name, seconds in found.items() if seconds is not None}
    return known if len(known) == len(found) else {}


@check("long-calibration")
def long_calibration(context: FileContext) -> Iterator[Found]:
    """A calibration that takes a day or more, and what would shorten it to what time."""
    time = context.time
    if time is None or not time.is_long:
        return
    shorter = []
    offers = (_usual_size, _coarser, _twin, _softer)
    for change, seconds in (found for offer in offers for found in offer(context)):
        faster = replace(time, costs={**time.costs, **seconds})
        if faster.seconds[1] <= _WORTH_IT * time.seconds[1]:
            shorter.append(messages.WOULD_TAKE(change=change, time=faster))
    if shorter:
        yield "", messages.LONG_BUT_SHORTER(time=time, ways="; ".join(shorter))
    else:
        yield "", messages.LONG(time=time)


def _usual_size(context: FileContext) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Offer the usual dimensions of tests that are given larger ones."""
    for name, solver, test in _known_tests(context):
        try:
            fraction = test.time_step_fraction
            usual = sized_for(type(test), test.sizes, time_step_fraction=fraction)
            seconds = solver.estimate_cost_of(usual, _material(context, solver)).wall_seconds
        except (InputError, TypeError):
            continue
        if seconds > _WORTH_IT * context.costs[name]:
            continue
        count = usual.number_of_particles
        offer = messages.USUAL_DIMENSIONS(type=test.type, count=count)
        yield offer + _moved(context, {name: count}), {name: seconds}


def _softer(context: FileContext) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Offer the softest particles whose overlaps hardly change a response."""
    modulus = context.fixed.get(MODULUS)
    tests = list(_known_tests(context))
    if modulus is None or not tests or not is_load_dependent(context.contact_models):
        return
    try:
        needed = max(
            modulus
            * overlap_law(test).number_with(_TOLERATED_EXCESS)
            / stiffness_number(test, _material(context, solver))
            for _, solver, test in tests
        )
        # The time is that of the modulus which is shown.
        needed = 1e6 * float(number(needed / 1e6, 2))
        if needed >= _WORTH_IT * modulus or any(_refuses(context, needed, *one) for one in tests):
            return
        intervals = {**context.intervals, MODULUS: (needed, needed)}
        seconds = {
            name: solver.estimate_cost_of(
                with_safe_time_step(test, intervals, context.contact_models),
                {**_material(context, solver), MODULUS: needed},
            ).wall_seconds
            for name, solver, test in tests
        }
    except InputError:
        return
    softer = number(needed / 1e6, 2)
    yield messages.SOFTER(key=MODULUS, modulus=softer, percent=100 * _TOLERATED_EXCESS), seconds


def _coarser(context: FileContext) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Offer fewer, larger particles in the same apparatus."""
    coarser: dict[str, BulkTest] = {}
    seconds: dict[str, float] = {}
    for name, solver, test in _known_tests(context):
        try:
            material = _material(context, solver)
            coarser[name] = coarse_grained(test, _COARSER, material)
            cost = solver.estimate_cost_of(coarser[name], material)
        except InputError:
            # All tests have the same particles.
            return
        seconds[name] = cost.wall_seconds
    if seconds:
        offer = messages.COARSER(factor=factor_words(coarser))
        fewer = {name: test.number_of_particles for name, test in coarser.items()}
        yield offer + _moved(context, fewer), seconds


def _twin(context: FileContext) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Offer a search in smaller apparatus with the same particles, for targets at that size."""
    seconds: dict[str, float] = {}
    for name, solver, test in _known_tests(context):
        if (twin := twin_of(test)) is not None:
            cost = solver.estimate_cost_of(twin, _material(context, solver))
            seconds[name] = cost.wall_seconds
    if seconds:
        offer = messages.WITH_TWINS(count=TWIN)
        yield offer + _moved(context, dict.fromkeys(seconds, TWIN)), seconds


def _moved(context: FileContext, particles: Mapping[str, float]) -> str:
    """Return by how much responses move with these numbers of particles, as far as it is known."""
    return "".join(
        changes_in_words(context.bulk_tests[name], context.targets_of(name), count)
        for name, count in particles.items()
    )


def _known_tests(context: FileContext) -> Iterator[tuple[str, Solver, BulkTest]]:
    """Yield the bulk tests without code of the user."""
    for name, solver in context.solvers.items():
        test = solver.bulk_test
        if test is not None and not is_of_user(test):
            yield name, solver, test


def _refuses(
    context: FileContext, modulus: float, _name: str, solver: Solver, test: BulkTest
) -> bool:
    """Return whether a test means nothing with particles of a Young's modulus."""
    return any(material_faults(test, {**_material(context, solver), MODULUS: modulus}))


def _material(context: FileContext, solver: Solver) -> dict[str, float]:
    return solver.run_parameters(context.problem.middle)
