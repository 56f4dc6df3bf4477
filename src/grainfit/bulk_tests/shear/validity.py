"""Checks that a sheared bed means what the test measures: plausible numbers can be wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from grainfit.bulk_tests.shear import messages
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
            messages.NOT_HELD(stress=stress, wanted=setup.normal_stress, longer=longer)
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
            raise RunFailedError(messages.LEAKED(count=leaked))


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
            messages.OTHER_INERTIAL_NUMBER(
                found=found,
                wanted=setup.inertial_number,
                gap=gap,
                expected=setup.gap,
                density=bed,
                use=use,
            )
        )


def _require_even_shear(profile: Profile) -> None:
    if not profile.middle_share >= _LEAST_SHEARED:
        raise RunFailedError(messages.HARDLY_SHEARED(share=profile.middle_share))
    if not profile.steepest <= _STEEPEST:
        raise RunFailedError(messages.LOCALISED(steepest=profile.steepest, most=_STEEPEST))
