"""Runs that would be stopped before their end, and what shortens a calibration of days."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from grainfit.analysis.recorded_size import changes_in_words
from grainfit.bulk_tests.abilities import material_faults, user_functions
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import coarse_grained, factor_words, sized_for
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.bulk_tests.size import TWIN, twin_of
from grainfit.bulk_tests.stiffness import overlap_law, stiffness_number
from grainfit.bulk_tests.time_steps import with_safe_time_step
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.contact_models.registry import is_load_dependent
from grainfit.errors import InputError
from grainfit.formatting import counted, duration, number
from grainfit.solvers.base import Solver
from grainfit.solvers.speed import gain_of_ranks

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
            yield (
                context.key(test, "timeout"),
                f"Test {test}: timeout = {duration(limit)}, but a run takes about "
                f"{duration(seconds)} and would be stopped before its end. Leave timeout out, or "
                "give several times as much.",
            )


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
            f"{counted(workers, 'run')} at a time with {file.ranks} MPI ranks each take "
            f"{workers * file.ranks} cores, and there are {file.cores}: ranks then wait for each "
            "other, and a run takes many times as long. Use fewer workers, or ranks = 1.",
        )
    elif time is not None:
        gains = {t.name: gain_of_ranks(int(t.options.get("ranks", 1))) for t in file.tests}
        costs = {test: seconds * gains[test] for test, seconds in time.costs.items()}
        alone = replace(time, costs=costs, workers=file.cores)
        if alone.seconds[1] <= _WORTH_IT * time.seconds[1]:
            yield (
                "",
                f"With {file.ranks} MPI ranks a run and {counted(workers, 'run')} at a time, the "
                f"calibration takes {time}; with ranks = 1 and {counted(file.cores, 'run')} at a "
                f"time, {alone}. Ranks pay where one run alone is waited for.",
            )


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
            shorter.append(f"with {change}, it would take {faster}")
    remedy = (
        f"Shorter: {'; '.join(shorter)}."
        if shorter
        else "More workers shorten it: a computer with more cores, or a cluster (docs/clusters.md)."
    )
    yield "", f"The calibration takes {time}. {remedy}"


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
        words = (
            f"the usual dimensions of the {test.type} test ({usual.number_of_particles} "
            f"particles), measured in an apparatus of that size"
        )
        yield words + _moved(context, {name: usual.number_of_particles}), {name: seconds}


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
    words = (
        f"{MODULUS} = {number(needed / 1e6, 2)} MPa, whose overlaps add "
        f"{100 * _TOLERATED_EXCESS:.0f} % to bulk densities"
    )
    yield words, seconds


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
        words = (
            f"{factor_words(coarser)}, fewer and larger particles in the same apparatus "
            "(docs/coarse_graining.md)"
        )
        fewer = {name: test.number_of_particles for name, test in coarser.items()}
        yield words + _moved(context, fewer), seconds


def _twin(context: FileContext) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Offer a search in smaller apparatus with the same particles, for targets at that size."""
    seconds: dict[str, float] = {}
    for name, solver, test in _known_tests(context):
        if (twin := twin_of(test)) is not None:
            cost = solver.estimate_cost_of(twin, _material(context, solver))
            seconds[name] = cost.wall_seconds
    if seconds:
        words = (
            f"smaller apparatus that hold {TWIN} particles (strategy.twins = {TWIN} searches in "
            "them and predicts the real ones: one run of each, and a series of sizes, come on top)"
        )
        yield words + _moved(context, dict.fromkeys(seconds, TWIN)), seconds


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
        if test is not None and not user_functions(test):
            yield name, solver, test


def _refuses(
    context: FileContext, modulus: float, _name: str, solver: Solver, test: BulkTest
) -> bool:
    """Return whether a test means nothing with particles of a Young's modulus."""
    return any(material_faults(test, {**_material(context, solver), MODULUS: modulus}))


def _material(context: FileContext, solver: Solver) -> dict[str, float]:
    return solver.run_parameters(context.problem.middle)
