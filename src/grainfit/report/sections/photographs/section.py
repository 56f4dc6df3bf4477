"""Photographs of the laboratory beside heaps and drums of the simulation."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.photographs.comparison import Comparison, compared

_KEY, _TITLE = "photographs", "Does the simulation look like the photographs?"


def photographs(context: ReportContext) -> Section | None:
    """Each photographed heap or drum beside the simulated one; None without photographs."""
    comparisons = compared(context.reading)
    if not comparisons:
        return None
    return Section(_KEY, _TITLE, html_of(comparisons))


def html_of(comparisons: Sequence[Comparison]) -> Markup:
    """Return the comparisons as HTML."""
    return fill_template(f"{_KEY}/page", comparisons=comparisons)
