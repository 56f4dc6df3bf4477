"""Parameters that the tests do not determine: verdicts in words, then the evidence."""

from __future__ import annotations

import shlex

from grainfit.bulk_tests.registry import class_of_test
from grainfit.formatting import plain
from grainfit.plots.pairs_figures import pairs_figures
from grainfit.plots.posterior_figures import interval_in_words, posterior_figures
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section, waiting, without_metamodel

_KEY, _TITLE = "undetermined", "What do the tests not determine?"


def undetermined(context: ReportContext) -> Section:
    """Verdicts, further tests, correlations, and how far each interval narrowed."""
    posterior, found = context.posterior, context.analysis.identifiability
    if posterior is None or found is None:
        return waiting(context, _KEY, _TITLE, context.why_no_posterior)
    drawn = posterior_figures(context.reading, posterior, found, context.intervals)
    figures = {f"{_KEY}-narrowing": drawn.narrowing}
    if drawn.correlations is not None and len(posterior.names) > 2:
        # Of two parameters, the pair says it.
        figures[f"{_KEY}-correlations"] = drawn.correlations
    histograms = {f"{_KEY}-marginal-{i}": figure for i, figure in enumerate(drawn.marginals)}
    pairs = {
        f"{_KEY}-pair-{i}": figure
        for i, figure in enumerate(pairs_figures(context.reading, posterior))
    }
    html = fill_template(
        f"{_KEY}/page",
        verdicts=[context.in_words(verdict) for verdict in found.verdicts],
        further_tests=[context.in_words(test) for test in found.further_tests],
        advise=_advise_command(context),
        missing=without_metamodel(context),
        figures=list(figures),
        pairs=list(pairs),
        marginals=[
            {
                "figure": key,
                "label": context.parameter_label(name),
                "between": interval_in_words(context.intervals[name]),
            }
            for key, name in zip(histograms, posterior.names, strict=True)
        ],
        converged=posterior.converged,
        convergence=plain(posterior.convergence),
        has_answer=bool(context.answer),
    )
    return Section(_KEY, _TITLE, html, figures | histograms | pairs)


def _advise_command(context: ReportContext) -> str:
    """Return the command that computes which test to do next; "" for models of the user."""
    definitions = (record.definition for record in context.reading.records.values())
    if not any(class_of_test(definition) for definition in definitions):
        return ""
    return plain(f"grainfit advise {shlex.quote(context.reading.folder.name)}")
