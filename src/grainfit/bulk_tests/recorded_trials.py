"""What trials of a response have shown once: its scatter, and what a larger apparatus changes."""

from __future__ import annotations

from dataclasses import dataclass

#: Times the particles of the default apparatus, of the trials of larger ones.
LARGER = (4, 10)


@dataclass(frozen=True)
class RecordedTrials:
    """Scatter and size of a response in trials of rough spheres on LAMMPS.

    Parameters
    ----------
    scatter : float
        Relative standard deviation of the response from run to run.
    larger : tuple of float
        Relative change in an apparatus that holds `LARGER` times the particles, 0 within two
        standard errors (`benchmarks/size_series.py`).
    """

    scatter: float
    larger: tuple[float, float] = (0.0, 0.0)
