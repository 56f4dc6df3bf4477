"""Fit the metamodels that all parts of the analysis rest on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from grainfit.analysis import messages
from grainfit.evaluation import Evaluation
from grainfit.metamodels.known_runs import (
    LARGEST_DISTANCE,
    MOST_RUNS,
    distance_outside,
    fit_where_possible,
    nearest_runs,
)
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Problem


@dataclass(frozen=True)
class Fitted:
    """Metamodels of a calibration's runs.

    Attributes
    ----------
    whole, reduced : Metamodels or None
        Metamodels with all sets of hyperparameters, and with only the most probable ones, to
        limit the effort; None when there are too few runs.
    runs : tuple of Evaluation
        The runs that they were fitted to.
    notes : tuple of str
        Runs and responses that are left out, and why.
    """

    whole: Metamodels | None
    reduced: Metamodels | None
    runs: tuple[Evaluation, ...]
    notes: tuple[str, ...]


def fit_runs(
    problem: Problem,
    evaluations: Sequence[Evaluation],
    *,
    seed: int,
    answer: Mapping[str, float] | None,
) -> Fitted:
    """Fit metamodels to the runs of a calibration; their order does not matter.

    Parameters
    ----------
    problem : Problem
        Parameters and targets.
    evaluations : sequence of Evaluation
        All known runs, failed ones included.
    seed : int
        Decides the choice among too many runs.
    answer : mapping of str to float or None
        The calibrated values; of too many runs, those near them are preferred.
    """
    notes: list[str] = []
    usable = _usable(problem, sorted(evaluations, key=_order), notes)
    chosen = _chosen(problem, usable, answer, seed, notes)
    whole, missing = fit_where_possible(problem, chosen)
    if chosen:
        notes += [messages.NO_METAMODEL(name=name, why=why) for name, why in missing.items()]
    return Fitted(whole, whole.reduced() if whole else None, tuple(chosen), tuple(notes))


def _order(evaluation: Evaluation) -> tuple[list[tuple[str, float]], int]:
    return sorted(evaluation.proposal.parameters.items()), evaluation.proposal.seed


def _usable(
    problem: Problem, evaluations: Sequence[Evaluation], notes: list[str]
) -> list[Evaluation]:
    """Runs within the intervals, or not far beyond them, that yielded a response."""
    telling = [e for e in evaluations if not e.response_names.isdisjoint(problem.responses)]
    near = [e for e in telling if _is_near(problem, e.proposal.parameters)]
    if not telling:
        none = messages.NO_RESPONSES(runs=len(evaluations)) if evaluations else messages.NO_RUNS()
        notes.append(none)
    elif len(near) < len(telling):
        left_out, runs = len(telling) - len(near), len(telling)
        share = LARGEST_DISTANCE
        notes.append(messages.RUNS_FAR_OUTSIDE(left_out=left_out, runs=runs, share=share))
    return near


def _is_near(problem: Problem, values: Mapping[str, float]) -> bool:
    return _has_all(problem, values) and distance_outside(problem, values) <= LARGEST_DISTANCE


def _has_all(problem: Problem, values: Mapping[str, float]) -> bool:
    return all(parameter.name in values for parameter in problem.parameters)


def _chosen(
    problem: Problem,
    evaluations: list[Evaluation],
    answer: Mapping[str, float] | None,
    seed: int,
    notes: list[str],
) -> list[Evaluation]:
    """Choose the runs for the metamodels, and say so if some are left out."""
    holds = (
        answer is not None
        and _has_all(problem, answer)
        and distance_outside(problem, answer) == 0.0
    )
    chosen = nearest_runs(problem, evaluations, answer if holds else None, seed=seed)
    if len(chosen) < len(evaluations):
        inside = sum(distance_outside(problem, e.proposal.parameters) == 0.0 for e in evaluations)
        runs, which = len(evaluations), _which(inside, holds)
        notes.append(messages.RUNS_CHOSEN(chosen=MOST_RUNS, runs=runs, which=which))
    return chosen


def _which(inside: int, answer_is_known: bool) -> str:
    if inside <= MOST_RUNS:
        return f"the {inside} within the intervals and those nearest to them"
    centre = "the answer" if answer_is_known else "what looks like the answer"
    half = MOST_RUNS // 2
    return f"the {half} nearest to {centre} and {MOST_RUNS - half} spread over the others"
