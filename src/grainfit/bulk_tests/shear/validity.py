"""Checks that a sheared bed means what the test measures: plausible numbers can be wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from grainfit.bulk_tests.shear.flow import Frame, Profile, Record
from grainfit.bulk_tests.shear.setup import ShearSetup
from grainfit.errors import RunFailedError

#: Largest deviation of the mean normal stress.
_HELD = 0.01
#: Largest deviation of the inertial number: the angle then deviates by less than 0.2 degrees.
_INERTIAL = 0.2
#: Smallest share of the plate's velocity that the middle half of the gap takes up; 0.5 if even.
_LEAST_SHEARED = 0.25
#: Largest shear rate within two diameters over the mean, which is 1.3 to 2.1 at the defaults. The
#: inertial number is that much larger there, and the angle by up to a degree.
_STEEPEST = 3.0


def require_sheared(
    setup: ShearSetup,
    frames: Sequence[Frame],
    records: Sequence[Record],
    speed: float,
    profile: Profile,
    *,
    within: float = _HELD,
    longer: str = "transient_strain or averaged_strain",
) -> None:
    """Raise `RunFailedError` unless the bed was sheared as the test requires.

    Parameters
    ----------
    setup : ShearSetup
        Geometry and procedure.
    frames : sequence of Frame
        Snapshots of the averaged part.
    records : sequence of Record
        Stresses of the averaged part.
    speed : float
        Mean velocity of the upper plate then, m/s.
    profile : Profile
        Mean velocities of the averaged part.
    within : float
        Largest deviation of the mean normal stress, as a share.
    longer : str
        Options that give the bed more time.
    """
    _require_no_leak(frames, setup.plate.diameter)
    stress = _mean_normal_stress(records)
    if not abs(stress / setup.normal_stress - 1) <= within:
        raise RunFailedError(
            f"the normal stress was not held: {stress:.4g} Pa instead of "
            f"{setup.normal_stress:g} Pa on average, because the bed still dilates or settles; "
            f"use a larger {longer}"
        )
    _require_inertial_number(setup, frames[0], speed, profile.gap)
    _require_even_shear(profile)


def is_held(setup: ShearSetup, records: Sequence[Record]) -> bool:
    """Return whether the mean normal stress is the wanted one within 1 %."""
    return abs(_mean_normal_stress(records) / setup.normal_stress - 1) <= _HELD


def _mean_normal_stress(records: Sequence[Record]) -> float:
    return float(np.concatenate([record.normal_stresses for record in records]).mean())


def _require_no_leak(frames: Sequence[Frame], diameter: float) -> None:
    for frame in frames:
        low, high = frame.plates
        z = frame.bed.positions[:, 2]
        leaked = int(((z < low - diameter / 2) | (z > high + diameter / 2)).sum())
        if leaked:
            raise RunFailedError(
                f"{leaked} particles leaked through a plate: Young's modulus is too small for "
                "this stress, or the smallest particles are much smaller than the others"
            )


def _require_inertial_number(setup: ShearSetup, frame: Frame, speed: float, gap: float) -> None:
    density = frame.bed.masses.sum() / frame.bed.volumes.sum()
    found = speed / gap * setup.diameter / math.sqrt(setup.normal_stress / density)
    if not abs(found / setup.inertial_number - 1) <= _INERTIAL:
        bed, use = (
            ("denser", "sizes that are nearer to each other")
            if gap < setup.gap
            else ("looser", "a larger normal_stress, which compacts a cohesive bed")
        )
        raise RunFailedError(
            f"the inertial number is {found:.3g} instead of {setup.inertial_number:g}: the plates "
            f"are {gap:.3g} m apart, and their speed is that for {setup.gap:.3g} m, because the "
            f"bed is much {bed} than a solid fraction of 0.58; use {use}, or other frictions"
        )


def _require_even_shear(profile: Profile) -> None:
    if not profile.middle_share >= _LEAST_SHEARED:
        raise RunFailedError(
            f"the bed was hardly sheared: its middle half took up {profile.middle_share:.0%} of "
            "the plate's velocity (50 % if even), the rest slipped at the plates; use a larger "
            "gap, or a smaller inertial_number"
        )
    if not profile.steepest <= _STEEPEST:
        raise RunFailedError(
            f"the shear is localised: within two diameters the shear rate is "
            f"{profile.steepest:.2g} times the mean (at most {_STEEPEST:g}); use a smaller "
            "inertial_number, or a larger averaged_strain"
        )
