"""Complete the result of a calibration with the 95 % intervals of its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from grainfit.calibration import messages
from grainfit.errors import GrainfitError
from grainfit.evaluation import Evaluation
from grainfit.problem import Problem
from grainfit.result import Result
from grainfit.solvers.base import Solver
from grainfit.strategies.distinct_runs import distinct_runs
from grainfit.which_test.available import material_of


def with_intervals(
    result: Result,
    problem: Problem,
    evaluations: Sequence[Evaluation],
    warm_start: Sequence[Evaluation],
    solvers: Mapping[str, Solver],
) -> Result:
    """Return the result with the intervals that report and material card show as well.

    Parameters
    ----------
    result : Result
        The result without them.
    problem : Problem
        The problem with the intervals that the user gave.
    evaluations, warm_start : sequence of Evaluation
        All runs of the calibration, verification included, and those of the warm start.
    solvers : mapping of str to Solver
        By name of the test: apparatus and stiffness of their particles may bias a parameter.

    Returns
    -------
    Result
        Without intervals if there is no answer, or if no parameter set agrees.
    """
    if not result.parameters or result.status == "unreachable":
        return result
    # Imported here: emcee is needed only now.
    from grainfit.analysis.analysis import analyse_parameters
    from grainfit.analysis.soft_particles import known_biases

    tests = {name: s.bulk_test for name, s in solvers.items() if s.bulk_test is not None}
    try:
        found = analyse_parameters(
            problem.widened_to([evaluation.proposal.parameters for evaluation in evaluations]),
            distinct_runs([*evaluations, *warm_start]),
            seed=result.seed,
            answer=result.parameters,
            biases=known_biases(
                problem, tests, material_of(solvers, result.parameters), result.parameters
            ),
        )
    except KeyboardInterrupt:
        # The user is in a hurry; the result must not be lost.
        return _without(result, "interrupted")
    except (GrainfitError, ArithmeticError, ValueError) as error:
        return _without(result, str(error))
    rough = found.posterior is not None and not found.posterior.converged
    notices = (*result.other_notices, *(found.notes if rough else ()))
    return replace(result, intervals=found.intervals, other_notices=notices)


def _without(result: Result, why: str) -> Result:
    notice = messages.NO_INTERVALS(why=why)
    return replace(result, other_notices=(*result.other_notices, notice))
