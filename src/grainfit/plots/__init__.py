"""Plotly figures of a `SavedCalibration`: the same as in the report.

Each function takes what `grainfit.open` returns:

>>> import grainfit as gf
>>> saved = gf.open("beads.grainfit")  # doctest: +SKIP
>>> gf.plots.convergence(saved).show()  # doctest: +SKIP
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grainfit.plots.convergence_figures import convergence
    from grainfit.plots.curves_figures import curves
    from grainfit.plots.pairs_figures import pairs
    from grainfit.plots.parallel_figures import parallel
    from grainfit.plots.pareto_figures import pareto
    from grainfit.plots.posterior_figures import posterior
    from grainfit.plots.predicted_figures import predicted
    from grainfit.plots.sensitivity_figures import sensitivity
    from grainfit.plots.yield_locus_figures import yield_locus

__all__ = [
    "convergence",
    "curves",
    "pairs",
    "parallel",
    "pareto",
    "posterior",
    "predicted",
    "sensitivity",
    "yield_locus",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    # Imported on first use: importing the metamodels takes a second.
    return getattr(import_module(f"{__name__}.{name}_figures"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
