"""Sensitivity: which parameter a response depends on, over the intervals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.analysis import Sensitivity
from grainfit.formatting import plain
from grainfit.plots.style import BLUE, VERMILION
from grainfit.report.rendering import render
from grainfit.report.section import Figure, ReportContext, Section, waiting

_KEY, _TITLE = "sensitivity", "Which parameters matter?"
_ROW_HEIGHT = 30
_FRAME_HEIGHT = 110


def sensitivity(context: ReportContext) -> Section:
    """Sobol' indices of every response with their intervals, and what they mean in words."""
    found = context.analysis.sensitivity
    if found is None:
        return waiting(context, _KEY, _TITLE)
    rows = range(len(found.responses))
    figures = {f"{_KEY}-{row}": _figure(context, found, row) for row in rows}
    html = render(
        f"{_KEY}/page",
        responses=[
            {"label": context.response_label(name), "sentence": plain(sentence), "figure": figure}
            for name, sentence, figure in zip(
                found.responses, found.in_words(), figures, strict=True
            )
        ],
    )
    return Section(_KEY, _TITLE, html, figures)


def _figure(context: ReportContext, found: Sensitivity, row: int) -> Figure:
    # Plotly draws the first category at the bottom.
    order = np.argsort(found.total[row], kind="stable")
    labels = [context.parameter_label(found.names[j]).plot for j in order]
    rows = np.arange(len(order), dtype=np.float64)
    indices = (
        ("alone (first)", found.first, found.first_low, found.first_high, BLUE, "circle", 0.14),
        (
            "alone and with others (total)",
            found.total,
            found.total_low,
            found.total_high,
            VERMILION,
            "diamond",
            -0.14,
        ),
    )
    return Figure(
        data=tuple(
            _dots(name, rows + shift, [a[row][order] for a in (best, low, high)], color, symbol)
            for name, best, low, high, color, symbol, shift in indices
        ),
        layout={
            "xaxis": {
                "range": [-0.03, 1.03],
                "title": {"text": "share of the response's variation"},
                "tickformat": ".0%",
                "zeroline": False,
            },
            "yaxis": {
                "tickvals": rows.tolist(),
                "ticktext": labels,
                "range": [-0.6, len(order) - 0.4],
                "zeroline": False,
            },
            "hovermode": "closest",
        },
        description=(
            f"First and total sensitivity of {plain(found.responses[row])} to each parameter, "
            "with 95 % intervals."
        ),
        height=_FRAME_HEIGHT + _ROW_HEIGHT * len(order),
    )


def _dots(
    name: str, rows: NDArray[np.float64], shares: list[NDArray[np.float64]], color: str, symbol: str
) -> Mapping[str, Any]:
    best, low, high = shares
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": best.tolist(),
        "y": rows.tolist(),
        "customdata": np.column_stack([low, high]).tolist(),
        "error_x": {
            "type": "data",
            "symmetric": False,
            # Resampled estimates may lie to one side of the estimate.
            "array": np.maximum(high - best, 0.0).tolist(),
            "arrayminus": np.maximum(best - low, 0.0).tolist(),
            "color": color,
            "thickness": 1.5,
            "width": 3,
        },
        "marker": {"color": color, "symbol": symbol, "size": 9},
        "hovertemplate": (
            f"{name}: %{{x:.0%}}<br>95 % interval "
            "%{customdata[0]:.0%} to %{customdata[1]:.0%}<extra></extra>"
        ),
    }
