"""The sections of the report, in the order of the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.answer.section import answer
from grainfit.report.sections.convergence.section import convergence
from grainfit.report.sections.curves.section import curves
from grainfit.report.sections.explorer.section import explorer
from grainfit.report.sections.particles.section import particles
from grainfit.report.sections.predicted.section import predicted
from grainfit.report.sections.reproduce.section import reproduce
from grainfit.report.sections.runs.section import runs
from grainfit.report.sections.sensitivity.section import sensitivity
from grainfit.report.sections.surfaces.section import surfaces
from grainfit.report.sections.tradeoff.section import tradeoff
from grainfit.report.sections.undetermined.section import undetermined
from grainfit.report.sections.verification.section import verification
from grainfit.report.sections.yield_locus.section import yield_locus

#: Each returns its section, or None when it has no content.
SECTIONS: Sequence[Callable[[ReportContext], Section | None]] = (
    answer,
    curves,
    yield_locus,
    particles,
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
