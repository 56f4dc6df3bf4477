"""Stresses and strains of a bed between six walls, and what is measured on them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from grainfit.arrays import Array
from grainfit.bulk_tests.triaxial import messages
from grainfit.bulk_tests.triaxial.setup import SIDES, TriaxialSetup
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.scenes.records import Force, Recorded, Travel
from grainfit.scenes.run_output import RunOutput

COMPRESS, SHEAR = "compress", "shear"
#: Columns of the series of the compression.
COLUMNS: dict[str, Recorded] = {
    **{f"{wall}_force": Force(wall, axis) for axis, pair in SIDES.items() for wall in pair},
    **{f"{moving}_travel": Travel(moving) for _, moving in SIDES.values()},
}
#: Largest deviations of the confining stress, and between opposite walls.
_HELD, _BALANCED = 0.05, 0.05
_FEWEST_RECORDS = 40
#: Strain over which angles are averaged before the largest counts, and stresses of curves.
_PEAK_WINDOW, _CURVE_WINDOW = 0.02, 0.005
_CURVE_POINTS = 60


@dataclass(frozen=True)
class Compression:
    """Stresses of a bed over its axial strain.

    Parameters
    ----------
    strains, volumetric_strains : ndarray of shape (n,)
        Axial and volumetric strain since isotropic compression, over the first height and volume;
        positive in compression.
    axial, lateral : ndarray of shape (n,)
        Mean stress on upper and lower wall, and on the side walls, Pa.
    lengths : tuple of float
        Width, depth and height of the box at strain zero, m.
    last_lengths : tuple of float
        The same at the end of the run, m.
    imbalances : mapping of str to float
        Difference of the forces on two opposite walls over their mean, by axis.
    """

    strains: Array
    volumetric_strains: Array
    axial: Array
    lateral: Array
    lengths: tuple[float, float, float]
    last_lengths: tuple[float, float, float]
    imbalances: dict[str, float]

    @classmethod
    def of_run(cls, run: RunOutput, setup: TriaxialSetup) -> Self:
        """Read the compression of a run.

        Raises
        ------
        NotMeasurableError
            The file is missing or damaged, or has few records.
        """
        series = run.series(SHEAR, COLUMNS)
        if len(series["time"]) < _FEWEST_RECORDS:
            raise NotMeasurableError(messages.FEW_RECORDS())
        lengths = {
            axis: first + series[f"{SIDES[axis][1]}_travel"]
            for axis, first in setup.first_lengths.items()
        }
        forces, imbalances = {}, {}
        for axis, (low, high) in SIDES.items():
            one, other = -series[f"{low}_force"], series[f"{high}_force"]
            forces[axis] = (one + other) / 2
            imbalances[axis] = float(abs((other - one).mean()) / max(forces[axis].mean(), 1e-300))
        x, y, z = lengths.values()
        # The first record is a little later than the beginning.
        began, ended = run.stages[0].time, run.stages[1].time
        start = {axis: _at(began, series["time"], way) for axis, way in lengths.items()}
        end = {axis: _at(ended, series["time"], way) for axis, way in lengths.items()}
        volume = math.prod(start.values())
        return cls(
            1 - z / start["z"],
            1 - x * y * z / volume,
            forces["z"] / (x * y),
            (forces["x"] / (y * z) + forces["y"] / (x * z)) / 2,
            (start["x"], start["y"], start["z"]),
            (end["x"], end["y"], end["z"]),
            imbalances,
        )

    @property
    def volume(self) -> float:
        """Volume of the bed at strain zero, m^3."""
        return math.prod(self.lengths)

    def smooth(self, values: Array, window: float) -> Array:
        """Return running means over a strain, shorter at both ends, shape (n,)."""
        sums = np.append(0.0, np.cumsum(values))
        low = np.searchsorted(self.strains, self.strains - window / 2)
        high = np.searchsorted(self.strains, self.strains + window / 2, side="right")
        found: Array = (sums[high] - sums[low]) / (high - low)
        return found

    @property
    def deviatoric(self) -> Array:
        """Axial stress less lateral stress, Pa, shape (n,)."""
        return self.axial - self.lateral

    @property
    def peak_angle(self) -> float:
        """Largest mobilised friction angle, degrees."""
        axial, lateral = (self.smooth(one, _PEAK_WINDOW) for one in (self.axial, self.lateral))
        return max(mobilised_angle(a, b) for a, b in zip(axial, lateral, strict=True))

    def last_angle(self, strain: float, averaged: float) -> float:
        """Return the mobilised friction angle over the last part of a strain, degrees."""
        late = (self.strains > strain - averaged) & (self.strains <= strain)
        return mobilised_angle(self.axial[late].mean(), self.lateral[late].mean())

    def curves(self, strain: float) -> dict[str, tuple[Array, Array]]:
        """Return strains and values of both curves up to a strain."""
        at = np.linspace(0.0, strain, _CURVE_POINTS)
        smooth = self.smooth(self.deviatoric, _CURVE_WINDOW)
        later = self.strains > 0
        known, stresses, volumes = (
            np.append(0.0, values[later])
            for values in (self.strains, smooth, self.volumetric_strains)
        )
        return {
            "deviatoric_stress": (at, np.interp(at, known, stresses)),
            "volumetric_strain": (at, np.interp(at, known, volumes)),
        }

    def require_valid(self, setup: TriaxialSetup) -> None:
        """Raise `RunFailedError` unless the bed was compressed as the test requires."""
        if self.strains[-1] < setup.axial_strain:
            found, height = float(self.strains[-1]), self.lengths[2]
            wanted = float(setup.axial_strain)
            words = messages.SHORT_STRAIN(found=found, wanted=wanted, height=height)
            raise RunFailedError(words)
        for axis, share in self.imbalances.items():
            if not share <= _BALANCED:
                low, high = SIDES[axis]
                raise RunFailedError(messages.NOT_BALANCED(low=low, high=high, share=share))
        wrong = np.abs(self.smooth(self.lateral, _PEAK_WINDOW) / setup.confining_stress - 1)
        wrong = wrong[self.strains <= setup.axial_strain]
        if not wrong.max() <= _HELD:
            worst = int(wrong.argmax())
            raise RunFailedError(
                messages.NOT_CONFINED(
                    stress=float(self.lateral[worst]),
                    wanted=float(setup.confining_stress),
                    strain=float(self.strains[worst]),
                )
            )


def mobilised_angle(axial: float, lateral: float) -> float:
    """Return the friction angle that two principal stresses mobilise, degrees.

    Its sine is their difference over their sum, as of a Mohr-Coulomb material without cohesion.
    """
    return math.degrees(math.asin((axial - lateral) / (axial + lateral)))


def _at(time: float, times: Array, values: Array) -> float:
    """Return a value on the line through the nearest two records."""
    first = 0 if time <= times[0] else len(times) - 2
    slope = (values[first + 1] - values[first]) / (times[first + 1] - times[first])
    return float(values[first] + slope * (time - times[first]))
