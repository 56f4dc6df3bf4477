"""Yield locus: cohesion and angle of internal friction from shear tests at several stresses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from grainfit.evaluation import Response
from grainfit.measurement import messages
from grainfit.result import YieldLocus


def fit_yield_locus(
    normal_stresses: Sequence[float],
    angles: Sequence[Response],
    correlations: ArrayLike | None = None,
) -> YieldLocus:
    """Fit shear stress = cohesion + tan(angle) normal stress to several shear tests.

    Parameters
    ----------
    normal_stresses : sequence of float
        Two or more different ones, Pa.
    angles : sequence of Response
        ``internal_friction_angle`` of each test, degrees; its tangent is the shear stress over the
        normal stress.
    correlations : array_like, shape (tests, tests), optional
        Correlations of the errors of the angles; by default there are none.

    Raises
    ------
    ValueError
        There are not two different stresses, or a stress or a standard error is not positive.

    Examples
    --------
    >>> angles = [Response(30.0, 0.3), Response(28.0, 0.3)]
    >>> locus = fit_yield_locus([500.0, 1000.0], angles)
    >>> round(locus.cohesion.value, 1), round(locus.internal_friction_angle.value, 1)
    (45.6, 25.9)
    """
    stress = np.array(normal_stresses, dtype=float)
    degrees = np.array([angle.value for angle in angles])
    errors = np.radians([angle.standard_error for angle in angles])
    if len(stress) != len(degrees) or len(set(stress)) < 2:
        raise ValueError(messages.TWO_STRESSES())
    if not ((stress > 0).all() and (errors > 0).all()):
        raise ValueError(messages.NO_ERRORS())
    slopes = np.tan(np.radians(degrees))
    shear, spread = stress * slopes, stress * (1 + slopes**2) * errors
    between = np.eye(len(stress)) if correlations is None else np.asarray(correlations)
    # Multiplied by it, errors are of size one and not correlated.
    whiten = np.linalg.inv(np.linalg.cholesky(between)) / spread
    design = whiten @ np.column_stack((np.ones_like(stress), stress))
    inverse = np.linalg.pinv(design)
    cohesion, slope = inverse @ whiten @ shear
    of_cohesion, of_slope = np.linalg.norm(inverse, axis=1)
    angle_error = math.degrees(float(of_slope) / (1 + slope**2))
    return YieldLocus(
        tuple(stress.tolist()),
        tuple(map(Response, shear.tolist(), spread.tolist())),
        Response(float(cohesion), float(of_cohesion)),
        Response(math.degrees(math.atan(slope)), angle_error),
    )
