"""Yield locus: cohesion and angle of internal friction from shear tests at several stresses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grainfit.evaluation import Response


@dataclass(frozen=True)
class YieldLocus:
    """A line through shear stress over normal stress.

    Parameters
    ----------
    cohesion : Response
        Shear stress without normal stress, Pa.
    internal_friction_angle : Response
        Slope of the line, degrees.
    """

    cohesion: Response
    internal_friction_angle: Response


def fit_yield_locus(normal_stresses: Sequence[float], angles: Sequence[Response]) -> YieldLocus:
    """Fit shear stress = cohesion + tan(angle) normal stress to several shear tests.

    Parameters
    ----------
    normal_stresses : sequence of float
        Two or more different ones, Pa.
    angles : sequence of Response
        ``internal_friction_angle`` of each test, degrees; its tangent is the shear stress over the
        normal stress.

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
        raise ValueError("needs an angle for each of two or more different normal stresses")
    if not ((stress > 0).all() and (errors > 0).all()):
        raise ValueError("needs normal stresses and standard errors above zero")
    slopes = np.tan(np.radians(degrees))
    weights = 1 / (stress * (1 + slopes**2) * errors)
    design = np.column_stack((np.ones_like(stress), stress)) * weights[:, None]
    covariance = np.linalg.inv(design.T @ design)
    cohesion, slope = covariance @ design.T @ (stress * slopes * weights)
    spread = np.sqrt(np.diag(covariance))
    return YieldLocus(
        Response(float(cohesion), float(spread[0])),
        Response(math.degrees(math.atan(slope)), math.degrees(float(spread[1]) / (1 + slope**2))),
    )
