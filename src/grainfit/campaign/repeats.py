"""Mean of the runs of one test with several seeds, which count as one evaluation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean, stdev

from grainfit.campaign import messages
from grainfit.campaign.store.records import RunRecord
from grainfit.errors import InputError
from grainfit.evaluation import Curve, Measured, Response


@dataclass(frozen=True)
class MeanOutcome:
    """Outcome of the runs of one test in one evaluation.

    Parameters
    ----------
    responses : mapping of str to Response or Curve
        Means over the runs; empty if the evaluation failed.
    reason : str
        Reason of the failure; empty if there is none.
    failed_by_machine : bool
        Whether all failures were caused by the machine.
    seconds : float
        Mean wall time of a run, s.
    """

    responses: Mapping[str, Measured] = field(default_factory=dict)
    reason: str = ""
    failed_by_machine: bool = False
    seconds: float = 0.0


def seeds_of(seed: int, repeats: int) -> list[int]:
    """Return the seeds of the runs of an evaluation; the first is that of its proposal."""
    if repeats == 1:
        return [seed]
    # The state of a calibration is read without NumPy.
    from grainfit.strategies.seeds import repeat_seed

    return [repeat_seed(seed, number) for number in range(1, repeats + 1)]


def mean_outcome(records: Sequence[RunRecord]) -> MeanOutcome:
    """Return the mean of the runs of one test; a failure if more than half of them failed.

    Parameters
    ----------
    records : sequence of RunRecord
        Runs that have ended.
    """
    failed = [record for record in records if record.status == "failed"]
    finished = [record for record in records if record.status != "failed"]
    seconds = fmean(record.seconds for record in records)
    if len(failed) > len(finished):
        by_machine = all(record.kind == "machine" for record in failed)
        return MeanOutcome({}, _reason(failed, len(records)), by_machine, seconds)
    found: dict[str, list[Measured]] = {}
    for record in finished:
        for name, response in record.responses.items():
            found.setdefault(name, []).append(response)
    try:
        # As with failures: a response that most runs lack has no mean.
        means = {n: _mean(each) for n, each in found.items() if 2 * len(each) >= len(records)}
    except InputError as error:
        return MeanOutcome(reason=str(error), seconds=seconds)
    except OverflowError:
        return MeanOutcome(reason="the responses of its runs are too large", seconds=seconds)
    return MeanOutcome(means, seconds=seconds)


def _reason(failed: Sequence[RunRecord], runs: int) -> str:
    reason = failed[-1].reason
    return reason if runs == 1 else f"{len(failed)} of {runs} runs failed: {reason}"


def _mean(found: Sequence[Measured]) -> Measured:
    if len(found) == 1:
        return found[0]
    numbers = [one for one in found if isinstance(one, Response)]
    curves = [one for one in found if isinstance(one, Curve)]
    if numbers and curves:
        raise InputError(messages.NUMBER_AND_CURVE.fault("response"))
    return _mean_response(numbers) if numbers else _mean_curve(curves)


def _mean_response(found: Sequence[Response]) -> Response:
    """Return the mean with its standard error.

    The scatter between runs contains the errors within runs. A few runs may agree by chance, so
    the error is at least that of the mean of equal values with their own standard errors.
    """
    count = len(found)
    between = stdev(one.value for one in found) / math.sqrt(count)
    within = math.hypot(*(one.standard_error for one in found)) / count
    return Response(fmean(one.value for one in found), max(between, within))


def _mean_curve(found: Sequence[Curve]) -> Curve:
    """Return the mean over the coordinates that all curves reach, linear between points."""
    # The state of a calibration is read without NumPy.
    import numpy as np

    low = max(one.coordinates[0] for one in found)
    ends = [one.coordinates[-1] for one in found if not one.stays]
    high = min(ends) if ends else max(one.coordinates[-1] for one in found)
    places = sorted({x for one in found for x in one.coordinates if low <= x <= high})
    if len(places) < 2:
        raise InputError(messages.NOTHING_IN_COMMON.fault("curves"))
    values = np.mean([np.interp(places, one.coordinates, one.values) for one in found], axis=0)
    return Curve(places, values.tolist(), all(one.stays for one in found))
