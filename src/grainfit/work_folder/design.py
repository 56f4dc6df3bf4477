"""Design of a laboratory programme: which tests would settle the free parameters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from scipy.stats import qmc

from grainfit.analysis.advice import CandidateTest
from grainfit.analysis.bench import Bench, material_of, other_tests
from grainfit.analysis.further_tests import without_the_bench
from grainfit.analysis.information import Knowledge, recorded_measurable
from grainfit.analysis.limits_of_trials import are_dry_spheres, unrecorded_effects
from grainfit.analysis.slopes import Cloud, corners
from grainfit.analysis.test_plan import TestPlan, plan_tests
from grainfit.analysis.wall_sensitivities import on_walls
from grainfit.calibration_file.accuracies import read_accuracies
from grainfit.calibration_file.planned import PlannedFile, load_planned_file
from grainfit.campaign.batch import ExpectedWork
from grainfit.campaign.work_folder import default_workdir
from grainfit.checks import as_number
from grainfit.errors import Fault, InputError
from grainfit.formatting import counted
from grainfit.problem import Parameter
from grainfit.work_folder.candidates import AccuracyOf, Simulation, seconds_of

#: Positions in the intervals that are simulated, on each side of the middle.
_SIDE = 0.35
#: Members of an even spread over the intervals.
_SPREAD = 1024
_FAR_FROM_THE_TRIALS = (
    "The recorded slopes are those of spheres without cohesion; --simulate finds those of this "
    "material."
)
_RECORDED = "Slopes are recorded ones, see docs/choosing_tests.md."


def design(
    source: str | Path | PlannedFile,
    *,
    wanted: float = 0.2,
    tests: Sequence[str] = (),
    accuracies: Mapping[str, str | float] | None = None,
    simulate: bool = False,
    seeds: int | None = None,
    max_seconds: float | None = None,
    workers: int | None = None,
    workdir: str | Path | None = None,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> TestPlan:
    """Rank combinations of tests by whether they would settle the free parameters, and by cost.

    Nothing is simulated unless asked for: slopes of the responses are the recorded sensitivities
    in the middle of the intervals.

    Parameters
    ----------
    source : path or PlannedFile
        Calibration file; measured values may be missing. Its tests are compared with the options
        and accuracies that it gives, all others of the bench with the usual ones.
    wanted : float
        Wanted half-width of the 95 % interval of every free parameter, a share of its value.
    tests : sequence of str
        Types of test to compare; by default all of the bench.
    accuracies : mapping of str to str or float, optional
        Accuracies of measurements that replace those of the file and the usual ones.
    simulate : bool
        Simulate the tests at a few points of the intervals instead.
    seeds, max_seconds, workers, workdir, on_start, on_progress
        As for `grainfit.work_folder.advice.advise`, when simulating; the work folder is that of
        the file.

    Returns
    -------
    TestPlan
        `print` shows it as a table and in words.

    Raises
    ------
    InputError
        The file has a fault, none of its tests is a bulk test, or an option is impossible.
    SolverNotFoundError
        A program is not found.
    StoreError
        The work folder cannot be used.

    Examples
    --------
    >>> import grainfit as gf
    >>> print(gf.design("plan.toml", wanted=0.3))  # doctest: +SKIP
    """
    given = read_accuracies(accuracies or {})
    if not as_number(wanted) > 0:
        raise InputError(Fault("wanted", f"is {wanted!r}.", "Give a share above 0, such as 0.2."))
    planned = source if isinstance(source, PlannedFile) else load_planned_file(source)
    parameters = planned.file.parameters
    middle = {p.name: p.from_unit(0.5) for p in parameters}
    bench = _bench(planned, middle, tests)
    accuracy = partial(planned.accuracy, given)
    if not simulate:
        found, missing = _recorded(planned, bench, middle, accuracy)
        without = unrecorded_effects(bench.solvers, middle)
        nowhere = [name for name, tests in without.items() if tests == list(bench.solvers)]
        before = Knowledge.of_intervals(parameters).without(nowhere)
        is_recorded = are_dry_spheres(bench.solvers, material_of(bench.solvers, middle))
        remarks = [
            *bench.without(missing).remarks(),
            *(() if is_recorded else (_FAR_FROM_THE_TRIALS,)),
            *_remarks_on_unrecorded(without, nowhere),
        ]
        recorded = found if before.names else []
        return plan_tests(recorded, before, wanted, remarks, _RECORDED, taken_as_known=nowhere)
    cloud = _even_spread(parameters)
    points = _points(parameters)
    folder = Path(workdir or default_workdir(planned.file.path))
    number = planned.workers if workers is None else workers
    simulation = Simulation(folder, number, seeds, max_seconds, on_start, on_progress)
    compared = simulation.compare(bench, cloud, points, accuracy)
    seeds_of_each = counted(compared.seeds, "seed")
    source_words = f"Slopes from {len(points)} points of the intervals, {seeds_of_each} each."
    return plan_tests(compared.candidates, cloud.knowledge, wanted, compared.remarks, source_words)


def _bench(planned: PlannedFile, middle: Mapping[str, float], tests: Sequence[str]) -> Bench:
    """Return the tests of the file, then the others of the bench."""
    own = {name: s for name, s in planned.solvers.items() if s.bulk_test is not None}
    material = material_of(own, middle)
    others = other_tests(planned.file.parameters, planned.solvers, material, tests)
    models = dict.fromkeys(
        planned.solvers.keys() - own.keys(),
        "It is a model of your own, whose sensitivities are not known.",
    )
    kept = {
        name: solver
        for name, solver in own.items()
        if not tests or (solver.bulk_test and solver.bulk_test.type in tests)
    }
    return Bench(
        {**kept, **others.solvers}, {**models, **others.refused}, others.options, others.enlarged
    )


def _recorded(
    planned: PlannedFile, bench: Bench, middle: Mapping[str, float], accuracy_of: AccuracyOf
) -> tuple[list[CandidateTest], dict[str, str]]:
    """Return tests with their recorded slopes, and those that have none."""
    found, missing = [], {}
    for test, solver in bench.solvers.items():
        material = solver.run_parameters(middle)
        assert solver.bulk_test is not None, "the bench has bulk tests only"
        responses = [
            recorded_measurable(
                f"{test}.{name}",
                on_walls(info, solver),
                material,
                planned.value(test, name, info),
                accuracy,
            )
            for name, info in solver.bulk_test.responses.items()
            if (accuracy := accuracy_of(test, name, info)) is not None
        ]
        known = tuple(response for response in responses if response is not None)
        if known:
            found.append(CandidateTest(test, seconds_of(solver, middle), known))
        else:
            missing[test] = "Its sensitivities are not recorded; --simulate finds them."
    return found, missing


def _remarks_on_unrecorded(
    without: Mapping[str, Sequence[str]], nowhere: Collection[str]
) -> Iterator[str]:
    """Yield sentences on parameters whose effect is not recorded: on any test, or on some."""
    for name, tests in without.items():
        if name in nowhere:
            yield (
                f"The effect of {name} is not recorded: it counts as known. --simulate finds it. "
                f"{without_the_bench(name)}".rstrip()
            )
            continue
        for test in tests:
            yield f"The effect of {name} on {test} is not recorded; --simulate finds it."


def _points(parameters: Sequence[Parameter]) -> list[dict[str, float]]:
    """Return the middle of the intervals and corners of a smaller box within them."""
    positions = 0.5 + _SIDE * np.vstack([np.zeros(len(parameters)), corners(len(parameters))])
    return [
        {p.name: p.from_unit(float(x)) for p, x in zip(parameters, position, strict=True)}
        for position in positions
    ]


def _even_spread(parameters: Sequence[Parameter]) -> Cloud:
    unit = qmc.Sobol(len(parameters), rng=np.random.default_rng(1)).random(_SPREAD)
    columns = [[p.from_unit(float(x)) for x in unit[:, i]] for i, p in enumerate(parameters)]
    return Cloud.of(tuple(parameters), np.array(columns).T)
