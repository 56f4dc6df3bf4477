"""Yield locus: cohesion and angle of internal friction, measured and at the answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grainfit.evaluation import Response
from grainfit.formatting import interval, plain
from grainfit.plots.yield_locus_figures import yield_locus_figures
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section
from grainfit.result import YieldLocusResult

_KEY, _TITLE = "yield_locus", "Yield locus"


def yield_locus(context: ReportContext) -> Section | None:
    """Each yield locus with its lines; None unless a material was sheared at two stresses."""
    loci = context.reading.yield_loci
    if not loci:
        return None
    drawn = yield_locus_figures(context.reading)
    figures = {f"{_KEY}-{index}": figure for index, figure in enumerate(drawn)}
    tables = [(plain(", ".join(locus.tests)), list(rows_of_locus(locus))) for locus in loci]
    html = fill_template(f"{_KEY}/page", tables=tables, figures=list(figures))
    return Section(_KEY, _TITLE, html, figures)


def rows_of_locus(locus: YieldLocusResult) -> Iterator[tuple[str, Sequence[str]]]:
    """Yield the heading of each line, with its cohesion and its angle."""
    for words, line in (("Measured", locus.measured), ("Expected", locus.expected)):
        if line is not None:
            yield words, [_cell(line.cohesion), _cell(line.internal_friction_angle)]


def _cell(found: Response) -> str:
    return interval(found.value, found.standard_error)
