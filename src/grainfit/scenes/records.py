"""Quantities that a scene records over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Force:
    """Force of all loose particles on a wall or a glued set along an axis, N."""

    wall: str
    along: str


@dataclass(frozen=True)
class RadialForce:
    """Sum of the forces of particles on a wall away from the z axis, N."""

    wall: str


@dataclass(frozen=True)
class Travel:
    """Distance that a wall or a glued set has moved since it was put, m.

    Of one that turns, the angle by which it has turned, rad.

    Parameters
    ----------
    wall : str
        Its name.
    along : str
        Axis; a wall moves along the axis of its motions only, and needs none.
    """

    wall: str
    along: str = ""


@dataclass(frozen=True)
class MassAbove:
    """Mass of the loose particles whose centre is above a height, kg."""

    height: float


@dataclass(frozen=True)
class KineticEnergy:
    """Kinetic energy of the translation of all loose particles, J."""


Recorded = Force | RadialForce | Travel | MassAbove | KineticEnergy


@dataclass(frozen=True)
class Series:
    """Quantities recorded at an interval during a stage.

    Parameters
    ----------
    columns : mapping of str to Recorded
        Quantities by name of their column.
    every : float
        Simulated time between two records, s.
    """

    columns: Mapping[str, Recorded]
    every: float


@dataclass(frozen=True)
class Frames:
    """Snapshots of all particles at an interval during a stage, in one file.

    Parameters
    ----------
    name : str
        Name of the file, apart from those of snapshots.
    every : float
        Simulated time between two frames, s.
    """

    name: str
    every: float
