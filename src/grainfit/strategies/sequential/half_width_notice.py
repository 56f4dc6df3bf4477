"""Sentences about the half-widths that a search has reached, or why it has not."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grainfit.formatting import in_a_row, number
from grainfit.strategies import messages
from grainfit.strategies.sequential.parameter_knowledge import ParameterKnowledge

#: Share of the parameter sets that agree at which runs fail, above which that is said.
_MANY_FAILURES = 0.05


def about_half_widths(
    knowledge: ParameterKnowledge, *, is_answered: bool, is_budget_used: bool
) -> str:
    """Return the sentences for the end of a search.

    Parameters
    ----------
    knowledge : ParameterKnowledge
        By all runs.
    is_answered : bool
        Whether the answer itself was known before the search ended.
    is_budget_used : bool
        Whether no more runs were allowed.
    """
    wanted = f"±{_percent(knowledge.wanted)}"
    widths, missed = knowledge.half_widths, knowledge.too_wide
    if not missed:
        return messages.HALF_WIDTHS_REACHED(reached=_listed(widths), wanted=wanted)
    reached = _listed(widths, missed)
    sentences = [messages.HALF_WIDTHS_MISSED(reached=reached, wanted=wanted)]
    if not is_answered:
        return " ".join([*sentences, messages.NO_RUNS_BEFORE_ANSWER()])
    if knowledge.share_of_failures > _MANY_FAILURES:
        share = _percent(knowledge.share_of_failures)
        sentences.append(messages.FAILURES_AMONG_ANSWERS(share=share))
    best = _listed(knowledge.at_best, missed)
    if knowledge.is_worth_runs and is_budget_used:
        return " ".join([*sentences, messages.MORE_RUNS_NARROW(best=best)])
    # The verification may have changed a little what is worth runs.
    if not knowledge.is_worth_runs:
        sentences.append(messages.MEASUREMENTS_LIMIT())
    return " ".join([*sentences, messages.MORE_MEASUREMENTS_NARROW(best=best)])


def _listed(half_widths: Mapping[str, float], names: Iterable[str] | None = None) -> str:
    chosen = half_widths if names is None else names
    return in_a_row(f"±{_percent(half_widths[name])} for {name}" for name in chosen)


def _percent(share: float) -> str:
    # A larger share says nothing more than that the parameter is open.
    return "100 % or more" if share >= 1.0 else f"{number(100 * share, 2)} %"
