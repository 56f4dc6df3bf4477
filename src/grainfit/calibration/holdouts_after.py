"""Register the hold-outs of a calibration before its first run, and predict them after its end."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from grainfit.calibration.holdout import Holdout, HoldoutProgress, Material, predict_holdout
from grainfit.calibration.loop import LoopOptions
from grainfit.calibration.progress import Progress
from grainfit.calibration.registrations import HoldoutFile
from grainfit.calibration.runs_to_come import RunsToCome
from grainfit.calibration.timeouts import default_timeouts
from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.store.shared import SharedRuns
from grainfit.campaign.store.store import RunStore
from grainfit.errors import RunFailedError
from grainfit.problem import Problem
from grainfit.result import HoldoutResult, Result
from grainfit.result.holdout import HoldoutState
from grainfit.solvers.base import Solver

#: Stage of the progress.
STAGE = "hold-out"


class HoldoutsAfter:
    """Hold-outs of a calibration in its work folder.

    Their targets are registered at once, before any run of this start.

    Parameters
    ----------
    holdouts : sequence of Holdout
        The hold-outs; without any, nothing happens.
    problem : Problem
        Free parameters.
    runs : RunStore
        Store of the work folder.
    folder : Path or None
        The work folder, which this process holds.
    options : LoopOptions
        Options of the calibration: workers, progress, and the text of its file.
    making : CampaignOptions
        Options for the runs of the fitted tests.
    shared : SharedRuns, optional
        Store through which runs are exchanged with other processes.
    """

    def __init__(
        self,
        holdouts: Sequence[Holdout],
        problem: Problem,
        runs: RunStore,
        folder: Path | None,
        options: LoopOptions,
        making: CampaignOptions,
        shared: SharedRuns | None = None,
    ) -> None:
        self._holdouts = holdouts
        self._problem = problem
        self._runs = runs
        self._folder = folder
        self._options = options
        self._making = making
        self._shared = shared
        if not holdouts:
            return
        self._file = HoldoutFile(folder)
        finished = sum(state == "finished" for state in runs.states().values())
        text = "" if options.provenance is None else options.provenance.text
        self._registrations = {
            one.name: self._file.register(one.name, one.measured, text, finished)
            for one in holdouts
        }

    def _make(self, holdout: Holdout, solver: Solver) -> Campaign:
        options = options_of_holdout(holdout, self._problem, self._making)
        solvers = {holdout.name: solver}
        return Campaign(solvers, self._runs, self._folder, options, self._shared)

    def predicted(
        self,
        result: Result,
        material_of: Callable[[Result], Material],
        keep: Callable[[Result], Result],
    ) -> Result:
        """Return a result with its hold-outs; they are simulated where it is calibrated.

        Parameters
        ----------
        result : Result
            Result of the calibration.
        material_of : callable
            Returns the material of a result.
        keep : callable
            Writes a result and returns it: before the first run of a hold-out and after each, so
            that a process that dies loses no verdict.
        """
        if not self._holdouts:
            return keep(result)
        if result.status == "interrupted":
            return keep(self._all(result, "pending"))
        if result.status != "calibrated":
            return keep(self._all(result, "not calibrated"))
        kept = keep(self._all(result, "pending"))
        found = list(kept.holdouts)
        try:
            material = material_of(result)
        except RunFailedError as error:
            failed = [replace(one, state="failed", why=str(error)) for one in found]
            return keep(replace(result, holdouts=tuple(failed)))
        try:
            for place, holdout in enumerate(self._holdouts):
                found[place] = predict_holdout(
                    holdout,
                    material,
                    self._file,
                    self._make,
                    self._show,
                    self._registrations[holdout.name],
                )
                kept = keep(replace(result, holdouts=tuple(found)))
        except KeyboardInterrupt:
            stopped = [_interrupted(one) for one in found]
            return keep(replace(result, holdouts=tuple(stopped)))
        return kept

    def _all(self, result: Result, state: HoldoutState) -> Result:
        found = (
            HoldoutResult(one.name, state, registration=self._registrations[one.name])
            for one in self._holdouts
        )
        return replace(result, holdouts=tuple(found))

    def _show(self, progress: HoldoutProgress) -> None:
        show = self._options.on_progress
        if show is None:
            return
        left = progress.of - progress.done
        campaign = progress.campaign
        show(
            Progress(
                STAGE,
                progress.done,
                campaign.running,
                progress.failed,
                RunsToCome(left, left, left),
                None,
                None,
                campaign.notices,
                pending=campaign.pending_runs,
                jobs=campaign.jobs,
            )
        )


def _interrupted(found: HoldoutResult) -> HoldoutResult:
    return replace(found, state="interrupted") if found.state == "pending" else found


def options_of_holdout(
    holdout: Holdout, problem: Problem, usual: CampaignOptions
) -> CampaignOptions:
    """Return the options for the runs of a hold-out.

    Parameters
    ----------
    holdout : Holdout
        The hold-out.
    problem : Problem
        Free parameters, for the default time-out.
    usual : CampaignOptions
        Options of the fitted tests.
    """
    limits = default_timeouts(problem, {holdout.name: holdout.model})
    if holdout.timeout is not None:
        limits[holdout.name] = holdout.timeout
    return replace(
        usual,
        timeouts={name: limit for name, limit in limits.items() if limit < math.inf},
        needed={holdout.name: holdout.needed} if holdout.needed else {},
        repeats={holdout.name: holdout.repeats},
        ratios={},
    )
