"""Shear flow between two plates: recorded stresses, velocity profile, standard errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Self

import numpy as np

from grainfit.arrays import Array
from grainfit.bulk_tests.shear import messages
from grainfit.bulk_tests.shear.setup import ShearSetup
from grainfit.errors import NotMeasurableError, RunFailedError
from grainfit.evaluation import Response
from grainfit.measurement.bulk_density import masses_between
from grainfit.measurement.grid import require_grid
from grainfit.measurement.particles import Particles
from grainfit.scenes.records import Force, Recorded, Travel
from grainfit.scenes.run_output import RunOutput

#: Numbers of the glued sets.
LOWER, UPPER = 1, 2
#: A window of so many diameters must not take up much more than its share of the shear.
_WINDOW = 2
#: The density is measured from so many of the largest diameters above the middle of the lower plate
#: to as many below that of the upper one: nearer to them is a layer that is less dense.
_MARGIN = 1.5


#: Columns of the series of every stage in which the bed is sheared.
COLUMNS: dict[str, Recorded] = {
    "shear_lower": Force("lower", "x"),
    "shear_upper": Force("upper", "x"),
    "normal_lower": Force("lower", "z"),
    "normal_upper": Force("upper", "z"),
    "travel": Travel("upper", "x"),
}


@dataclass(frozen=True)
class Record:
    """Recorded stresses of one stage.

    Parameters
    ----------
    times : ndarray of shape (n,)
        s.
    travels : ndarray of shape (n,)
        Distance that the upper plate has moved along x, m.
    shear_stresses, normal_stresses : ndarray of shape (n,)
        Means of both plates, or those of the lower one, Pa.
    """

    times: Array
    travels: Array
    shear_stresses: Array
    normal_stresses: Array

    @classmethod
    def of_stage(
        cls, run: RunOutput, stage: str, setup: ShearSetup, *, lower_alone: bool = False
    ) -> Self:
        """Read the series of a stage.

        Parameters
        ----------
        run : RunOutput
            The run.
        stage : str
            Its name.
        setup : ShearSetup
            Geometry.
        lower_alone : bool
            Whether to read the forces on the lower plate alone, which stands still. Those on the
            upper one swing from step to step where particles are stiff (E over normal stress above
            10,000), and records at every so many steps meet them at one end of the swing.

        Raises
        ------
        NotMeasurableError
            The file is missing or damaged, or a column is missing.
        """
        series = run.series(stage, COLUMNS)
        shear, normal = series["shear_lower"], -series["normal_lower"]
        if not lower_alone:
            shear = (shear - series["shear_upper"]) / 2
            normal = (normal + series["normal_upper"]) / 2
        return cls(series["time"], series["travel"], shear / setup.area, normal / setup.area)

    def last(self, share: float) -> Self:
        """Return the last share of the record."""
        late = self.times >= self.times[-1] - share * (self.times[-1] - self.times[0])
        return replace(self, **{one.name: getattr(self, one.name)[late] for one in fields(self)})


def plate_speed(records: Sequence[Record]) -> float:
    """Return the velocity of the upper plate over all records, m/s."""
    first, last = records[0], records[-1]
    return float((last.travels[-1] - first.travels[0]) / (last.times[-1] - first.times[0]))


def block_mean(blocks: Sequence[float]) -> Response:
    """Return the mean of blocks and its standard error.

    Blocks are as long as the correlations of the series; neighbours that resemble each other count
    less. The error is that of independent blocks times sqrt((1 + r) / (1 - r)), where r is the
    correlation of neighbours, if that is positive (as of an autoregressive series of order 1).
    """
    values = np.array(blocks, dtype=float)
    rest = values - values.mean()
    variance = float(rest @ rest) / (len(values) - 1)
    r = 0.0
    if variance > 0:
        r = float(rest[:-1] @ rest[1:]) / float(rest @ rest)
    # A correlation beyond that cannot be told from a drift with so few blocks.
    r = min(max(r, 0.0), 0.8)
    error = math.sqrt(variance / len(values) * (1 + r) / (1 - r))
    return Response(float(values.mean()), error)


def friction_of(record: Record) -> float:
    """Return the mean shear stress over the mean normal stress of a record."""
    return float(record.shear_stresses.mean() / record.normal_stresses.mean())


def angle_of(friction: Response) -> Response:
    """Return the angle of a friction, degrees, with its standard error."""
    error = math.degrees(friction.standard_error / (1 + friction.value**2))
    return Response(math.degrees(math.atan(friction.value)), error)


@dataclass(frozen=True)
class Profile:
    """Mean velocity along x over the height above the lower plate.

    Parameters
    ----------
    heights : ndarray of shape (n,)
        Middles of layers about one diameter thick, m.
    velocities : ndarray of shape (n,)
        Over the velocity of the upper plate.
    gap : float
        Distance between the middles of the plates, m.
    """

    heights: Array
    velocities: Array
    gap: float

    @property
    def middle_share(self) -> float:
        """Share of the plate's velocity that the middle half of the gap takes up; 0.5 if even."""
        low, high = np.interp(
            [0.25 * self.gap, 0.75 * self.gap],
            [0.0, *self.heights, self.gap],
            [0.0, *self.velocities, 1.0],
        )
        return float(high - low)

    @property
    def steepest(self) -> float:
        """Largest shear rate within two diameters, over the mean shear rate."""
        heights = np.array([0.0, *self.heights, self.gap])
        velocities = np.array([0.0, *self.velocities, 1.0])
        rise = velocities[_WINDOW:] - velocities[:-_WINDOW]
        return float((rise / (heights[_WINDOW:] - heights[:-_WINDOW])).max()) * self.gap


