"""Shapes of walls: plane, block, prism, cylinder, cone, disc, annulus, mesh. Lengths in m."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grainfit.one_line import OneLine

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Plane:
    """An infinite plane, perpendicular to an axis; particles are on the side of the normal.

    Parameters
    ----------
    axis : {"x", "y", "z"}
        Axis of the normal.
    at : float
        Coordinate on that axis.
    upwards : bool
        Whether the normal points in the positive direction.
    """

    axis: str
    at: float
    upwards: bool = True


@dataclass(frozen=True)
class Block(OneLine):
    """A solid block, met from outside: its faces, edges and corners are exact.

    Parameters
    ----------
    low, high : tuple of float
        Corners. Along a periodic axis the block is infinite, and they have no effect.
    """

    low: Vector
    high: Vector


@dataclass(frozen=True)
class Prism(OneLine):
    """A solid block whose upper side is shifted along x, met from outside: the slope of a wedge.

    Parameters
    ----------
    low, high : tuple of float
        Corners of the block before its upper side is shifted. Along a periodic y axis it is
        infinite, and they have no effect.
    shift : float
        Of the upper side along x.
    """

    low: Vector
    high: Vector
    shift: float


@dataclass(frozen=True)
class Cylinder(OneLine):
    """A tube about an axis through the origin with open ends, met from inside.

    Parameters
    ----------
    radius : float
        Inner radius.
    bottom, top : float
        Coordinates of its ends on the axis. Along a periodic axis the tube is infinite, and they
        have no effect.
    axis : {"x", "y", "z"}
        Its axis; upright by default.
    """

    radius: float
    bottom: float
    top: float
    axis: str = "z"


@dataclass(frozen=True)
class Cone:
    """An upright funnel about the z axis with open ends, met from inside.

    Parameters
    ----------
    lower_radius, upper_radius : float
        Inner radii at the ends.
    bottom, top : float
        Heights of its ends.
    """

    lower_radius: float
    upper_radius: float
    bottom: float
    top: float


@dataclass(frozen=True)
class Disc:
    """A horizontal round plate about the z axis; particles are on top, and may fall off its edge.

    Parameters
    ----------
    radius : float
        Of the plate.
    z : float
        Height of its upper side.
    """

    radius: float
    z: float


@dataclass(frozen=True)
class Annulus:
    """A thin horizontal ring about the z axis: a floor with a sharp-edged round orifice.

    Parameters
    ----------
    inner_radius, outer_radius : float
        Of the orifice, and of the floor.
    z : float
        Height.
    """

    inner_radius: float
    outer_radius: float
    z: float


@dataclass(frozen=True)
class Mesh(OneLine):
    """Triangles of an STL file, text or binary, met from both sides.

    Parameters
    ----------
    path : Path
        The file.
    scale : float
        Metres in a unit of the file: 0.001 for one in mm.
    """

    path: Path
    scale: float = 1.0


Shape = Plane | Block | Prism | Cylinder | Cone | Disc | Annulus | Mesh
