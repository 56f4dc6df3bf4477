"""The sections of the report, in the order of the page."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from grainfit.registration import require_complete, require_unique
from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.answer.section import answer
from grainfit.report.sections.convergence.section import convergence
from grainfit.report.sections.curves.section import curves
from grainfit.report.sections.explorer.section import explorer
from grainfit.report.sections.holdout.section import holdout
from grainfit.report.sections.particles.section import particles
from grainfit.report.sections.photographs.section import photographs
from grainfit.report.sections.predicted.section import predicted
from grainfit.report.sections.reproduce.section import reproduce
from grainfit.report.sections.runs.section import runs
from grainfit.report.sections.sensitivity.section import sensitivity
from grainfit.report.sections.surfaces.section import surfaces
from grainfit.report.sections.tradeoff.section import tradeoff
from grainfit.report.sections.undetermined.section import undetermined
from grainfit.report.sections.verification.section import verification
from grainfit.report.sections.yield_locus.section import yield_locus

_Make = Callable[[ReportContext], Section | None]

#: Those for ten minutes, which are folded on the screen and open on paper.
FOLDED: Sequence[_Make] = (
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
#: Each returns its section, or None when it has no content: first the answer, for ten seconds, then
#: what was measured beside what was simulated, for a minute.
SECTIONS: Sequence[_Make] = (
    answer,
    photographs,
    curves,
    yield_locus,
    holdout,
    particles,
    *FOLDED,
)


def missing(section: Callable[[ReportContext], Section | None]) -> Iterator[str]:
    """Iterate over what a section lacks: its page, and its place, which is named like it."""
    place = Path(inspect.getfile(section)).parent
    if place.name != section.__name__:
        yield f"its folder is {place.name}"
    if not (place / "page.html.jinja").is_file():
        yield "page.html.jinja is missing"


require_unique("section of the report", (section.__name__ for section in SECTIONS))
for _section in SECTIONS:
    require_complete("section of the report", _section.__name__, missing(_section))
