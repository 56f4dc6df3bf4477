"""Sentences about the half-widths that a search has reached, or why it has not."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grainfit.formatting import in_a_row, number
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
        return f"Half of the 95 % intervals: {_listed(widths)}. All are within the wanted {wanted}."
    short = f"Half of the 95 % interval is {_listed(widths, missed)}, where {wanted} was wanted. "
    if not is_answered:
        return f"{short}Runs for it are made only once the answer agrees with all measurements."
    best = _listed(knowledge.at_best, missed)
    if knowledge.share_of_failures > _MANY_FAILURES:
        share = _percent(knowledge.share_of_failures)
        short += f"Runs fail at {share} of the parameter sets that agree with the measurements. "
    if knowledge.is_worth_runs and is_budget_used:
        return f"{short}More runs would narrow it, to {best} at best; a larger budget allows them."
    # The verification may have changed a little what is worth runs.
    limit = "" if knowledge.is_worth_runs else "The measurements limit it. "
    return (
        f"{short}{limit}Any number of runs would leave {best}. More accurate measurements or "
        "another test would narrow it; `grainfit advise` says which."
    )


def _listed(half_widths: Mapping[str, float], names: Iterable[str] | None = None) -> str:
    chosen = half_widths if names is None else names
    return in_a_row(f"±{_percent(half_widths[name])} for {name}" for name in chosen)


def _percent(share: float) -> str:
    # A larger share says nothing more than that the parameter is open.
    return "100 % or more" if share >= 1.0 else f"{number(100 * share, 2)} %"
