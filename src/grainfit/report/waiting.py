"""What a section says where something is missing: why."""

from __future__ import annotations

from grainfit.printable import plain
from grainfit.report.labels import Label
from grainfit.report.rendering import render
from grainfit.report.section import ReportContext, Section


def waiting(context: ReportContext, key: str, title: str, reason: str = "") -> Section:
    """Return a section that has nothing to say yet, and says why.

    Parameters
    ----------
    context : ReportContext
        The notes of its analysis are the reasons, unless one is given.
    key, title : str
        Of the section.
    reason : str
        In a sentence or two.
    """
    reasons = [reason] if reason else [plain(note) for note in context.analysis.notes]
    return Section(key, title, render("waiting", reasons=reasons))


def without_metamodel(context: ReportContext) -> list[Label]:
    """Responses that are missing in all that rests on metamodels."""
    metamodels = context.analysis.metamodels
    known = {target.name for target in metamodels.problem.targets} if metamodels else set()
    return [context.response_label(t.name) for t in context.targets if t.name not in known]
