"""Solvers: DEM programs and custom models, all with the interface `grainfit.solvers.base.Solver`.

Classes such as ``grainfit.solvers.Lammps`` are imported when they are first used.
"""

from grainfit.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
