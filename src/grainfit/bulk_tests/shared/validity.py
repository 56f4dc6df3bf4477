"""Checks that a run means what its test measures: plausible numbers can be wrong."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.measurement.particles import Particles

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
