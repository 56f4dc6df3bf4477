"""Options and constants of the sequential strategy"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Preference = Literal["time_step", "accuracy"]
#: Runs of the design per coefficient of a linear trend: half as many again as it takes to see one.
DESIGN_RUNS = 1.5
#: Demanded probability that all expected responses are within their tolerances.
CONFIDENCE = 0.95
#: The same without any single run: what hangs on one run is not decided.
CONFIDENCE_WITHOUT_ANY_RUN = 0.9
#: With fewer degrees of freedom to estimate the noise from, standard errors count double: a noise
#: that looks small by chance would end many calibrations too early.
DEGREES_OF_FREEDOM = 10
CAUTION = 2.0
#: Most runs behind the design per free parameter, where the user gives no budget.
RUNS_PER_PARAMETER = 20
#: A target must be missed by this many standard errors: it is looked at after every run.
STANDARD_ERRORS = 3.0


@dataclass(frozen=True)
class SequentialOptions:
    """Options of the sequential strategy.

    Parameters
    ----------
    design_runs : int, optional
        Size of the Latin hypercube; 1.5 (d + 1) by default.
    prefer : {"time_step", "accuracy"}
        Of all parameter sets that agree with the measurements, take the one with the largest
        Rayleigh time step, or the closest one.
    extend_intervals : bool
        Move a bound that keeps a target out of reach, within physical limits, and go on.
    confidence : float
        Demanded probability that all expected responses are within their tolerances.
    """

    design_runs: int | None = None
    prefer: Preference = "time_step"
    extend_intervals: bool = False
    confidence: float = CONFIDENCE
