"""Register the hold-outs of a calibration before its first run, and predict them after its end."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from grainfit.calibration.holdout import (
    Holdout,
    Material,
    predict_holdout,
)
from grainfit.calibration.holdout_runs import HoldoutProgress
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
from grainfit.result.holdout import HOLDOUT_STAGE, HoldoutState
from grainfit.solvers.base import Solver


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
        self._identity = ""
        #: Why hold-outs were given up, and notices of the campaigns, as they came.
        self._said: list[str] = []
        self._taken = 0
        #: Wall times of all runs that were made, s, by place of the hold-out.
        self._seconds: dict[int, float] = {}
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
        self._identity, started = result.identity, time.monotonic()
        pending = self._all(result, "pending")
        found = list(pending.holdouts)
        try:
            # A watch does not take what is kept now for the end.
            self._show(())
            keep(pending)
            self._predict(result, material_of(result), found, keep)
        except RunFailedError as error:
            found = _ended(found, "failed", str(error))
        except KeyboardInterrupt:
            found = _ended(found, "interrupted")
        result = self._with_time(result, time.monotonic() - started)
        return keep(replace(result, holdouts=tuple(found)))

    def _with_time(self, result: Result, seconds: float) -> Result:
        """Return a result with the time that its hold-outs took, and the share of busy workers."""
        workers, whole = self._options.workers, result.wall_seconds + seconds
        busy = result.utilisation * result.wall_seconds * workers + sum(self._seconds.values())
        utilisation = min(1.0, busy / (workers * max(whole, 1e-9)))
        return replace(result, wall_seconds=whole, utilisation=utilisation)

    def _predict(
        self,
        result: Result,
        material: Material,
        found: list[HoldoutResult],
        keep: Callable[[Result], Result],
    ) -> None:
        """Predict each hold-out in place of what is known of it, and keep it."""
        for place, holdout in enumerate(self._holdouts):
            found[place] = predict_holdout(
                holdout,
                material,
                self._file,
                self._make,
                partial(self._show, found[:place]),
                self._registrations[holdout.name],
            )
            if found[place].state == "failed":
                # Said while the others are simulated.
                self._said.append(str(found[place]))
            keep(replace(result, holdouts=tuple(found)))

    def _all(self, result: Result, state: HoldoutState) -> Result:
        found = (
            HoldoutResult(one.name, state, registration=self._registrations[one.name])
            for one in self._holdouts
        )
        return replace(result, holdouts=tuple(found))

    def _show(self, ended: Sequence[HoldoutResult], now: HoldoutProgress | None = None) -> None:
        """Show the progress to the user and to a watch: hold-outs that have ended, and the next."""
        show, live_file = self._options.on_progress, self._options.live_file
        if now is not None:
            self._seconds[len(ended)] = now.seconds
        is_due = live_file is not None and (now is None or live_file.is_due)
        if show is None and not is_due:
            return
        progress = self._progress(ended, now)
        if live_file is not None and is_due:
            live_file.update(self._identity, progress)
        if show is not None:
            show(progress)

    def _progress(self, ended: Sequence[HoldoutResult], now: HoldoutProgress | None) -> Progress:
        done, failed = sum(one.runs for one in ended), sum(one.failed for one in ended)
        later = self._holdouts[len(ended) :]
        if now is None:
            left = sum(one.runs for one in later)
            to_come = RunsToCome(left, left, left)
            return Progress(HOLDOUT_STAGE, done, 0, failed, to_come, None, None, tuple(self._said))
        left = now.of - now.done + sum(one.runs for one in later[1:])
        campaign = now.campaign
        return Progress(
            HOLDOUT_STAGE,
            done + now.done,
            campaign.running,
            failed + now.failed,
            RunsToCome(left, left, left),
            now.seconds / now.made * left / self._options.workers if now.made else None,
            None,
            self._notices(campaign),
            pending=campaign.pending_runs,
            jobs=campaign.jobs,
        )

    def _notices(self, campaign: Campaign) -> tuple[str, ...]:
        self._said += campaign.notices[self._taken :]
        self._taken = len(campaign.notices)
        return tuple(self._said)


def _ended(
    found: Sequence[HoldoutResult], state: HoldoutState, why: str = ""
) -> list[HoldoutResult]:
    """Return hold-outs of which those that were not reached have another state."""
    return [replace(one, state=state, why=why) if one.state == "pending" else one for one in found]


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
