"""Figure as plain data, drawn by the report or by Plotly in a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.errors import InputError
from grainfit.plots import messages


@dataclass(frozen=True)
class Figure:
    """A figure as plain data, without fonts and colours of text and paper.

    Parameters
    ----------
    data, layout : sequence of mapping, mapping
        As in Plotly. Leave out fonts, paper, grid and colours of text: the report and the notebook
        set them, because they know if the theme is light or dark. Names are escaped
        (`Label.plot`).
    description : str
        The content in words, for readers who cannot see it.
    height : int
        In pixels.
    title : str
        Heading above the figure outside the report; escaped as well.
    """

    data: tuple[Mapping[str, Any], ...]
    layout: Mapping[str, Any]
    description: str
    height: int = 420
    title: str = ""


def no_figure(reasons: str) -> InputError:
    """Return the error of a figure that cannot be drawn yet, with the reasons in sentences."""
    return InputError(messages.NOTHING_TO_DRAW.fault("", reasons=reasons))
