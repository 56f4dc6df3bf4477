"""Next step after a calibration: take the material to a solver, or measure something else."""

from __future__ import annotations

import shlex

from grainfit.cards import FORMATS, material_card, require_format
from grainfit.errors import GrainfitError
from grainfit.formatting import plain, plain_lines
from grainfit.report.section import ReportContext

#: Format of the command where the runs name no solver that has a card.
_USUAL_FORMAT = "liggghts"
_ANY_PARAMETERS = "json"


def next_step(context: ReportContext) -> dict[str, str]:
    """Return the material card with its command, and the first test to do next.

    Returns
    -------
    dict of str
        ``export``, the command; ``card``, its output, and ``card_format``, the solver's name; and
        ``further_test``, in words. Each of them is empty where there is none.
    """
    found = {"export": "", "card": "", "card_format": "", "further_test": _further_test(context)}
    if context.reading.state != "calibrated" or not context.answer:
        return found
    solver = _solver(context)
    folder = shlex.quote(context.reading.folder.absolute().name)
    card = _card(context, solver or _USUAL_FORMAT)
    # Every card is one of a material; the parameters of a user's model may be of another kind.
    usual = _USUAL_FORMAT if card else _ANY_PARAMETERS
    return found | {
        "export": plain(f"grainfit export {folder} --to {solver or usual}"),
        "card": card if solver else "",
        "card_format": solver,
    }


def _solver(context: ReportContext) -> str:
    """Return the solver of the runs if it has cards."""
    for record in context.reading.records.values():
        solver = str(record.definition.model.get("solver", "")).lower()
        if solver in FORMATS:
            return solver
    return ""


def _card(context: ReportContext, solver: str) -> str:
    """Return the card of a calibrated material; nothing where it lacks what a solver needs."""
    try:
        card = require_format(solver)(material_card(context.reading))
    except GrainfitError:
        return ""
    return "\n".join(plain_lines(card))


def _further_test(context: ReportContext) -> str:
    found = context.analysis.identifiability
    if context.posterior is None or found is None or not found.further_tests:
        return ""
    return context.in_words(found.further_tests[0])
