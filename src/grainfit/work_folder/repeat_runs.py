"""Simulate the tests at one parameter set with several seeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from grainfit.analysis.scatter import RepeatedRuns, scatter_over_seeds
from grainfit.calibration_file.build import CalibrationSetup, load_calibration
from grainfit.campaign.batch import ExpectedWork, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.work_folder import simulations_folder
from grainfit.checks import count_faults
from grainfit.errors import Fault, InputError
from grainfit.evaluation import Proposal, response_name
from grainfit.strategies.seeds import LARGEST_SEED


def repeat_runs(
    source: str | Path | CalibrationSetup,
    *,
    repeat: int = 10,
    seed: int = 1,
    settings: Sequence[str] = (),
    workdir: str | Path | None = None,
    workers: int | None = None,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> RepeatedRuns:
    """Simulate every test with several seeds: mean and scatter of its responses.

    Before a calibration this shows how much single runs scatter, compared with the tolerances.

    Parameters
    ----------
    source : path or CalibrationSetup
        The calibration file.
    repeat : int
        Runs of each test.
    seed : int
        The first insertion seed; the others follow it.
    settings : sequence of str
        ``NAME=VALUE``; free parameters that are not set take the middle of their interval.
    workdir : path, optional
        Where runs are kept; by default the file's name with ``.simulated``, here. After Ctrl-C,
        another call continues.
    workers : int, optional
        Runs at a time; by default those of the file.
    on_start : callable, optional
        Called with the expected work before the first run.
    on_progress : callable, optional
        Called with the numbers of finished and of all seeds.

    Returns
    -------
    RepeatedRuns
        `print` shows it as a table.

    Raises
    ------
    InputError
        The file has faults, or a number is not a whole one from 1 on.
    SolverNotFoundError
        A program is not found.
    StoreError
        The folder cannot be used.

    Examples
    --------
    >>> import grainfit as gf
    >>> runs = gf.repeat_runs("beads.toml", repeat=20)  # doctest: +SKIP
    >>> runs["angle_of_repose"].standard_deviation  # doctest: +SKIP
    """
    setup = source if isinstance(source, CalibrationSetup) else load_calibration(source)
    workers = setup.workers if workers is None else workers
    _require_counts(repeat=repeat, seed=seed, workers=workers)
    values = setup.values(settings)
    proposals = [Proposal(values, seed + number, "design") for number in range(repeat)]
    evaluations = simulate_batch(
        setup.solvers,
        proposals,
        Path(workdir or simulations_folder(setup.file.path)),
        CampaignOptions(workers, setup.timeouts),
        on_start,
        on_progress,
    )
    return scatter_over_seeds(evaluations, setup.problem.targets, _units(setup))


def _units(setup: CalibrationSetup) -> dict[str, str]:
    return {
        response_name(test, name, len(setup.solvers)): response.unit
        for test, bulk_test in setup.bulk_tests.items()
        for name, response in bulk_test.responses.items()
    }


def _require_counts(**given: int) -> None:
    faults = count_faults(given)
    if not faults and given["seed"] + given["repeat"] - 1 > LARGEST_SEED:
        words = (
            f"{given['seed']} and the {given['repeat']} seeds from it on go beyond {LARGEST_SEED}."
        )
        faults = [Fault("seed", words, "Give a smaller one.")]
    if faults:
        raise InputError(faults)
