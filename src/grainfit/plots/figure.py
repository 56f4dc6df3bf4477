"""A figure as plain data: drawn by the page of the report, or by Plotly in a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.errors import Fault, InputError


@dataclass(frozen=True)
class Figure:
    """A figure as plain data, without fonts and colours of text and paper.

    Parameters
    ----------
    data, layout : sequence of mapping, mapping
        As Plotly has them. Fonts, paper, grid and colours of text belong to the page or the
        notebook, which knows whether it is light or dark: leave them out. Names in them are
        escaped (`Label.plot`).
    description : str
        The content in words, for readers who do not see it.
    height : int
        In pixels.
    title : str
        Heading above the figure, where no page says it. Escaped as well.
    """

    data: tuple[Mapping[str, Any], ...]
    layout: Mapping[str, Any]
    description: str
    height: int = 420
    title: str = ""


def no_figure(reasons: str) -> InputError:
    """Return the error of a figure that cannot be drawn yet, with the reasons in sentences."""
    return InputError(Fault("", "there is nothing to draw yet:", reasons))
