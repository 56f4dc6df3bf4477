"""Make the runs of a hold-out, as long as there is hope that they tell something."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from grainfit.calibration import messages
from grainfit.calibration.failed_runs import fail_by_machine, would_all_fail
from grainfit.evaluation import Evaluation, Proposal
from grainfit.formatting import as_sentence, causes

if TYPE_CHECKING:
    # Imports the store, which a calibration file is read without.
    from grainfit.campaign.campaign import Campaign


@dataclass(frozen=True)
class HoldoutProgress:
    """Progress of the runs of a hold-out.

    Parameters
    ----------
    done, failed, of : int
        Runs that have ended, those of them that failed, and all.
    campaign : Campaign
        The campaign that makes them.
    seconds : float
        Sum of the wall times of the runs that were made for it, s.
    made : int
        Number of these; the others were known.
    """

    done: int
    failed: int
    of: int
    campaign: Campaign
    seconds: float = 0.0
    made: int = 0


def simulate_holdout(
    campaign: Campaign,
    parts: Sequence[Sequence[Proposal]],
    needed: Collection[str],
    show: Callable[[HoldoutProgress], None],
) -> tuple[dict[int, Evaluation], str]:
    """Make the runs of a hold-out that are not known, and close its campaign.

    Parameters
    ----------
    campaign : Campaign
        The campaign of its test.
    parts : sequence of sequence of Proposal
        The runs: at the answer, over the posterior, and over the intervals.
    needed : collection of str
        Responses that are to be predicted; empty for all.
    show : callable
        Called with the progress, a few times per second.

    Returns
    -------
    evaluations, why : dict of int to Evaluation, and str
        The evaluations by their seeds, and why others were not made: as in a search, the first few
        failed alike, or the last few by the machine. The failed ones are made again at the next
        start. Empty if all were made.
    """
    waiting = _from_everywhere(parts)
    every = len(waiting) * campaign.runs_per_set
    ended: dict[int, Evaluation] = {}

    def say() -> None:
        show(_progress(list(ended.values()), every, campaign))

    try:
        while waiting or campaign.has_pending:
            while waiting and campaign.has_free_worker and not campaign.has_complete:
                campaign.start(waiting.pop(0))
                say()
            for evaluation in campaign.wait(say):
                ended[evaluation.proposal.seed] = evaluation
            say()
            if why := _why_hopeless(list(ended.values()), needed):
                campaign.forget_failures(ended.values())
                campaign.cancel()
                return ended, why
    except KeyboardInterrupt:
        campaign.cancel()
        raise
    finally:
        campaign.close()
    return ended, ""


def _from_everywhere(parts: Sequence[Sequence[Proposal]]) -> list[Proposal]:
    """Return the first run of each part, then the others: not all may fail as at the answer."""
    first = [part[0] for part in parts if part]
    return [*first, *(proposal for part in parts for proposal in part[1:])]


def _progress(ended: Sequence[Evaluation], every: int, campaign: Campaign) -> HoldoutProgress:
    done = sum(len(one.runs) for one in ended)
    return HoldoutProgress(
        done,
        sum(len(one.failed_runs) for one in ended),
        every,
        campaign,
        sum(one.simulated_seconds for one in ended),
        done - sum(one.reused for one in ended),
    )


def _why_hopeless(ended: Sequence[Evaluation], needed: Collection[str]) -> str:
    """Return why more runs would fail as well; "" if they may not."""
    if latest := fail_by_machine(ended):
        why = "; ".join(latest[-1].failures.values())
        return as_sentence(messages.MACHINE_FAILS(runs=len(latest), why=why))
    given = {name for one in ended for name in one.response_names}
    missing = sorted(set(needed) - given) if needed else [] if given else ["responses"]
    if not missing or not would_all_fail(ended):
        return ""
    reasons = causes(why for one in ended for why in one.failures.values())
    found = ", ".join(sorted(given)) or "nothing"
    why = "; ".join(reasons) or messages.RESPONSES_MISSING(found=found)
    shown = {"runs": len(ended), "responses": ", ".join(missing), "why": why}
    return messages.HOLDOUT_GIVEN_UP(**shown)
