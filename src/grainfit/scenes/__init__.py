"""Scenes: a simulated experiment as plain data in SI units, for every DEM program.

All terms of a scene are here: ``from grainfit.scenes import Box, Scene, Stage, Wall``.
"""

from grainfit.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
