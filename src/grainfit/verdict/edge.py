"""Answers on the edge of a tolerance."""

from __future__ import annotations

from grainfit.verdict.options import VERDICT


def is_at_edge(off: float, error: float) -> bool:
    """Return whether an answer is known to lie on the edge of a tolerance, or beyond it.

    Parameters
    ----------
    off, error : float
        Expected deviation from the target and its standard error, in tolerances.

    Examples
    --------
    >>> is_at_edge(1.0, 0.2), is_at_edge(1.1, 1.0), is_at_edge(2.0, 1.0)
    (True, False, True)
    """
    return off >= VERDICT.edge and (error <= VERDICT.known_edge or off - error >= VERDICT.edge)
