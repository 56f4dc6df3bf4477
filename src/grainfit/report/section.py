"""A section of the report, and the context that it is made from.

A section is a function of the context: it returns its HTML, its figures as Plotly's JSON, and data
for its own script, or None when it has nothing to say. It reads no files but run folders, and knows
nothing of the page around it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from markupsafe import Markup

from grainfit.analysis.analysis import Analysis
from grainfit.analysis.posterior import Posterior
from grainfit.formatting import plain
from grainfit.metamodels.curve_reduction import Reduction
from grainfit.plots.figure import Figure
from grainfit.plots.labels import Label, in_words, label_of_parameter, label_of_response
from grainfit.problem import Parameter, Target
from grainfit.report.rendering import fill_template
from grainfit.result import ParameterInterval
from grainfit.work_folder.saved_calibration import SavedCalibration


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Parameters
    ----------
    key : str
        Its address in the page, and prefix of the keys of its figures.
    title : str
        Heading: a question of the reader, or a noun.
    html : Markup
        Content. An element ``<div data-figure="KEY">`` is the place of a figure.
    figures : mapping of str to Figure
        By key.
    data : mapping
        Data of its script, as JSON.
    """

    key: str
    title: str
    html: Markup
    figures: Mapping[str, Figure] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class ReportContext:
    """Context of all sections: the calibration and its analysis.

    Parameters
    ----------
    reading : SavedCalibration
        The calibration, read from its work folder.
    analysis : Analysis
        The analysis of its runs.
    """

    reading: SavedCalibration
    analysis: Analysis

    @property
    def answer(self) -> Mapping[str, float]:
        """Parameters of the answer, SI; empty when there is none yet."""
        return self.reading.result.parameters if self.reading.result else {}

    @property
    def posterior(self) -> Posterior | None:
        """Parameter sets that agree with the measurements; None if there are none."""
        return None if self.reading.why_nothing_agrees else self.analysis.posterior

    @property
    def intervals(self) -> Mapping[str, ParameterInterval]:
        """95 % intervals of the parameters: those of the result, else those of the analysis."""
        result = self.reading.result
        if result is not None and result.intervals and not self.reading.why_nothing_agrees:
            return result.intervals
        return {} if self.posterior is None else self.analysis.intervals

    @property
    def why_no_posterior(self) -> str:
        """Reason why there is no posterior; empty if there is one."""
        notes = " ".join(plain(note) for note in self.analysis.notes)
        return (
            self.reading.why_nothing_agrees
            or notes
            or "The runs do not suffice for an interval yet."
        )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The free parameters."""
        return tuple(self.reading.problem.parameters)

    @property
    def targets(self) -> tuple[Target, ...]:
        """The targets."""
        return tuple(self.reading.problem.targets)

    @cached_property
    def reduction(self) -> Reduction:
        """Components of the curves, by all runs."""
        return Reduction.where_possible(self.reading.problem, self.reading.known)

    def parameter_label(self, name: str) -> Label:
        """Return the label of a free or fixed parameter on the page."""
        return label_of_parameter(self.reading, name)

    def in_words(self, sentence: str) -> str:
        """Return a sentence with the words of the page for free parameters and responses."""
        return in_words(self.reading, sentence)

    def response_label(self, name: str) -> Label:
        """Return the label of a response on the page."""
        return label_of_response(self.reading, name)


def waiting(context: ReportContext, key: str, title: str, reason: str = "") -> Section:
    """Return a section without content yet, with a reason or else the notes of the analysis."""
    reasons = [reason] if reason else [plain(note) for note in context.analysis.notes]
    return Section(key, title, fill_template("waiting", reasons=reasons))


def without_metamodel(context: ReportContext) -> list[Label]:
    """Responses without a metamodel, which are missing in sections that need one."""
    metamodels = context.analysis.metamodels
    known = {target.name for target in metamodels.problem.targets} if metamodels else set()
    return [context.response_label(t.name) for t in context.targets if t.name not in known]
