"""Simulate the tests at one parameter set with several seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from grainfit.analysis.scatter import RepeatedRuns, scatter_over_seeds
from grainfit.calibration.records_read import RecordsRead
from grainfit.calibration_file.build import CalibrationSetup, load_calibration
from grainfit.campaign.batch import ExpectedWork, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.work_folder import simulations_folder
from grainfit.errors import InputError
from grainfit.evaluation import Evaluation, Proposal, Response, response_name
from grainfit.formatting import in_a_row
from grainfit.strategies.seeds import LARGEST_SEED
from grainfit.validation import plain, whole_number_faults
from grainfit.work_folder import messages
from grainfit.work_folder.given_material import answer_for, in_place_of_fixed
from grainfit.work_folder.saved_calibration import SavedCalibration


def repeat_runs(
    source: str | Path | CalibrationSetup,
    *,
    repeat: int = 10,
    seed: int = 1,
    settings: Sequence[str] = (),
    answer_of: str | Path | SavedCalibration | None = None,
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
    answer_of : path or SavedCalibration, optional
        A calibration or its work folder, whose answer takes the place of the middle: simulate it in
        another test, at another size, with another solver.
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
        The file has faults, a number is not a whole one from 1 on, or the answer is missing or
        leaves a free parameter open.
    SolverNotFoundError
        A program is not found.
    StoreError
        A folder cannot be used.

    Examples
    --------
    >>> import grainfit as gf
    >>> runs = gf.repeat_runs("beads.toml", repeat=20)  # doctest: +SKIP
    >>> runs["angle_of_repose"].standard_deviation  # doctest: +SKIP
    """
    setup = source if isinstance(source, CalibrationSetup) else load_calibration(source)
    workers = setup.workers if workers is None else plain(workers)
    repeat, seed = plain(repeat), plain(seed)
    _require_counts(repeat=repeat, seed=seed, workers=workers)
    answer: Mapping[str, float] = {}
    if answer_of is not None:
        answer = answer_for(setup, SavedCalibration.of(answer_of), settings)
    values = setup.values(settings, answer)
    proposals = [Proposal(values, seed + number, "design") for number in range(repeat)]
    evaluations = simulate_batch(
        setup.solvers,
        proposals,
        Path(workdir or simulations_folder(setup.file.path)),
        CampaignOptions(workers, setup.timeouts),
        on_start,
        on_progress,
    )
    found = scatter_over_seeds(
        evaluations, setup.problem.targets, _units(setup), setup.problem.curves
    )
    records = RecordsRead(setup.solvers, dict.fromkeys(setup.solvers, 1))
    remarks = (
        *in_place_of_fixed(setup, answer, settings),
        *records.read_again(found.evaluations),
        *_remarks(setup, found.evaluations),
    )
    return replace(found, remarks=remarks)


def _units(setup: CalibrationSetup) -> dict[str, str]:
    return {
        response_name(test, name, len(setup.solvers)): response.unit
        for test, bulk_test in setup.bulk_tests.items()
        for name, response in bulk_test.responses.items()
    }


def _remarks(setup: CalibrationSetup, evaluations: Sequence[Evaluation]) -> Iterator[str]:
    """Yield what tests say of their responses, each with its seeds."""
    for name, test in setup.bulk_tests.items():
        names = {key: response_name(name, key, len(setup.solvers)) for key in test.responses}
        seeds: dict[str, list[str]] = {}
        for evaluation in evaluations:
            known = evaluation.responses
            for key, full in names.items():
                meaning, found = test.responses[key].at_zero, known.get(full)
                if meaning and isinstance(found, Response) and found.value == 0:
                    seeds.setdefault(meaning, []).append(str(evaluation.proposal.seed))
        for words, those in seeds.items():
            yield f"{name} {words} (seed {in_a_row(those)})."


def _require_counts(**given: int) -> None:
    faults = whole_number_faults(given)
    if not faults and given["seed"] + given["repeat"] - 1 > LARGEST_SEED:
        faults = [
            messages.SEED_TOO_LARGE.fault(
                "seed", seed=given["seed"], repeat=given["repeat"], largest=LARGEST_SEED
            )
        ]
    InputError.raise_for(faults)
