"""Figures 4 to 6 of the paper, redrawn from the runs of the study beside the published ranges.

Drawn with Plotly; a PNG needs kaleido and a Chrome or Chromium.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import plotly.graph_objects as go
import plotly.io
from plotly.subplots import make_subplots

from studies.rackl2016.findings import Findings, Row
from studies.rackl2016.plan import METHODS
from studies.rackl2016.setting import ANGLE, BULK_DENSITY, PUBLISHED, SEEDS, WIDTHS

WIDTH, HEIGHT = 1200, 1250
#: Colours of Okabe & Ito, which the colour-blind can tell apart, and marks for prints in grey.
STYLES = {
    "staged": ("#D55E00", "square"),
    "sequential": ("#0072B2", "circle"),
    "octave-1": ("#E69F00", "triangle-up"),
    "octave-0": ("#009E73", "diamond"),
}
GRID, BAND = "#E4E4E4", "rgba(120, 120, 120, 0.18)"
PANELS = (BULK_DENSITY, ANGLE, "optimisation_runs")
_TITLES = (
    "Figure 4: deviation of the bulk density",
    "Figure 5: deviation of the angle of repose",
    "Figure 6: runs behind the design, before verification",
)
_TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20)
#: Deviations that are drawn, %; smaller ones lie on the lower edge.
_SMALLEST, _LARGEST = 0.01, 30


def draw(findings: Findings, path: Path) -> None:
    """Draw figures 4 to 6 to a PNG file."""
    plotly.io.write_image(make_figure(findings), path, width=WIDTH, height=HEIGHT, scale=2)


def make_figure(findings: Findings) -> go.Figure:
    """One panel per figure of the paper."""
    figure = make_subplots(3, 1, subplot_titles=_TITLES, vertical_spacing=0.07)
    for number, panel in enumerate(PANELS, 1):
        place = {"row": number, "col": 1}
        for position, method in enumerate(METHODS):
            for trace in _traces(findings.rows(method), panel, method, position, number == 1):
                figure.add_trace(trace, **place)
        known, band = PUBLISHED[panel], {"line_width": 0, "fillcolor": BAND, "layer": "below"}
        figure.add_hrect(
            known.smallest, known.largest, exclude_empty_subplots=False, **band, **place
        )
        mean = {"color": "grey", "dash": "dot"}
        figure.add_hline(known.mean, line=mean, exclude_empty_subplots=False, **place)
    _lay_out(figure)
    return figure


def _place(row: Row, position: int) -> float:
    """Where a calibration stands: intervals apart, methods beside each other, seeds close by."""
    seed = SEEDS.index(row.case.seed) - 0.5
    return WIDTHS.index(row.case.width) + 0.19 * (position - 1.5) + 0.07 * seed


def _traces(
    rows: Sequence[Row], panel: str, method: str, position: int, in_legend: bool
) -> Iterator[go.Scatter]:
    colour, symbol = STYLES[method]
    common = {"mode": "markers", "legendgroup": method, "name": METHODS[method]}
    marker = {"color": colour, "symbol": symbol, "size": 11}
    places = [_place(row, position) for row in rows]
    if panel == "optimisation_runs":
        runs = [row.record["optimisation_runs"] for row in rows]
        yield go.Scatter(x=places, y=runs, marker=marker, showlegend=False, **common)
        return
    known = [
        (place, off)
        for place, row in zip(places, rows, strict=True)
        if (off := row.expected(panel))
    ]
    yield go.Scatter(
        x=[place for place, _ in known],
        y=[max(abs(off.percent), _SMALLEST) for _, off in known],
        error_y={"array": [off.half_width for _, off in known], "color": colour, "thickness": 1},
        marker=marker,
        showlegend=in_legend,
        **common,
    )
    last = [
        (place, single)
        for place, row in zip(places, rows, strict=True)
        if (single := row.at_last_run(panel)) is not None
    ]
    yield go.Scatter(
        x=[place for place, _ in last],
        y=[max(abs(single), _SMALLEST) for _, single in last],
        marker=marker | {"symbol": f"{symbol}-open", "size": 8},
        showlegend=False,
        **common,
    )


def _lay_out(figure: go.Figure) -> None:
    axes = {"gridcolor": GRID, "linecolor": "black", "ticks": "outside", "mirror": True}
    widths = [f"±{100 * width:.0f} %" for width in WIDTHS]
    ends = [-0.5, len(WIDTHS) - 0.5]
    figure.update_xaxes(tickvals=list(range(len(WIDTHS))), ticktext=widths, range=ends, **axes)
    figure.update_xaxes(zeroline=False)
    figure.update_xaxes(title_text="width of the intervals", row=3)
    figure.update_yaxes(**axes)
    for row in (1, 2):
        figure.update_yaxes(
            type="log",
            range=[math.log10(0.8 * _SMALLEST), math.log10(_LARGEST)],
            tickvals=_TICKS,
            title_text="absolute deviation / %",
            row=row,
        )
    figure.update_yaxes(title_text="DEM runs", rangemode="tozero", row=3)
    figure.update_layout(
        title={
            "text": "Filled: expected response with its 95 % interval; open: single last run<br>"
            "<sup>Two seeds side by side; grey: published range and mean</sup>",
            "x": 0.5,
        },
        legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.06, "yanchor": "top"},
        plot_bgcolor="white",
        paper_bgcolor="white",
        font={"family": "Arial, Helvetica, sans-serif", "size": 14, "color": "black"},
        margin={"l": 80, "r": 30, "t": 110, "b": 100},
    )
