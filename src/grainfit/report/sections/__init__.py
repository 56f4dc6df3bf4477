"""The sections of the report, in the order in which a person asks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec

from grainfit.report.section import ReportContext, Section

_ORDER = (
    "answer",
    "heap",
    "convergence",
    "surfaces",
    "explorer",
    "predicted",
    "sensitivity",
    "tradeoff",
    "undetermined",
    "verification",
    "runs",
    "reproduce",
)

#: Each returns its section, or None when it has nothing to say.
SECTIONS: Sequence[Callable[[ReportContext], Section | None]] = tuple(
    getattr(import_module(f"{__name__}.{name}"), name)
    for name in _ORDER
    if find_spec(f"{__name__}.{name}")
)
