"""Stress over strain of a bed between floor and piston, and what is measured on it."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from grainfit import evaluation
from grainfit.arrays import Array
from grainfit.bulk_tests.compression import messages
from grainfit.bulk_tests.compression.setup import CompressionSetup
from grainfit.errors import NotMeasurableError
from grainfit.scenes.records import Force, RadialForce, Recorded, Travel
from grainfit.scenes.run_output import RunOutput

#: Columns of the series of every stage with a piston.
COLUMNS: dict[str, Recorded] = {
    "travel": Travel("piston"),
    "piston_force": Force("piston", "z"),
    "floor_force": Force("floor", "z"),
    "pot_force": RadialForce("pot"),
}
#: Part of the stress between which moduli are fitted: below, the curve is that of seating; above,
#: the piston slows down.
FITTED = (0.50, 0.98)
_FEWEST_RECORDS = 5
#: Points of a curve that is kept of every run.
_CURVE_POINTS = 60


@dataclass(frozen=True)
class Curve:
    """Stresses over the height of the bed during one stage.

    Parameters
    ----------
    times : ndarray of shape (n,)
        s.
    heights : ndarray of shape (n,)
        Height of the piston above the floor, m.
    stresses, floor_stresses, lateral_stresses : ndarray of shape (n,)
        Of the bed on piston, floor, and the pot's wall under the piston, Pa.
    """

    times: Array
    heights: Array
    stresses: Array
    floor_stresses: Array
    lateral_stresses: Array

    @classmethod
    def of_stage(cls, run: RunOutput, stage: str, setup: CompressionSetup) -> Self:
        """Read the series of a stage.

        Raises
        ------
        NotMeasurableError
            The file is missing or damaged, or a column is missing.
        """
        series = run.series(stage, COLUMNS)
        heights = setup.piston_start + series["travel"]
        return cls(
            series["time"],
            heights,
            series["piston_force"] / setup.area,
            -series["floor_force"] / setup.area,
            series["pot_force"] / (2 * math.pi * setup.cylinder_radius * heights),
        )

    def strains(self, height: float) -> Array:
        """Return the compressive strains from a height of the bed, shape (n,)."""
        return 1 - self.heights / height

    def last(self, seconds: float) -> Curve:
        """Return the records of the last seconds, at least one."""
        late = self.times >= min(self.times[-1] - seconds, self.times[-1])
        return Curve(*(getattr(self, part.name)[late] for part in fields(self)))


@dataclass(frozen=True)
class Modulus:
    """Slope of stress over strain.

    Parameters
    ----------
    value : float
        Pa.
    standard_error : float
        Of the fitted line, Pa: it knows nothing of another bed.
    stress_at_zero : float
        Stress of the line at zero strain, Pa.
    """

    value: float
    standard_error: float
    stress_at_zero: float


def loading_curves(
    curve: Curve, height: float, seating_stress: float, stress: float
) -> dict[str, evaluation.Curve]:
    """Return stress over strain, and strain over stress, of loading up to a stress.

    Both rise: where the stress drops for a moment, what was reached before counts.

    Parameters
    ----------
    curve : Curve
        Of loading.
    height : float
        Height of the bed at zero strain, m.
    seating_stress, stress : float
        Stresses of the piston, Pa, at which both begin and end.

    Raises
    ------
    NotMeasurableError
        There are too few records.
    """
    strains = np.maximum.accumulate([0.0, *curve.strains(height)])
    stresses = np.maximum.accumulate([seating_stress, *curve.stresses])
    rising = np.flatnonzero(
        (np.diff(strains, prepend=-1.0) > 0) & (np.diff(stresses, prepend=-1.0) > 0)
    )
    if len(rising) < _FEWEST_RECORDS:
        words = "stress over strain: there are too few records; use a lower piston_speed."
        raise NotMeasurableError(words)
    strains, stresses = strains[rising], stresses[rising]
    # The stage ends when the stress is held within a percent: its last strain is that of it.
    stresses[-1] = max(stress, stresses[-1])
    at_stress = np.linspace(seating_stress, stress, _CURVE_POINTS)
    at_strain = np.interp(at_stress, stresses, strains)
    return {
        "stress": evaluation.Curve(at_strain.tolist(), at_stress.tolist()),
        "strain": evaluation.Curve(at_stress.tolist(), at_strain.tolist()),
    }


def fit_modulus(curve: Curve, height: float, stress: float, name: str) -> Modulus:
    """Fit a line to stress over strain between 50 and 98 % of a stress.

    Parameters
    ----------
    curve : Curve
        Of loading or unloading.
    height : float
        Height of the bed at zero strain, m.
    stress : float
        Largest stress, Pa.
    name : str
        Of the response, for messages.

    Raises
    ------
    NotMeasurableError
        There are too few records between these stresses, or they do not rise.
    """
    fitted = (curve.stresses > FITTED[0] * stress) & (curve.stresses < FITTED[1] * stress)
    count = int(fitted.sum())
    if count < _FEWEST_RECORDS:
        raise NotMeasurableError(
            messages.FEW_RECORDS(
                modulus=name, count=count, low=FITTED[0], high=FITTED[1], stress=stress
            )
        )
    strains, stresses = curve.strains(height)[fitted], curve.stresses[fitted]
    spread = float(((strains - strains.mean()) ** 2).sum())
    slope = 0.0
    if spread > 0:
        slope = float(((strains - strains.mean()) * stresses).sum()) / spread
    if slope <= 0:
        raise NotMeasurableError(messages.NO_RISE(modulus=name))
    zero = float(stresses.mean()) - slope * float(strains.mean())
    rest = stresses - zero - slope * strains
    error = math.sqrt(float(rest @ rest) / (count - 2) / spread)
    return Modulus(slope, error, zero)
