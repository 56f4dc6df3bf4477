"""Plotly figures of a `SavedCalibration`: the same as in the report.

Each function takes what `grainfit.open` returns:

>>> import grainfit as gf
>>> saved = gf.open("beads.grainfit")  # doctest: +SKIP
>>> gf.plots.convergence(saved).show()  # doctest: +SKIP
"""

from grainfit.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
