"""A section that has nothing to say yet, and says why."""

from __future__ import annotations

from grainfit.printable import plain
from grainfit.report.rendering import render
from grainfit.report.section import ReportContext, Section


def waiting(context: ReportContext, key: str, title: str, reason: str = "") -> Section:
    """Return a section that says why there is nothing in it.

    Parameters
    ----------
    context : ReportContext
        The notes of its analysis are the reasons, unless one is given.
    key, title : str
        Of the section.
    reason : str
        One sentence.
    """
    reasons = [reason] if reason else [plain(note) for note in context.analysis.notes]
    ended = len(context.reading.evaluations)
    html = render("waiting", reasons=reasons, ended=ended)
    return Section(key, title, html)
