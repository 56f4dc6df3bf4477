"""What the atlas varies of a test's apparatus: ranges of its options in natural units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np

from grainfit.one_line import OneLine

#: Options of any test on which responses hardly depend.
NUMERICAL = ("settling_time_limit", "time_step_fraction")


@dataclass(frozen=True)
class Range:
    """Values that an input of the atlas takes, and the scale on which responses follow it.

    Parameters
    ----------
    low, high : float
        Ends.
    power : float
        Responses follow this power of the input; 0 is its logarithm.
    reach : float
        Share up to which they follow the trend of a logarithm, 1 at the upper end.
    is_whole : bool
        Whether the input is a whole number, as of taps.

    Examples
    --------
    >>> round(float(Range(0.1, 10.0, power=0).share(1.0)), 9)
    0.5
    >>> Range(1.0, 3.0).at(0.5)
    2.0
    """

    low: float
    high: float
    power: float = 1.0
    reach: float = 1.0
    is_whole: bool = False

    def share(self, value: Any) -> Any:
        """Return where a value, or each of an array, lies: 0 at the lower end, 1 at the upper."""
        low, high = self._of(self.low), self._of(self.high)
        return (self._of(value) - low) / (high - low)

    def at(self, share: float) -> float:
        """Return the value at a share of the range."""
        low, high = self._of(self.low), self._of(self.high)
        position = low + share * (high - low)
        value = float(math.exp(position) if self.power == 0 else position ** (1 / self.power))
        return float(round(value)) if self.is_whole else value

    @property
    def limit(self) -> float:
        """Share up to which responses follow a trend: of a negative power, where the input is 0."""
        if self.power >= 0:
            return self.reach
        return float(self._of(self.low) / (self._of(self.low) - self._of(self.high)))

    def _of(self, value: Any) -> Any:
        if self.power != 0:
            return value**self.power
        # A wall may have no friction, which is as far below the range as there is.
        with np.errstate(divide="ignore"):
            return np.log(value)


#: Surface energies over rho g d^2, Bond numbers up to 2.25, beyond which no flank is one.
OF_FLANKS = Range(0.0, 0.5, power=1 / 3)


@dataclass(frozen=True)
class VariedOptions(OneLine):
    """Options of one apparatus of a test that the rows of the atlas vary.

    Parameters
    ----------
    size_option : str
        The option that tells how large an apparatus is.
    size : Range
        Its size over the usual one; responses follow the reciprocal, with 0 of a large apparatus.
    name : str
        Name of the apparatus, part of that of its rows; that of the usual one is empty.
    title : str
        It in words.
    size_power : float
        Power of the size that the option follows: 3 of a volume.
    factors : mapping of str to Range
        Options over their usual value at this size.
    factor_powers : mapping of str to float
        Powers of the size that their usual values follow, where `at_size` leaves them out.
    bounded : tuple of str
        Those of them that bend responses so much that nothing is told beyond their range.
    values : mapping of str to Range
        Options without a unit, as they are.
    loads : mapping of str to Range
        Stresses over the weight of a particle on its cross-section, rho g d.
    per_load : tuple of str
        Responses that are told over the load, which they follow by itself.
    stiffness : Range, optional
        Young's modulus over the stress that presses particles together, where that of other tests
        does not suit.
    wider : mapping of str to float
        Options over their usual value that are the same in every row: a plate without an edge.
    same : mapping of str to object
        Options that are the same in every row, and not the usual ones.
    indifferent : tuple of str
        Options on which responses hardly depend, besides `NUMERICAL`: every value is admitted.
    left : tuple of str
        Those of them that keep their own default at every size.
    limit : mapping of str to float
        Inputs at which the usual apparatus is this one, too: its rows are known as well.
    particles : tuple of str
        Particles besides dry spheres of which there are rows, see `grainfit.atlas.strata`.
    surface_energy : Range, optional
        Surface energies over rho g d^2 of cohesive particles, where those of other tests do not
        suit.
    """

    size_option: str
    size: Range
    name: str = ""
    title: str = ""
    size_power: float = 1.0
    factors: Mapping[str, Range] = field(default_factory=dict)
    factor_powers: Mapping[str, float] = field(default_factory=dict)
    bounded: tuple[str, ...] = ()
    values: Mapping[str, Range] = field(default_factory=dict)
    loads: Mapping[str, Range] = field(default_factory=dict)
    per_load: tuple[str, ...] = ()
    stiffness: Range | None = None
    wider: Mapping[str, float] = field(default_factory=dict)
    same: Mapping[str, Any] = field(default_factory=dict)
    indifferent: tuple[str, ...] = ()
    left: tuple[str, ...] = ()
    limit: Mapping[str, float] = field(default_factory=dict)
    particles: tuple[str, ...] = ()
    surface_energy: Range | None = None

    @property
    def ranges(self) -> dict[str, Range]:
        """Ranges of all inputs of the apparatus, by the name of the input."""
        return {"size": self.size, **self.factors, **self.values, **self.loads}


@runtime_checkable
class InAtlas(Protocol):
    """A test of which the atlas has rows."""

    #: What its rows vary, of the usual apparatus first.
    varied: ClassVar[tuple[VariedOptions, ...]]
