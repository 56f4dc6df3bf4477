"""Shear to failure: the peak of the shear stress, from repeated shear at one normal stress."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grainfit.arrays import Array
from grainfit.bulk_tests.shear.flow import Record
from grainfit.bulk_tests.shear_cell import messages
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response

#: Shear strain over which stresses are averaged: fluctuations of a small bed are no peak.
WINDOW = 0.1


@dataclass(frozen=True)
class Failure:
    """Mean course of shear to failure at one normal stress.

    Parameters
    ----------
    strains : ndarray of shape (n,)
        Shear strains from the beginning of shear.
    shear_stresses, normal_stresses : ndarray of shape (cycles, n)
        Pa.
    """

    strains: Array
    shear_stresses: Array
    normal_stresses: Array

    @classmethod
    def of(cls, records: Sequence[Record], gap: float) -> Failure:
        """Return the courses of repeated shear, as far as all of them go.

        Parameters
        ----------
        records : sequence of Record
            One for each time.
        gap : float
            Distance between the plates, m.

        Raises
        ------
        NotMeasurableError
            There are too few records.
        """
        count = min(len(record.times) for record in records)
        strains = (records[0].travels[:count] - records[0].travels[0]) / gap
        if count < 2 or strains[-1] < WINDOW:
            raise NotMeasurableError(messages.FEW_RECORDS())
        return cls(
            strains,
            np.array([record.shear_stresses[:count] for record in records]),
            np.array([record.normal_stresses[:count] for record in records]),
        )

    @property
    def _window(self) -> int:
        """Number of records that are averaged."""
        step = self.strains[-1] / (len(self.strains) - 1)
        return min(max(1, round(WINDOW / step)), len(self.strains))

    def _means(self, stresses: Array) -> Array:
        """Return running means along the strain."""
        sums = np.cumsum(np.insert(stresses, 0, 0.0, axis=-1), axis=-1)
        return (sums[..., self._window :] - sums[..., : -self._window]) / self._window

    @property
    def frictions(self) -> Array:
        """Running means of shear stress over normal stress in the mean of all cycles."""
        shear, normal = (self._means(s).mean(axis=0) for s in self._stresses)
        return np.asarray(shear / normal)

    @property
    def _stresses(self) -> tuple[Array, Array]:
        return self.shear_stresses, self.normal_stresses

    @property
    def middles(self) -> Array:
        """Strains in the middle of the running means."""
        return self._means(self.strains)

    @property
    def peak(self) -> int:
        """Index of the largest running mean."""
        return int(self.frictions.argmax())

    @property
    def friction(self) -> float:
        """Shear stress over normal stress at the peak."""
        return float(self.frictions[self.peak])

    @property
    def normal_stress(self) -> float:
        """Normal stress at the peak, Pa."""
        return float(self._means(self.normal_stresses).mean(axis=0)[self.peak])

    @property
    def deviations(self) -> Array:
        """Deviations of the cycles at the peak, over the friction there."""
        shear, normal = (self._means(stresses)[:, self.peak] for stresses in self._stresses)
        return np.asarray(shear / normal / self.friction - 1)


def frictions_with_errors(failures: Sequence[Failure]) -> list[Response]:
    """Return the frictions at the peaks.

    Cycles scatter alike at all normal stresses: their relative scatter is that of all together.
    """
    every = [failure.deviations - failure.deviations.mean() for failure in failures]
    freedom = sum(len(deviations) - 1 for deviations in every)
    scatter = math.sqrt(sum(float(one @ one) for one in every) / freedom)
    return [
        Response(f.friction, f.friction * scatter / math.sqrt(len(f.deviations))) for f in failures
    ]
