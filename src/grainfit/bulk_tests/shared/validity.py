"""Checks that a run means what its test measures: plausible numbers can be wrong."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grainfit.bulk_tests.shared import messages
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.measurement.height_map import HeightMap
from grainfit.measurement.particles import Particles

#: Overlap over diameter above which contacts are no longer those of spheres.
_LARGEST_MEAN_OVERLAP = 0.08
#: So few particles above an orifice may still be falling.
_FEWEST_HELD = 3
#: Mean height of the outermost diameter of a floor, in diameters, at which a heap ends beyond it,
#: and the largest share of the particles that may have rolled off.
_LOWEST_FOOT = 0.3
_LARGEST_SHARE_LOST = 0.02


def require_separate(bed: Particles) -> None:
    """Raise `RunFailedError` if the particles of a bed overlap grossly."""
    if not len(bed):
        raise NotMeasurableError(messages.EMPTY_CONTAINER())
    pairs = cKDTree(bed.positions).query_pairs(2 * bed.radii.max(), output_type="ndarray")
    if bed.clumps is not None:
        pairs = pairs[np.diff(bed.clumps[pairs], axis=1).ravel() != 0]
    distance = np.linalg.norm(bed.positions[pairs[:, 0]] - bed.positions[pairs[:, 1]], axis=1)
    overlap = 1 - distance / bed.radii[pairs].sum(axis=1)
    touching = overlap[overlap > 0]
    mean = float(touching.mean()) if len(touching) else 0.0
    if mean > _LARGEST_MEAN_OVERLAP:
        raise RunFailedError(messages.OVERLAP(percent=100 * mean))


def require_held(stress: float, wanted: float, within: float, stage: str) -> None:
    """Raise `RunFailedError` unless a stress, Pa, is the wanted one within a share of it."""
    if not abs(stress / wanted - 1) <= within:
        raise RunFailedError(messages.STRESS_NOT_HELD(stage=stage, stress=stress, wanted=wanted))


def arch(held: Particles, orifice: str) -> str:
    """Describe the particles at rest that are held above an orifice; empty if there are none.

    Parameters
    ----------
    held : Particles
        Those in the container whose centre is above the middle half of the orifice.
    orifice : str
        In a word, such as ``"slot"``.
    """
    if held.count < _FEWEST_HELD:
        return ""
    return (
        f"the material arches over the {orifice}: {held.count} particles are at rest above its "
        "middle, so the flow did not end by itself"
    )


def require_emptied(held: Particles, orifice: str) -> None:
    """Raise `RunFailedError` if particles at rest are held above an orifice, see `arch`."""
    if found := arch(held, orifice):
        raise RunFailedError(messages.BLOCKED(arch=found, orifice=orifice))


def require_apex_below(apex: float, shelf: float, clearance: float, diameter: float) -> None:
    """Raise `RunFailedError` if a heap has grown so high that it chokes the slot above it.

    Parameters
    ----------
    apex, shelf : float
        Heights above the floor of the heap's apex and of the underside of the shelf, m.
    clearance : float
        Distance that the two must keep, m.
    diameter : float
        Median particle diameter, m.
    """
    if apex > shelf - clearance:
        raise RunFailedError(
            messages.CHOKED(found=(shelf - apex) / diameter, needed=clearance / diameter)
        )


def require_foot_on_floor(surface: HeightMap, lost_share: float, diameter: float) -> None:
    """Raise `RunFailedError` if a heap reaches the edges of its floor.

    Parameters
    ----------
    surface : HeightMap
        From edge to edge of the floor.
    lost_share : float
        Share of the heap's mass that has left the floor.
    diameter : float
        Median particle diameter, m.
    """
    edge = np.abs(surface.x) > np.abs(surface.x).max() - diameter
    highest = _mean_of_sides(surface.profile, edge & (surface.x < 0), edge & (surface.x > 0))
    if lost_share > _LARGEST_SHARE_LOST or highest > _LOWEST_FOOT * diameter:
        raise RunFailedError(messages.FOOT_OFF_FLOOR(percent=100 * lost_share))


def _mean_of_sides(
    profile: NDArray[np.float64], left: NDArray[np.bool_], right: NDArray[np.bool_]
) -> float:
    """Mean height of the higher of two sides."""
    return max(float(profile[left].mean()), float(profile[right].mean()))
