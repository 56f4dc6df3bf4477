"""Plotly figures of a `SavedCalibration`: the same as in the report.

Each function takes what `grainfit.open` returns:

>>> import grainfit as gf
>>> saved = gf.open("beads.grainfit")  # doctest: +SKIP
>>> gf.plots.convergence(saved).show()  # doctest: +SKIP
"""

from pathlib import Path

from grainfit.lazy import public_names
from grainfit.registration import require_complete

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

for _name in __all__:
    _is_there = Path(__file__).with_name(f"{_name}_figures.py").is_file()
    require_complete("figure", _name, [] if _is_there else [f"{_name}_figures.py is missing"])