@dataclass(frozen=True)
class Frame:
    """Snapshot of the bed and its plates.

    Parameters
    ----------
    time : float
        s.
    bed, lower, upper : Particles
        Loose particles, and those of the plates.
    """

    time: float
    bed: Particles
    lower: Particles
    upper: Particles

    @property
    def plates(self) -> tuple[float, float]:
        """Heights of the middles of the plates, m."""
        low, high = (float(p.positions[:, 2].mean()) for p in (self.lower, self.upper))
        return low, high

    def density(self, setup: ShearSetup) -> float:
        """Return mass over volume of the bed without the layers at the plates, kg/m^3."""
        low, high = self.plates
        margin = _MARGIN * setup.largest
        planes = np.array([low + margin, high - margin])
        mass = float(masses_between(self.bed, planes)[0])
        return mass / (setup.area * float(planes[1] - planes[0]))


def read_frame(run: RunOutput, name: str, time: float) -> Frame:
    """Read a snapshot.

    Raises
    ------
    NotMeasurableError
        It is missing or damaged, or has no particles or no plates.
    """
    frame = Frame(time, *(run.snapshot(name, glued) for glued in (0, LOWER, UPPER)))
    if not min(len(frame.bed), len(frame.lower), len(frame.upper)):
        raise NotMeasurableError(messages.NO_BED(name=name))
    return frame


def velocity_profile(frames: Sequence[Frame], length: float, speed: float) -> Profile:
    """Return the mean velocities between snapshots.

    Parameters
    ----------
    frames : sequence of Frame
        So near to each other that the upper plate moves by less than half of the length.
    length : float
        Period along x, m.
    speed : float
        Velocity of the upper plate, m/s.

    Raises
    ------
    RunFailedError
        Particles are missing in a snapshot.
    """
    if len({len(frame.bed) for frame in frames}) > 1:
        raise RunFailedError(messages.PARTICLES_LOST())
    gap = float(np.mean([high - low for low, high in (frame.plates for frame in frames)]))
    require_grid("velocity profile", gap / frames[0].bed.diameter)
    layers = max(3, round(gap / frames[0].bed.diameter))
    sums, counts = np.zeros(layers), np.zeros(layers)
    for one, other in pairwise(frames):
        moved = other.bed.positions[:, 0] - one.bed.positions[:, 0]
        # From a quarter of the length backwards to three quarters forwards.
        moved = (moved + length / 4) % length - length / 4
        height = (one.bed.positions[:, 2] + other.bed.positions[:, 2]) / 2 - one.plates[0]
        layer = np.clip((height / gap * layers).astype(int), 0, layers - 1)
        sums += np.bincount(layer, moved / (other.time - one.time), layers)
        counts += np.bincount(layer, minlength=layers)
    filled = counts > 0
    heights = (np.arange(layers) + 0.5) * gap / layers
    return Profile(heights[filled], sums[filled] / counts[filled] / speed, gap)
