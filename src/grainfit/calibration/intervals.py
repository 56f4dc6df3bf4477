"""Complete the result of a calibration with the 95 % intervals of its parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from grainfit.calibration import messages
from grainfit.calibration.holdout import Material
from grainfit.errors import GrainfitError, RunFailedError
from grainfit.evaluation import Evaluation
from grainfit.formatting import value_with_unit
from grainfit.problem import Problem
from grainfit.result import Result
from grainfit.solvers.base import Solver
from grainfit.strategies.distinct_runs import distinct_runs
from grainfit.verdict.out_of_reach import bound_at
from grainfit.which_test.available import material_of
from grainfit.which_test.determination import bound_reached


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
    if not result.parameters:
        return result
    widened = problem.widened_to([evaluation.proposal.parameters for evaluation in evaluations])
    if result.status != "unreachable":
        result = _with_intervals(result, widened, [*evaluations, *warm_start], solvers)
    return _with_notices(result, _about_bounds(result, widened))


def _with_intervals(
    result: Result,
    problem: Problem,
    evaluations: Sequence[Evaluation],
    solvers: Mapping[str, Solver],
) -> Result:
    # Imported here: emcee is needed only now.
    from grainfit.analysis.analysis import analyse_parameters
    from grainfit.analysis.soft_particles import known_biases, of_hertz

    tests = {name: s.bulk_test for name, s in solvers.items() if s.bulk_test is not None}
    tests = of_hertz(tests, *(solver.contact_models for solver in solvers.values()))
    try:
        found = analyse_parameters(
            problem,
            distinct_runs(evaluations),
            seed=result.seed,
            answer=result.parameters,
            biases=known_biases(
                problem, tests, material_of(solvers, result.parameters), result.parameters
            ),
        )
    except KeyboardInterrupt:
        # The user is in a hurry; the result must not be lost.
        return _with_notices(result, [messages.NO_INTERVALS(why="interrupted")])
    except (GrainfitError, ArithmeticError, ValueError) as error:
        return _with_notices(result, [messages.NO_INTERVALS(why=error)])
    rough = found.posterior is not None and not found.posterior.converged
    return _with_notices(replace(result, intervals=found.intervals), found.notes if rough else ())


def material_of_result(
    result: Result,
    problem: Problem,
    evaluations: Sequence[Evaluation],
    warm_start: Sequence[Evaluation],
) -> Material:
    """Return the answer with the parameter sets that agree with the targets.

    Parameters
    ----------
    result : Result
        The result.
    problem, evaluations, warm_start
        As of `with_intervals`.

    Raises
    ------
    RunFailedError
        There are none, as far as the runs tell.
    """
    # Imported here: emcee is needed only now.
    from grainfit.analysis.analysis import analyse_parameters

    widened = problem.widened_to([evaluation.proposal.parameters for evaluation in evaluations])
    runs = distinct_runs([*evaluations, *warm_start])
    try:
        found = analyse_parameters(widened, runs, seed=result.seed, answer=result.parameters)
    except (ArithmeticError, ValueError) as error:
        raise RunFailedError(messages.NO_POSTERIOR(why=error)) from error
    if found.posterior is None:
        raise RunFailedError(messages.NO_POSTERIOR(why=" ".join(found.notes)))
    return Material(
        widened, result.parameters, found.posterior.points, result.seed, result.identity
    )


def _with_notices(result: Result, notices: Iterable[str]) -> Result:
    return replace(result, other_notices=(*result.other_notices, *notices))


def _about_bounds(result: Result, problem: Problem) -> Iterator[str]:
    """Report parameters whose answer lies on a bound, or whose interval reaches one."""
    for parameter in problem.parameters:
        found = result.intervals.get(parameter.name)
        on = bound_at(parameter.to_unit(result.parameters[parameter.name]))
        bound = on or (None if found is None else bound_reached(parameter, found))
        if bound is not None:
            value = parameter.minimum if bound == "min" else parameter.maximum
            message = messages.ON_BOUND if on else messages.AGREES_UP_TO_BOUND
            shown = value_with_unit(value, parameter.unit)
            yield message(parameter=parameter.name, bound=bound, value=shown)
