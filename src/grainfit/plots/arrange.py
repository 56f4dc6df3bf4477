"""Arrange figures in rows and columns as one Plotly figure for a notebook."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING, Any

from grainfit.extras import import_extra
from grainfit.plots.figure import Figure

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

#: Space around the plots in pixels, as in the report.
_MARGIN = {"l": 64, "r": 24, "t": 30, "b": 56}
#: Space above a figure without a legend.
_NO_LEGEND = 6
_TITLE_HEIGHT = 26
_HEADING_HEIGHT = 36
_FONT_SIZE = 13
_ROW_GAP = 12
#: Space between columns, as a share of the width.
_GAP = 0.13
_AXIS = {"automargin": True, "ticks": "outside", "ticklen": 4}
_COLOURS = ("#1f83c4", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999")
_AXIS_KEY = re.compile(r"[xy]axis\d*")


@dataclass(frozen=True)
class _Cell:
    """A figure and its place: shares of the plotting area from the left and from the bottom."""

    figure: Figure
    left: float
    right: float
    bottom: float
    top: float


def arrange(
    rows: Sequence[Sequence[Figure | None]], heading: str, *, one_legend: bool = False
) -> PlotlyFigure:
    """Combine several figures into one Plotly figure.

    Parameters
    ----------
    rows : sequence of sequence of Figure or None
        Rows from the top, figures from the left; all places of a row are equally wide, and None
        leaves one empty. Each figure keeps its height, axes and legend.
    heading : str
        Text above all figures, escaped.
    one_legend : bool
        Whether all figures share one legend, for narrow figures: traces of one name have one
        entry.

    Raises
    ------
    InputError
        Plotly is not installed.
    """
    # Imported here: the report draws its figures itself.
    plotly = import_extra("plotly.graph_objects", "notebook", "a figure")
    height = _HEADING_HEIGHT + sum(_height(row) + _ROW_GAP for row in rows)
    drawn: PlotlyFigure = plotly.Figure(layout=_common(height, heading))
    numbers = {"x": count(1), "y": count(1)}
    for number, cell in enumerate(_cells(rows, height), start=1):
        _add(drawn, cell, numbers, f"legend{number}" if number > 1 else "legend")
    if one_legend:
        _join_legends(drawn)
    return drawn


def _join_legends(drawn: PlotlyFigure) -> None:
    named: set[str] = set()
    for trace in drawn.data:
        is_first = bool(trace.showlegend) and trace.name not in named
        trace.update(legend="legend", legendgroup=trace.name, showlegend=is_first)
        named |= {trace.name} if is_first else set()


def in_columns(figures: Sequence[Figure], columns: int) -> list[list[Figure | None]]:
    """Return figures in rows of equal length; empty places fill the last row."""
    rows = [figures[start : start + columns] for start in range(0, len(figures), columns)]
    return [[*row, *[None] * (columns - len(row))] for row in rows]


def _common(height: int, heading: str) -> dict[str, Any]:
    return {
        "template": "plotly_white",
        "colorway": _COLOURS,
        "font": {"size": _FONT_SIZE},
        "hovermode": "closest",
        "height": height,
        "margin": _MARGIN | {"t": 0, "b": 0},
        "title": {
            "text": f"<b>{heading}</b>",
            "x": 0.0,
            "xref": "paper",
            "y": 1 - 0.5 * _HEADING_HEIGHT / height,
            "yanchor": "middle",
            "font": {"size": 15},
        },
    }


def _height(row: Sequence[Figure | None]) -> int:
    return max(_whole_height(figure) for figure in row if figure is not None)


def _whole_height(figure: Figure) -> int:
    return figure.height + _TITLE_HEIGHT * bool(figure.title)


def _has_legend(figure: Figure) -> bool:
    return bool(figure.layout.get("showlegend", len(figure.data) > 1))


def _margin(figure: Figure) -> dict[str, int]:
    margin = {**_MARGIN, **figure.layout.get("margin", {})}
    return margin if _has_legend(figure) else margin | {"t": _NO_LEGEND}


def _cells(rows: Sequence[Sequence[Figure | None]], height: int) -> Iterator[_Cell]:
    upper = height - _HEADING_HEIGHT
    for row in rows:
        width = (1 - _GAP * (len(row) - 1)) / len(row)
        for column, figure in enumerate(row):
            if figure is not None:
                left = column * (width + _GAP)
                yield _cell(figure, left, left + width, upper, height)
        upper -= _height(row) + _ROW_GAP


def _cell(figure: Figure, left: float, right: float, upper: int, height: int) -> _Cell:
    """Return the place of a figure whose lower edge is given in pixels from below."""
    margin = _margin(figure)
    top = upper - margin["t"] - _TITLE_HEIGHT * bool(figure.title)
    bottom = upper - _whole_height(figure) + margin["b"]
    return _Cell(figure, left, right, bottom / height, top / height)


def _add(
    drawn: PlotlyFigure, cell: _Cell, numbers: Mapping[str, Iterator[int]], legend: str
) -> None:
    layout = cell.figure.layout
    keys = [key for key in {"xaxis": {}, "yaxis": {}, **layout} if _AXIS_KEY.fullmatch(key)]
    names = {key.replace("axis", ""): _axis_name(key[0], next(numbers[key[0]])) for key in keys}
    drawn.update_layout({_axis_key(names[_short(key)]): _axis(key, cell, names) for key in keys})
    drawn.update_layout({legend: _legend(cell)})
    drawn.add_traces([_trace(trace, cell, names, legend) for trace in cell.figure.data])
    for shape in _moved(layout.get("shapes", ()), names):
        drawn.add_shape(shape)
    for annotation in [*_moved(layout.get("annotations", ()), names), *_title(cell)]:
        drawn.add_annotation(annotation)


def _short(key: str) -> str:
    return key.replace("axis", "")


def _axis_name(letter: str, number: int) -> str:
    return letter if number == 1 else f"{letter}{number}"


def _axis_key(name: str) -> str:
    return f"{name[0]}axis{name[1:]}"


def _axis(key: str, cell: _Cell, names: Mapping[str, str]) -> dict[str, Any]:
    axis = {**_AXIS, **cell.figure.layout.get(key, {})}
    axis["title"] = {"font": {"size": _FONT_SIZE}, **axis.get("title", {})}
    if key.startswith("x"):
        return axis | {"domain": [cell.left, cell.right], "anchor": names["y"]}
    if "overlaying" in axis:
        return axis | {"overlaying": names[axis["overlaying"]], "anchor": names["x"]}
    return axis | {"domain": [cell.bottom, cell.top], "anchor": names["x"]}


def _legend(cell: _Cell) -> dict[str, Any]:
    return {
        "orientation": "h",
        "x": cell.left,
        "xanchor": "left",
        "y": cell.top,
        "yanchor": "bottom",
        "bgcolor": "rgba(0,0,0,0)",
    }


def _trace(
    trace: Mapping[str, Any], cell: _Cell, names: Mapping[str, str], legend: str
) -> dict[str, Any]:
    moved = {
        **trace,
        "xaxis": names[trace.get("xaxis", "x")],
        "yaxis": names[trace.get("yaxis", "y")],
    }
    if trace["type"] != "heatmap":
        shown = _has_legend(cell.figure) and trace.get("showlegend", True)
        moved |= {"legend": legend, "showlegend": shown}
    if "colorbar" in trace:
        moved["colorbar"] = {
            **trace["colorbar"],
            "x": cell.right,
            "y": (cell.bottom + cell.top) / 2,
            "len": cell.top - cell.bottom,
        }
    return moved


def _moved(
    elements: Iterable[Mapping[str, Any]], names: Mapping[str, str]
) -> Iterator[dict[str, Any]]:
    """Yield shapes and annotations that refer to the axes of their figure, not to the paper."""
    for element in elements:
        refs = {f"{letter}ref": element.get(f"{letter}ref", letter) for letter in "xy"}
        yield {**element} | {
            key: f"{names[key[0]]} domain" if ref == "paper" else names[ref]
            for key, ref in refs.items()
        }


def _title(cell: _Cell) -> Iterator[dict[str, Any]]:
    if cell.figure.title:
        yield {
            "text": cell.figure.title,
            "xref": "paper",
            "x": cell.left,
            "xanchor": "left",
            "yref": "paper",
            "y": cell.top,
            "yanchor": "bottom",
            "yshift": _margin(cell.figure)["t"],
            "showarrow": False,
            "font": {"size": 14},
        }
