"""Sensitivities of responses to material parameters, measured once for each bulk test.

They tell which parameters a response depends on, so that it is known before any run what a set of
tests determines. Trials on LAMMPS (291 runs, 10 mm spheres, 2^(6-2) factorial designs about two
materials) gave the numbers of the built-in tests, see docs/choosing_tests.md. They are slopes at
two points: precise enough to warn, too coarse to fit parameters with.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

DENSITY = "particle.density"
MODULUS = "particle.youngs_modulus"
SLIDING = "particle_particle.sliding_friction"
ROLLING = "particle_particle.rolling_friction"
WALL_SLIDING = "particle_wall.sliding_friction"
RESTITUTION = "particle_particle.restitution"
WALL_RESTITUTION = "particle_wall.restitution"
#: Parameters varied in the trials. A response has no measurable dependence on those of them that it
#: does not name; how it depends on parameters that were not varied is unknown.
VARIED = (DENSITY, MODULUS, SLIDING, ROLLING, WALL_SLIDING, RESTITUTION, WALL_RESTITUTION)
#: Rolling over sliding friction of the two materials of the trials: 0.2 / 0.5 and 0.5 / 0.2.
_LOW, _HIGH = math.log(0.4), math.log(2.5)
#: Beyond the two materials, slopes are extrapolated by at most half of their distance.
_BEYOND = 0.5


#: Times the particles of the default apparatus, of the trials of larger ones.
LARGER = (4, 10)


@dataclass(frozen=True)
class Sensitivities:
    """Relative change of a response per relative change of a parameter: d ln y / d ln p.

    Parameters
    ----------
    slopes : mapping of str to float
        By dotted name, at a sliding friction of 0.5 and a rolling friction of 0.2. Parameters of
        `VARIED` that are not named have no effect beyond three standard errors.
    slopes_at_high_rolling : mapping of str to float
        Those that are others at a sliding friction of 0.2 and a rolling friction of 0.5.
    scatter : float
        Relative standard deviation of the response from run to run.
    larger : tuple of float
        Relative change in an apparatus that holds `LARGER` times the particles, 0 within two
        standard errors (`benchmarks/size_series.py`).

    Examples
    --------
    >>> angle = Sensitivities({ROLLING: 0.6}, {ROLLING: 0.2})
    >>> round(angle.at({SLIDING: 0.3, ROLLING: 0.3})[ROLLING], 2)
    0.4
    """

    slopes: Mapping[str, float]
    slopes_at_high_rolling: Mapping[str, float] = field(default_factory=dict)
    scatter: float = 0.0
    larger: tuple[float, float] = (0.0, 0.0)

    def at(self, material: Mapping[str, float]) -> dict[str, float]:
        """Return the slopes of a material, interpolated in ln(rolling / sliding friction).

        Parameters
        ----------
        material : mapping of str to float
            Material parameters by dotted name, with both frictions.
        """
        share = _share(material.get(SLIDING), material.get(ROLLING))
        return {
            name: _between(low, self.slopes_at_high_rolling.get(name, low), share)
            for name, low in self.slopes.items()
        }


def _share(sliding: float | None, rolling: float | None) -> float:
    """Position between the two materials: 0 at low rolling friction, 1 at high."""
    if not sliding or not rolling:
        return 0.0
    position = (math.log(rolling / sliding) - _LOW) / (_HIGH - _LOW)
    return min(max(position, -_BEYOND), 1 + _BEYOND)


def _between(low: float, high: float, share: float) -> float:
    value = low + share * (high - low)
    # No trial showed a slope that changes its sign.
    return value if value * low > 0 else 0.0
