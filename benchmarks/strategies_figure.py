"""Figure of `strategies.py`: deviation of the answers against the number of DEM runs."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import plotly.io
from plotly.subplots import make_subplots

Summary = dict[str, Any]

WIDTH, HEIGHT = 1200, 900
COLUMNS = 2
#: Colours of Okabe & Ito, distinct in colour blindness, and symbols distinct in grey prints.
STYLES = {
    "sequential": ("#0072B2", "circle"),
    "staged": ("#D55E00", "square"),
    "Optuna TPE": ("#E69F00", "triangle-up"),
    "Bayesian optimisation (scalar)": ("#009E73", "diamond"),
    "CMA-ES": ("#CC79A7", "x"),
    "GrainLearning": ("#56B4E9", "triangle-down"),
}
LIMIT = "limit: n runs at the right place"
GRID = "#E4E4E4"
TICKS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)


def draw(summary: Summary, path: Path) -> None:
    """Draw the figure to a .png or .html file."""
    figure = make_figure(summary)
    if path.suffix.lower() == ".png":
        try:
            plotly.io.write_image(figure, path, width=WIDTH, height=HEIGHT, scale=2)
            return
        except (ImportError, OSError, RuntimeError, ValueError) as reason:
            path = path.with_suffix(".html")
            print(f"No PNG, so {path} is written: {' '.join(str(reason).split())}", file=sys.stderr)
    figure.write_html(path, include_plotlyjs=True)


def make_figure(summary: Summary) -> go.Figure:
    """Return a figure of one panel per case."""
    rows = math.ceil(len(summary) / COLUMNS)
    titles = [name.replace("+-", "±") for name in summary]
    figure = make_subplots(
        rows, COLUMNS, subplot_titles=titles, horizontal_spacing=0.09, vertical_spacing=0.13
    )
    in_legend: set[str] = set()
    for number, (name, case) in enumerate(summary.items()):
        place = {"row": number // COLUMNS + 1, "col": number % COLUMNS + 1}
        for method, median, p90 in _curves(name, case):
            for line in _lines(method, case["checkpoints"], median, p90, method not in in_legend):
                figure.add_trace(line, **place)
            in_legend.add(method)
        figure.update_xaxes(
            title_text="DEM runs", type="log", tickvals=case["checkpoints"], **place
        )
        figure.update_yaxes(title_text=_axis_title(name), **place)
    _lay_out(figure, max(case["calibrations"] for case in summary.values()))
    return figure


def _shown(name: str, case: Summary) -> list[str]:
    """Return the responses whose mean a panel shows: for a heap only the angle, the noisy one."""
    return ["angle_of_repose"] if name.startswith("heap") else list(case["limit"])


def _axis_title(name: str) -> str:
    if name.startswith("heap"):
        return "deviation of the angle of repose / %"
    return "deviation, mean of all responses / %"


def _curves(name: str, case: Summary) -> Iterator[tuple[str, list[float], list[float]]]:
    """Yield method, median and 90th percentile in percent; grainfit last, so drawn on top."""
    shown = _shown(name, case)
    found = {method: values["deviations"] for method, values in case["methods"].items()}
    for method, deviations in [(LIMIT, case["limit"]), *reversed(found.items())]:
        median, p90 = (
            100 * np.mean([deviations[response][key] for response in shown], axis=0)
            for key in ("median", "p90")
        )
        yield method, median.tolist(), p90.tolist()


def _lines(
    method: str, runs: Sequence[int], median: list[float], p90: list[float], in_legend: bool
) -> Iterator[go.Scatter]:
    colour, symbol = STYLES.get(method, ("black", "circle"))
    width = 3.5 if method == "sequential" else 2
    common = {"x": runs, "name": method, "legendgroup": method}
    yield go.Scatter(
        y=p90,
        mode="lines",
        line={"color": colour, "width": width / 2, "dash": "dash"},
        showlegend=False,
        hovertemplate="%{y:.2f} %, 90th percentile",
        **common,
    )
    yield go.Scatter(
        y=median,
        mode="lines" if method == LIMIT else "lines+markers",
        line={"color": colour, "width": width},
        marker={"symbol": symbol, "size": 8},
        showlegend=in_legend,
        hovertemplate="%{y:.2f} %, median",
        **common,
    )


def _lay_out(figure: go.Figure, calibrations: int) -> None:
    axes = {"gridcolor": GRID, "linecolor": "black", "ticks": "outside", "mirror": True}
    axes |= {"title_font": {"size": 14}, "title_standoff": 8}
    figure.update_xaxes(**axes)
    figure.update_yaxes(type="log", tickvals=TICKS, **axes)
    figure.update_layout(
        title={
            "text": "How far the expected response of the answer is from the target<br>"
            f"<sup>{calibrations} calibrations; full lines: median, dashed: 90th percentile</sup>",
            "x": 0.5,
        },
        legend={
            "orientation": "h",
            "x": 0.5,
            "xanchor": "center",
            "y": -0.1,
            "yanchor": "top",
            "traceorder": "reversed",
        },
        plot_bgcolor="white",
        paper_bgcolor="white",
        font={"family": "Arial, Helvetica, sans-serif", "size": 14, "color": "black"},
        width=WIDTH,
        height=HEIGHT,
        margin={"l": 80, "r": 30, "t": 100, "b": 110},
    )
