"""The sections of the report, in the order in which a person asks."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.answer import answer
from grainfit.report.sections.convergence import convergence
from grainfit.report.sections.explorer import explorer
from grainfit.report.sections.heap import heap
from grainfit.report.sections.predicted import predicted
from grainfit.report.sections.reproduce import reproduce
from grainfit.report.sections.runs import runs
from grainfit.report.sections.sensitivity import sensitivity
from grainfit.report.sections.surfaces import surfaces
from grainfit.report.sections.tradeoff import tradeoff
from grainfit.report.sections.undetermined import undetermined
from grainfit.report.sections.verification import verification

#: Each returns its section, or None when it has nothing to say.
SECTIONS: Sequence[Callable[[ReportContext], Section | None]] = (
    answer,
    heap,
    convergence,
    surfaces,
    explorer,
    predicted,
    sensitivity,
    tradeoff,
    undetermined,
    verification,
    runs,
    reproduce,
)
