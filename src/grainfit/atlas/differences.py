"""How far another solver is from LAMMPS, of which the rows of the atlas are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from grainfit.arrays import Array

#: Solver of the rows.
REFERENCE = "lammps"
#: Fewest rows that both solvers made from which a difference is told.
FEWEST_PAIRS = 8
#: Relative spread of densities and of other responses without such rows: root mean square over the
#: tests of `benchmarks/solver_agreement.py`.
_USUAL_DENSITY, _USUAL = 0.006, 0.02


class Difference(NamedTuple):
    """Difference of a solver from LAMMPS in one response, over that of LAMMPS.

    Parameters
    ----------
    mean : float
        Over materials and apparatus.
    spread : float
        Standard deviation at another material, with that of the mean.
    """

    mean: float
    spread: float


def usual_difference(unit: str) -> Difference:
    """Return what is assumed of a response, by its unit, of which no rows tell."""
    return Difference(0.0, _USUAL_DENSITY if unit == "kg/m^3" else _USUAL)


def difference(own: Array, reference: Array, scatter: Array) -> Difference:
    """Return the difference that runs of two solvers tell, each at the same materials.

    What the scatter of the runs does not explain is the spread from material to material, by the
    method of moments.

    Parameters
    ----------
    own, reference : ndarray, shape (n,)
        Responses on the solver and on LAMMPS.
    scatter : ndarray, shape (n,)
        Standard deviation of a run over its response.

    Examples
    --------
    >>> import numpy as np
    >>> reference = np.linspace(20.0, 40.0, 20)
    >>> round(difference(1.02 * reference, reference, np.zeros(20)).mean, 4)
    0.02
    """
    shares = relative_differences(own, reference)
    variance = float(shares.var(ddof=1))
    between = max(0.0, variance - 2 * float((scatter**2).mean()))
    return Difference(float(shares.mean()), float(np.sqrt(between + variance / len(shares))))


def relative_differences(own: Array, reference: Array) -> Array:
    """Return differences over the middle of both values, shape (n,).

    To first order that is the difference over the second.
    """
    return np.asarray(2 * (own - reference) / (np.abs(own) + np.abs(reference)))
