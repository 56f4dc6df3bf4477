"""A response that the runs of a calibration have anyway, and that would narrow a parameter."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from functools import partial

from grainfit.bulk_tests.accuracy import Accuracy, usual_accuracy
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.evaluation import response_name
from grainfit.formatting import number
from grainfit.solvers.base import Solver
from grainfit.which_test import messages
from grainfit.which_test.candidate import CandidateResponse
from grainfit.which_test.knowledge import Knowledge
from grainfit.which_test.slopes import Cloud
from grainfit.which_test.told_by_atlas import as_dry_spheres, told_responses

#: A further response is named if it narrows a parameter at least to this share: it takes about two
#: runs more (`benchmarks/further_responses.py`).
_WORTH_MEASURING = 0.85


def further_response(
    known: Knowledge,
    names: Collection[str],
    solvers: Mapping[str, Solver],
    measured: Collection[str],
    cloud: Cloud,
) -> str:
    """Return a sentence on the response that narrows a parameter most; empty if none does by much.

    Parameters
    ----------
    known : Knowledge
        The parameters after all measured responses.
    names : collection of str
        Parameters that may be narrowed.
    solvers : mapping of str to Solver
        By name of the test.
    measured : collection of str
        Names of the targets. Of a test, one response of each unit counts: those of one surface say
        nearly the same.
    cloud : Cloud
        Parameter sets over which the slopes by the atlas are taken.
    """
    kept = [name for name in known.names if name in names and known.deviation(name) > 0]
    if not kept or as_dry_spheres(solvers, cloud.middle):
        return ""
    best, sentence = _WORTH_MEASURING, ""
    for test, response in _unmeasured(solvers, measured, cloud):
        then = known.after([response.slopes], [[response.variance()]])
        share, name = min((then.deviation(name) / known.deviation(name), name) for name in kept)
        if share < best:
            best, sentence = (
                share,
                messages.MEASURE_AS_WELL(
                    response=response.short_name,
                    test=test,
                    accuracy=response.accuracy.in_words(response.unit),
                    tool=" (with a ruler)" if response.unit == "m" else "",
                    name=name,
                    after=number(100 * then.half_width(name), 2),
                    before=number(100 * known.half_width(name), 2),
                ),
            )
    return sentence


def _unmeasured(
    solvers: Mapping[str, Solver], measured: Collection[str], cloud: Cloud
) -> Iterator[tuple[str, CandidateResponse]]:
    for test, solver in solvers.items():
        if solver.bulk_test is None:
            continue
        known = solver.bulk_test.responses
        units = {
            info.unit
            for name, info in known.items()
            if response_name(test, name, len(solvers)) in measured
        }
        # A test made in Python has the name of its program.
        shown = solver.bulk_test.type if test == solver.name else test
        for found in told_responses(test, solver, cloud, partial(_unless_measured, units)):
            yield shown, found


def _unless_measured(measured: Collection[str], name: str, info: ResponseInfo) -> Accuracy | None:
    accuracy = usual_accuracy(name, info.unit)
    # Shares: what a ruler or a scale tells beyond an angle.
    return accuracy if accuracy.is_share and info.unit not in measured else None
