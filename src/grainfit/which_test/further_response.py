"""A response that the runs of a calibration have anyway, and that would narrow a parameter."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from grainfit.bulk_tests.accuracy import usual_accuracy
from grainfit.evaluation import response_name
from grainfit.formatting import number
from grainfit.solvers.base import Solver
from grainfit.which_test import messages
from grainfit.which_test.candidate import CandidateResponse
from grainfit.which_test.knowledge import Knowledge
from grainfit.which_test.recorded import are_dry_spheres, recorded_response, wall_most_touched

#: A further response is named if it narrows a parameter at least to this share: it takes about two
#: runs more (`benchmarks/further_responses.py`).
_WORTH_MEASURING = 0.85


def further_response(
    known: Knowledge,
    names: Collection[str],
    solvers: Mapping[str, Solver],
    measured: Collection[str],
    material: Mapping[str, float],
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
    material : mapping of str to float
        Where the recorded slopes are taken.
    """
    kept = [name for name in known.names if name in names and known.deviation(name) > 0]
    if not kept or not are_dry_spheres(solvers, material):
        return ""
    best, sentence = _WORTH_MEASURING, ""
    for test, response in _unmeasured(solvers, measured, material):
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
    solvers: Mapping[str, Solver], measured: Collection[str], material: Mapping[str, float]
) -> Iterator[tuple[str, CandidateResponse]]:
    for test, solver in solvers.items():
        known = solver.bulk_test.responses if solver.bulk_test else {}
        full = {name: response_name(test, name, len(solvers)) for name in known}
        units = {info.unit for name, info in known.items() if full[name] in measured}
        for name, info in known.items():
            accuracy = usual_accuracy(name, info.unit)
            # Shares, because no value is known: slopes are relative.
            if info.unit in units or not accuracy.is_share:
                continue
            wall = wall_most_touched(solver)
            found = recorded_response(full[name], info, material, 1.0, accuracy, wall)
            if found is not None and solver.bulk_test is not None:
                # A test made in Python has the name of its program.
                yield (solver.bulk_test.type if test == solver.name else test), found
