"""Run a complete calibration, from the first run to the verified answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from grainfit.calibration import messages
from grainfit.calibration.holdout import Holdout, require_holdouts
from grainfit.calibration.holdouts_after import HoldoutsAfter
from grainfit.calibration.live_file import LiveFile
from grainfit.calibration.loop import CalibrationLoop, LoopOptions
from grainfit.calibration.options import CalibrationOptions
from grainfit.calibration.progress import Progress
from grainfit.calibration.provenance import Provenance
from grainfit.calibration.readiness import require_ready
from grainfit.calibration.runs_to_come import largest_scatter, with_recorded_scatters
from grainfit.calibration.scopes import relatives_of, repeats_of, restricted, with_scopes
from grainfit.calibration.timeouts import default_timeouts, read_timeout
from grainfit.calibration.twins import Twins
from grainfit.campaign import messages as of_campaign
from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.keep import Keep
from grainfit.campaign.near_runs import take_near_runs
from grainfit.campaign.reuse import needed_responses, take_runs
from grainfit.campaign.store.shared import SharedRuns, share
from grainfit.campaign.store.source import open_source
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.unused_source import why_unused
from grainfit.campaign.work_folder import RESULT_NAME, recover
from grainfit.errors import Fault, InputError
from grainfit.ground_messages import CANNOT_BE_WRITTEN
from grainfit.one_thread import one_thread
from grainfit.problem import Problem
from grainfit.result import Result
from grainfit.solvers.base import Solver
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.strategies.base import Strategy
from grainfit.strategies.budget import start_search
from grainfit.strategies.registry import DEFAULT_STRATEGY, as_strategy
from grainfit.validation import (
    kind_faults,
    mapping_faults,
    plain,
    whole_number_faults,
)
from grainfit.verdict.options import VERDICT


@runtime_checkable
class _TakesTasks(Protocol):
    """An executor, also one that does not inherit from that of `concurrent.futures`."""

    def submit(self, task: Callable[..., Any], /, *args: Any) -> Any:
        """Start a task."""


#: Kinds of arguments, and what to give.
_KINDS: Mapping[str, tuple[Any, str]] = {
    "problem": (Problem, "a Problem; a file is calibrated by grainfit.load(file).calibrate()"),
    "name": (str, "a text"),
    "workdir": (str | PathLike | None, "the path of a folder"),
    "twins": (Twins | None, "a Twins object"),
    "executor": (_TakesTasks | None, "an Executor of concurrent.futures"),
    "provenance": (Provenance | None, "a Provenance object"),
    "on_progress": (Callable | None, "a function of a Progress"),
    "near_runs": (bool, "True or False"),
    "atlas": (bool, "True or False"),
    "retry_failed": (bool, "True or False"),
    "progress": (bool, "True or False"),
}

Simulate = (
    Callable[[dict[str, float], int], Mapping[str, Any]]
    | Callable[[dict[str, float]], Mapping[str, Any]]
    | Solver
    | Mapping[str, Solver]
)


def calibrate(
    problem: Problem,
    simulate: Simulate,
    *,
    strategy: str | Strategy = DEFAULT_STRATEGY,
    max_runs: int | None = None,
    workers: int = 1,
    seed: int = 1,
    workdir: str | Path | None = None,
    name: str = "",
    verification_runs: int | None = None,
    timeouts: Mapping[str, float | str] | None = None,
    repeats: int | Mapping[str, int] = 1,
    relatives: Mapping[str, Solver] | None = None,
    twins: Twins | None = None,
    holdouts: Sequence[Holdout] = (),
    executor: Executor | None = None,
    runs_from: str | Path | Sequence[str | Path] = (),
    store: str | None = None,
    keep: Keep = "all",
    near_runs: bool = True,
    atlas: bool = True,
    retry_failed: bool = False,
    provenance: Provenance | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    progress: bool = False,
) -> Result:
    """Find the parameters at which the simulated responses meet their targets.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    simulate : callable, Solver, or mapping of str to Solver
        ``simulate(parameters: dict[str, float], seed: int) -> dict[str, float]`` called once per
        run, or ``simulate(parameters)`` of a deterministic model; or a solver; or one solver for
        each of several tests, by name of the test: responses are then called ``test.response``.
    strategy : str or Strategy
        Search strategy: ``"sequential"`` places each run where it is expected to improve the answer
        most; ``"staged"`` follows the three steps of the method. Or an object with options, such as
        ``grainfit.Sequential(prefer="accuracy")``, or of a custom class.
    max_runs : int, optional
        Largest number of DEM runs, verification included.
    workers : int
        Number of runs at a time.
    seed : int
        Determines the design and all insertion seeds.
    workdir : path, optional
        Folder in which runs are kept. Started again with the same folder, the calibration continues
        and repeats no finished run. Without it nothing is kept.
    name : str
        Display name of the calibration.
    verification_runs : int, optional
        Fewest runs with fresh seeds at the answer, at least 2; by default 3.
    timeouts : mapping of str to float or str, optional
        Longest wall time of one run by name of the test, s, or a quantity such as ``"10 min"``;
        ``math.inf`` for none. By default that of the solver: for a bulk test 10 minutes plus 100
        times the estimated time of a run.
    repeats : int or mapping of str to int
        Runs with different seeds whose mean is one evaluation, of every test or by name of the
        test; 1 by default.
    relatives : mapping of str to Solver, optional
        Solvers of the cheaper relatives that `Problem.relatives` declares, by name of the test.
        Their runs tell where those of the tests are worth making; no verdict rests on them.
    twins : Twins, optional
        What the solvers simulate instead of the laboratory's larger apparatus, and the ratios of
        the responses: the result is then ``predicted`` at best.
    holdouts : sequence of Holdout
        Tests that take no part in the fit: registered before the first run, and predicted when the
        answer is calibrated.
    executor : concurrent.futures.Executor, optional
        Executor of the runs, ``workers`` at a time: processes, or the nodes of a cluster. They must
        see the work folder at the same path. It is not shut down. By default threads that wait for
        solver processes.
    runs_from : path, str, or sequence of these
        Work folders, or addresses of stores, whose runs are reused if they belong to this problem;
        their targets and intervals may have been different. They are only read.
    store : str, optional
        Address of a store that several processes share, such as
        ``postgresql+psycopg://user@host/database``: no process repeats a run of another.
    keep : {"all", "results"}
        Files of a finished run that are kept: all, or only its record, logs and pictures.
    near_runs : bool
        Let runs of near problems guide the search: those of the same bulk test whose fixed
        parameters and apparatus differ by at most a fifth. No verdict rests on them.
    atlas : bool
        Let the expected responses of the atlas guide the search of the bulk tests that it has. No
        verdict rests on them.
    retry_failed : bool
        Repeat all failed runs of the work folder. By default only those that failed because of the
        machine or a time-out are repeated; others would fail again.
    provenance : Provenance, optional
        Origin of the calibration, for the report.
    on_progress : callable, optional
        Called with `Progress` after every change, and a few times per second.
    progress : bool
        Show a bar in the terminal (on standard error) or the notebook, and lines of text elsewhere.

    Returns
    -------
    Result
        The result; after Ctrl-C with status ``interrupted``.

    Raises
    ------
    InputError
        An argument cannot be used.
    SolverNotFoundError
        The program of a solver is missing.
    RunFailedError
        The first runs all failed, or too few succeeded to continue.
    StoreError
        The work folder or its store cannot be used.

    Examples
    --------
    >>> from grainfit import Parameter, Problem, Target, calibrate
    >>> problem = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])
    >>> result = calibrate(problem, lambda p, seed: {"angle": 10 + 40 * p["friction"]})
    >>> result.status, round(result.parameters["friction"], 2)
    ('calibrated', 0.5)
    """
    _require_kinds(
        problem=problem,
        name=name,
        workdir=workdir,
        twins=twins,
        executor=executor,
        provenance=provenance,
        on_progress=on_progress,
        near_runs=plain(near_runs),
        atlas=plain(atlas),
        retry_failed=plain(retry_failed),
        progress=plain(progress),
    )
    solvers = _solvers(simulate)
    max_runs, verification_runs = plain(max_runs), plain(verification_runs)
    seed, workers = plain(seed), plain(workers)
    _require_options(max_runs, verification_runs, seed=seed, workers=workers, keep=keep)
    chosen = as_strategy(strategy)
    problem = problem if twins is None else twins.problem(problem)
    given_repeats = _repeats(repeats, solvers)
    problem = with_scopes(problem, solvers, given_repeats)
    means = repeats_of(problem, solvers, given_repeats)
    problem = with_recorded_scatters(problem, solvers, means)
    solvers = restricted(problem, solvers)
    cheaper = relatives_of(problem, {} if relatives is None else _by_test("relatives", relatives))
    given_timeouts = {} if timeouts is None else _timeouts(timeouts, solvers)
    _require_ready(problem, solvers, holdouts, cheaper)
    verification_runs = verification_runs or VERDICT.fresh_seeds
    search = start_search(
        chosen,
        problem,
        sum(means.values()),
        seed,
        max_runs,
        verification_runs,
        largest_scatter(problem, solvers, means),
    )
    with ExitStack() as stack:
        show = stack.enter_context(_shown(on_progress)) if progress else on_progress
        options = LoopOptions(
            name,
            workers,
            max_runs,
            verification_runs,
            show,
            provenance,
            twins=twins,
            near_runs=near_runs,
            atlas=atlas,
        )
        stack.enter_context(one_thread())
        # Every run executes in its own folder, where a relative path would mean another place.
        folder = None if workdir is None else Path(workdir).absolute()
        if folder is not None:
            stack.enter_context(hold(folder))
        runs = RunStore.in_memory() if folder is None else RunStore.in_folder(folder)
        stack.callback(runs.close)
        if folder is not None:
            recover(folder, runs)
            options = replace(
                options,
                live_file=stack.enter_context(LiveFile(folder)),
                result_file=folder / RESULT_NAME,
            )
        near_seed = seed if near_runs and chosen.uses_relatives else None
        unused = [*_take_from(_sources(runs_from), problem, solvers, cheaper, runs, near_seed)]
        shared = None
        if store is not None:
            shared = stack.enter_context(share(store, folder, runs))
            shared.patiently(lambda other: take_runs(other, problem, solvers, runs))
            if near_seed is not None:
                shared.patiently(lambda other: take_near_runs(other, problem, solvers, runs, seed))
        if retry_failed:
            _forget_failed(runs, shared)
        limits = default_timeouts(problem, {**solvers, **cheaper}) | given_timeouts
        making = CampaignOptions(
            workers,
            {test: seconds for test, seconds in limits.items() if seconds < math.inf},
            executor,
            keep,
            needed=needed_responses(problem, solvers),
            repeats=means,
            ratios=problem.ratios,
        )
        campaign = Campaign(solvers, runs, folder, making, shared, cheaper, unused)
        stack.callback(campaign.close)
        loop = CalibrationLoop(replace(problem, relatives=()), search, campaign, runs, options)
        after = HoldoutsAfter(holdouts, problem, runs, folder, options, making, shared)
        result = loop.run()
        if loop.earlier_stays:
            return result
        result = replace(result, other_notices=(*unused, *result.other_notices))
        return after.predicted(result, loop.material, partial(_keep, folder=folder))


def _require_kinds(**given: object) -> None:
    """Raise `InputError` for arguments of other kinds than `_KINDS`."""
    InputError.raise_for(
        fault for key, value in given.items() for fault in kind_faults(key, value, *_KINDS[key])
    )


def _require_options(max_runs: int | None, verification_runs: int | None, **needed: Any) -> None:
    """Raise `InputError` for options with values that are not accepted, or None in place of one."""
    InputError.raise_for(
        messages.LEFT_OUT.fault(key) for key, value in needed.items() if value is None
    )
    CalibrationOptions(max_runs=max_runs, verification_runs=verification_runs, **needed)


def _require_ready(
    problem: Problem,
    solvers: Mapping[str, Solver],
    holdouts: Sequence[Holdout],
    cheaper: Mapping[str, Solver],
) -> None:
    require_ready(problem, solvers)
    require_holdouts(problem, solvers, holdouts)
    for solver in cheaper.values():
        solver.check()


def _take_from(
    sources: Iterable[str | Path],
    problem: Problem,
    solvers: Mapping[str, Solver],
    relatives: Mapping[str, Solver],
    runs: RunStore,
    near_seed: int | None,
) -> Iterator[str]:
    """Copy the runs of sources, near ones where they have a seed; yield why one has none."""
    every = {**solvers, **relatives}
    for source in sources:
        with open_source(source) as other:
            take_runs(other, problem, every, runs)
            if near_seed is not None and take_near_runs(other, problem, solvers, runs, near_seed):
                continue
            if why := why_unused(other, problem, every):
                yield of_campaign.NO_RUN_USED(source=other.place, why=why)


@contextmanager
def _shown(on_progress: Callable[[Progress], None] | None) -> Iterator[Callable[[Progress], None]]:
    """Yield a callback that shows the progress and passes it on."""
    from grainfit.calibration.live_progress import LiveProgress

    with LiveProgress() as bar:

        def show(progress: Progress) -> None:
            bar.update(progress)
            if on_progress is not None:
                on_progress(progress)

        yield show


def _keep(result: Result, folder: Path | None) -> Result:
    """Write the result where there is a place for it; if that fails, return it with a notice."""
    if folder is None:
        return result
    path = folder / RESULT_NAME
    try:
        result.to_json(path)
    except OSError as error:
        notice = CANNOT_BE_WRITTEN(path=str(path), reason=error.strerror or error)
        return replace(result, other_notices=(*result.other_notices, notice))
    return result


def _forget_failed(runs: RunStore, shared: SharedRuns | None) -> None:
    failed = [record.identity for record in runs.runs("failed")]
    runs.forget_failed(failed)
    if shared is not None:
        shared.forget_failed(failed)


def _solvers(simulate: Simulate) -> dict[str, Solver]:
    if isinstance(simulate, Solver):
        return {simulate.name: simulate}
    if isinstance(simulate, Mapping):
        InputError.raise_for([] if simulate else [messages.NO_SOLVERS_BY_TEST.fault("simulate")])
        return _by_test("simulate", simulate)
    if callable(simulate):
        return {"simulate": PythonCallable(simulate)}
    raise InputError(messages.NO_SOLVER.fault("simulate", given=simulate))


def _by_test(key: str, given: Mapping[str, Solver]) -> dict[str, Solver]:
    """Return solvers by name of the test."""
    is_mapping = isinstance(given, Mapping) and all(isinstance(name, str) for name in given)
    if not is_mapping or not all(isinstance(solver, Solver) for solver in given.values()):
        raise InputError(messages.NO_SOLVERS_BY_TEST.fault(key))
    return dict(given)


def _repeats(given: int | Mapping[str, int], solvers: Mapping[str, Solver]) -> dict[str, int]:
    """Return the given runs per evaluation by name of the test."""
    if not isinstance(given, Mapping):
        count = plain(given)
        InputError.raise_for(whole_number_faults({"repeats": count}))
        # One run is the default, and leaves what the problem says of its tests.
        return {} if count == 1 else dict.fromkeys(solvers, count)
    counts = {test: plain(count) for test, count in given.items()}
    faults = whole_number_faults({f"repeats.{test}": count for test, count in counts.items()})
    faults += _faults_of_names("repeats", counts, solvers)
    InputError.raise_for(faults)
    return counts


def _faults_of_names(key: str, tests: Iterable[str], solvers: Mapping[str, Solver]) -> list[Fault]:
    return [
        messages.NO_TEST.fault(f"{key}.{test}", tests=", ".join(solvers))
        for test in tests
        if test not in solvers
    ]


def _timeouts(given: Mapping[str, float | str], solvers: Mapping[str, Solver]) -> dict[str, float]:
    """Return the given time-outs by name of the test, s."""
    InputError.raise_for(mapping_faults("timeouts", given, f'{{"{next(iter(solvers))}": 600}}'))
    read = {test: read_timeout(f"timeouts.{test}", value) for test, value in given.items()}
    faults = _faults_of_names("timeouts", given, solvers)
    InputError.raise_for([*faults, *(fault for _, found in read.values() for fault in found)])
    return {test: seconds for test, (seconds, _) in read.items()}


def _sources(runs_from: str | Path | Sequence[str | Path]) -> list[str | Path]:
    """Return the work folders and addresses of stores whose runs are reused."""
    given: Any = runs_from
    is_one = isinstance(given, str | Path) or not isinstance(given, Iterable)
    sources = [given] if is_one else list(given)
    wanted = "a work folder, the address of a store, or a list of these"
    InputError.raise_for(
        fault
        for source in sources
        for fault in kind_faults("runs_from", source, str | PathLike, wanted)
    )
    return sources
