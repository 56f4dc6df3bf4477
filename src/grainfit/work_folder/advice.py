"""Advice for a calibration: simulate further tests along the directions that are open."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.calibration_file.accuracies import Accuracies, accuracy_of, read_accuracies
from grainfit.campaign.batch import ExpectedWork
from grainfit.errors import InputError
from grainfit.one_thread import one_thread
from grainfit.solvers.base import Solver
from grainfit.which_test import messages
from grainfit.which_test.available import available_tests, material_of, types_of
from grainfit.which_test.candidate import seconds_of
from grainfit.which_test.further_response import further_response
from grainfit.which_test.knowledge import Knowledge
from grainfit.which_test.next_test import Advice, OpenParameters, rank_tests
from grainfit.which_test.simulation import Simulation, require_simulated
from grainfit.which_test.slopes import Cloud
from grainfit.which_test.told_by_atlas import of_dry_spheres, told_tests
from grainfit.work_folder import messages as of_work_folder
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.solvers_of_runs import solvers_of


@one_thread()
def advise(
    saved: SavedCalibration,
    *,
    tests: Sequence[str] = (),
    accuracies: Mapping[str, str | float] | None = None,
    simulate: bool = False,
    seeds: int | None = None,
    max_seconds: float | None = None,
    workers: int | None = None,
    workdir: str | Path | None = None,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> Advice:
    """Compute which further test would settle the parameters that the runs leave open.

    A test helps as far as its responses differ between the parameter sets that agree with the
    measurements, by more than they scatter and by more than a laboratory measures. The atlas tells
    so of every bulk test that the calibration does not have. Or these are simulated at a few such
    sets, spread along the principal directions of the posterior distribution.

    Parameters
    ----------
    saved : SavedCalibration
        A calibration, finished or not.
    tests : sequence of str
        Types of test to compare; by default all bulk tests.
    accuracies : mapping of str to str or float, optional
        Accuracies of measurements that replace the usual ones, by name of the response.
    simulate : bool
        Simulate the tests instead of asking the atlas.
    seeds : int, optional
        When simulating, seeds of each parameter set; by default 2, or as many as ``max_seconds``
        allows.
    max_seconds : float, optional
        Wall time after which no more is simulated, s.
    workers : int, optional
        Runs at a time; by default those of the calibration.
    workdir : path, optional
        Where runs are kept; by default the work folder. After Ctrl-C, another call continues.
    on_start : callable, optional
        Called with the expected work before the first run; it may raise to stop.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.

    Returns
    -------
    Advice
        `print` shows it as a table and in words.

    Raises
    ------
    InputError
        The calibration has no posterior yet, its tests are models of the user, or an option is
        impossible.
    SolverNotFoundError
        A program is not found.
    StoreError
        The folder cannot be used, for example because the calibration is running.

    Examples
    --------
    >>> import grainfit as gf
    >>> print(gf.open("beads.grainfit").advise())  # doctest: +SKIP
    """
    require_simulated(
        simulate, seeds=seeds, max_seconds=max_seconds, workers=workers, workdir=workdir
    )
    given = read_accuracies(accuracies or {})
    folder = Path(workdir or saved.folder)
    number = saved.workers if workers is None else workers
    simulation = Simulation(folder, number, seeds, max_seconds, on_start, on_progress)
    values = _posterior_values(saved)
    cloud = Cloud.of(saved.problem.parameters, values)
    solvers = solvers_of(saved, of_work_folder.ADVICE_FOR_BULK_TESTS())
    medians = dict(zip(cloud.names, np.median(values, axis=0).tolist(), strict=True))
    today = _today(saved, cloud.knowledge, medians, solvers)
    if not today.parameters:
        return Advice(today)
    material = material_of(solvers, medians)
    told = cloud.thinned
    open_ones = [parameter.name for parameter in today.parameters]
    own = further_response(cloud.knowledge, open_ones, solvers, today.measured, told)
    fitted = types_of(solvers)
    others = available_tests(saved.problem.parameters, solvers, material, tests).without(
        {test: messages.IS_FITTED() for test in tests if test in fitted}
    )
    of_response = partial(_accuracy, given)
    if not simulate or not others.solvers:
        candidates, missing = told_tests(others.solvers, told, of_response)
        remarks = (
            *filter(None, [own]),
            *of_dry_spheres(messages.ATLAS_OF_DRY_SPHERES, others.solvers, medians),
            *others.without(missing).remarks(),
        )
        return rank_tests(today, candidates, remarks)
    points = [dict(zip(cloud.names, values[i].tolist(), strict=True)) for i in cloud.spread()]
    found = simulation.candidates(others, cloud, points, of_response)
    remarks = (*filter(None, (own,)), *found.remarks)
    return rank_tests(today, found.candidates, remarks, len(points), found.seeds)


def _accuracy(given: Accuracies, test: str, name: str, info: ResponseInfo) -> Accuracy:
    return accuracy_of(test, name, info.unit, given)


def _posterior_values(saved: SavedCalibration) -> NDArray[np.float64]:
    """Return a sample of the parameter sets that agree with the measurements."""
    folder = str(saved.folder)
    if saved.why_nothing_agrees:
        fault = messages.NOTHING_AGREES.fault("", why=saved.why_nothing_agrees)
        raise InputError(fault, folder)
    analysis = saved.analyse_parameters()
    if analysis.posterior is None:
        why = " ".join(analysis.notes) or messages.TOO_FEW_RUNS_YET()
        raise InputError(messages.NO_POSTERIOR.fault("", why=why), folder)
    return analysis.posterior.values


def _today(
    saved: SavedCalibration,
    knowledge: Knowledge,
    medians: Mapping[str, float],
    solvers: Mapping[str, Solver],
) -> OpenParameters:
    intervals = saved.intervals
    free = [p for p in saved.problem.parameters if not intervals[p.name].is_determined]
    seconds = sum(seconds_of(solver, medians) for solver in solvers.values())
    return OpenParameters(
        tuple(free), intervals, medians, knowledge, seconds, saved.problem.responses
    )
