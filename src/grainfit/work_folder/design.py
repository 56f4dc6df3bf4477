"""Plan of laboratory measurements: which tests would settle the free parameters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from grainfit.calibration_file.accuracies import read_accuracies
from grainfit.calibration_file.planned import PlannedFile, load_planned_file
from grainfit.campaign.batch import ExpectedWork
from grainfit.campaign.work_folder import default_workdir
from grainfit.errors import InputError
from grainfit.formatting import counted, in_a_row
from grainfit.one_thread import one_thread
from grainfit.problem import Parameter
from grainfit.validation import as_number
from grainfit.which_test import messages
from grainfit.which_test.available import AvailableTests, available_tests, material_of
from grainfit.which_test.candidate import AccuracyOf, Candidate, knowledge_after
from grainfit.which_test.determining_tests import other_measurement
from grainfit.which_test.further_response import further_response
from grainfit.which_test.knowledge import Knowledge
from grainfit.which_test.measurement_plan import MeasurementPlan, rank_combinations
from grainfit.which_test.simulation import Simulation, require_simulated
from grainfit.which_test.slopes import Cloud, corners
from grainfit.which_test.told_by_atlas import of_dry_spheres, told_tests, untold_effects

#: Positions in the intervals that are simulated, on each side of the middle.
_SIDE = 0.35


@one_thread()
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
) -> MeasurementPlan:
    """Rank combinations of tests by whether they would settle the free parameters, and by cost.

    Nothing is simulated unless asked for: slopes of the responses are those of the atlas over the
    intervals.

    Parameters
    ----------
    source : path or PlannedFile
        Calibration file; measured values may be missing. Its tests are compared with the options
        and accuracies that it gives, all others with the usual ones.
    wanted : float
        Wanted half-width of the 95 % interval of every free parameter, a share of its value.
    tests : sequence of str
        Types of test to compare; by default all bulk tests.
    accuracies : mapping of str to str or float, optional
        Accuracies of measurements that replace those of the file and the usual ones.
    simulate : bool
        Simulate the tests at a few points of the intervals instead.
    seeds, max_seconds, workers, workdir, on_start, on_progress
        As for `grainfit.work_folder.advice.advise`, when simulating; the work folder is that of
        the file.

    Returns
    -------
    MeasurementPlan
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
    require_simulated(
        simulate, seeds=seeds, max_seconds=max_seconds, workers=workers, workdir=workdir
    )
    given = read_accuracies(accuracies or {})
    if not as_number(wanted) > 0:
        raise InputError(messages.NO_SHARE.fault("wanted", given=wanted))
    planned = source if isinstance(source, PlannedFile) else load_planned_file(source)
    compared = _tests(planned, tests)
    accuracy = partial(planned.accuracy, given)
    if not simulate:
        return _by_atlas(planned, compared, accuracy, wanted)
    parameters = planned.file.parameters
    folder = Path(workdir or default_workdir(planned.file.path))
    number = planned.workers if workers is None else workers
    simulation = Simulation(folder, number, seeds, max_seconds, on_start, on_progress)
    cloud, points = Cloud.even(parameters), _points(parameters)
    found = simulation.candidates(compared, cloud, points, accuracy)
    seeds_of_each = counted(found.seeds, "seed")
    slopes = f"Slopes from {len(points)} points of the intervals, {seeds_of_each} each."
    return rank_combinations(found.candidates, cloud.knowledge, wanted, found.remarks, slopes)


def _middle(planned: PlannedFile) -> dict[str, float]:
    return {p.name: p.from_unit(0.5) for p in planned.file.parameters}


def _tests(planned: PlannedFile, tests: Sequence[str]) -> AvailableTests:
    """Return the tests of the file, then all other bulk tests."""
    own = {name: s for name, s in planned.solvers.items() if s.bulk_test is not None}
    material = material_of(own, _middle(planned))
    others = available_tests(planned.file.parameters, planned.solvers, material, tests)
    models = dict.fromkeys(planned.solvers.keys() - own.keys(), messages.OWN_MODEL())
    kept = {
        name: solver
        for name, solver in own.items()
        if not tests or (solver.bulk_test and solver.bulk_test.type in tests)
    }
    return others.beside(kept, models)


def _by_atlas(
    planned: PlannedFile, compared: AvailableTests, accuracy_of: AccuracyOf, wanted: float
) -> MeasurementPlan:
    middle, solvers = _middle(planned), compared.solvers
    cloud = Cloud.even(planned.file.parameters)
    found, missing = told_tests(solvers, cloud, accuracy_of)
    without = untold_effects(solvers, cloud)
    told = {candidate.name for candidate in found}
    nowhere = [name for name, tests in without.items() if {*tests} >= told]
    before = Knowledge.of_intervals(planned.file.parameters).without(nowhere)
    remarks = [
        *compared.without(missing).remarks(),
        *of_dry_spheres(messages.ATLAS_OF_DRY_SPHERES, solvers, middle),
        *_remarks_on_untold(without, nowhere),
        *_remarks_on_own(planned, [c for c in found if c.name in planned.solvers], before, cloud),
    ]
    return rank_combinations(
        found if before.names else [],
        before,
        wanted,
        remarks,
        messages.SLOPES_BY_ATLAS(),
        taken_as_known=nowhere,
    )


def _remarks_on_own(
    planned: PlannedFile, own: Sequence[Candidate], before: Knowledge, cloud: Cloud
) -> Iterator[str]:
    """Yield a sentence on a response of the tests of the file that the file leaves out."""
    solvers = {candidate.name: planned.solvers[candidate.name] for candidate in own}
    known = knowledge_after(before, own)
    several = len(solvers) > 1
    measured = [r.name if several else r.short_name for c in own for r in c.responses]
    if further := further_response(known, known.names, solvers, measured, cloud):
        yield further


def _remarks_on_untold(
    without: Mapping[str, Sequence[str]], nowhere: Collection[str]
) -> Iterator[str]:
    """Yield sentences on parameters of which the atlas does not tell, for any test or some."""
    for name, tests in without.items():
        if name in nowhere:
            otherwise = other_measurement(name)
            yield messages.COUNTS_AS_KNOWN(name=name, otherwise=otherwise).rstrip()
        else:
            yield messages.EFFECT_ON_TESTS_NOT_TOLD(name=name, tests=in_a_row(tests))


def _points(parameters: Sequence[Parameter]) -> list[dict[str, float]]:
    """Return the middle of the intervals and corners of a smaller box within them."""
    positions = 0.5 + _SIDE * np.vstack([np.zeros(len(parameters)), corners(len(parameters))])
    return [
        {p.name: p.from_unit(float(x)) for p, x in zip(parameters, position, strict=True)}
        for position in positions
    ]
