"""Checks that a run means what its test measures: plausible numbers can be wrong."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.measurement.particles import Particles
from grainfit.scenes.run_output import StageEnd

#: Overlap over diameter above which contacts are no longer those of spheres.
_LARGEST_MEAN_OVERLAP = 0.08


def require_separate(bed: Particles) -> None:
    """Raise `RunFailedError` if the particles of a bed overlap grossly."""
    if not len(bed):
        raise NotMeasurableError("no particles are left in the cylinder")
    pairs = cKDTree(bed.positions).query_pairs(2 * bed.radii.max(), output_type="ndarray")
    distance = np.linalg.norm(bed.positions[pairs[:, 0]] - bed.positions[pairs[:, 1]], axis=1)
    overlap = 1 - distance / bed.radii[pairs].sum(axis=1)
    touching = overlap[overlap > 0]
    mean = float(touching.mean()) if len(touching) else 0.0
    if mean > _LARGEST_MEAN_OVERLAP:
        raise RunFailedError(
            f"the particles overlap grossly, by {100 * mean:.0f} % of their diameter on average: "
            "Young's modulus is too small for this load"
        )


def require_held(stress: float, wanted: float, within: float, stage: str) -> None:
    """Raise `RunFailedError` unless a stress, Pa, is the wanted one within a share of it."""
    if not abs(stress / wanted - 1) <= within:
        raise RunFailedError(
            f"the stress was not held in the {stage} stage: {stress:.4g} Pa instead of "
            f"{wanted:g} Pa at its end"
        )


def require_at_rest(stage: StageEnd, mass: float, quiet_speed: float) -> None:
    """Raise `RunFailedError` unless the particles were at rest at the end of a stage.

    Parameters
    ----------
    stage : StageEnd
        End of the stage.
    mass : float
        Of all particles, kg.
    quiet_speed : float
        They are at rest when they have less kinetic energy than if all had this speed, m/s.
    """
    limit = mass * quiet_speed**2 / 2
    if not stage.kinetic_energy < limit:
        raise RunFailedError(
            f"the bed was not at rest at the end of the {stage.name} stage (kinetic energy "
            f"{stage.kinetic_energy:.3g} J, at rest below {limit:.3g} J)"
        )
