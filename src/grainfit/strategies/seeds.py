"""Insertion seeds of the runs of a calibration."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from grainfit.evaluation import Stage

_STAGE_CODES: Mapping[Stage, int] = {"design": 0, "optimisation": 1, "verification": 2}


def insertion_seed(seed: int, stage: Stage, number: int) -> int:
    """Return the insertion seed of the numbered run of a stage.

    The same calibration seed gives the same insertion seeds.
    """
    state = np.random.SeedSequence([seed, _STAGE_CODES[stage], number]).generate_state(1)
    # Some generators, such as that of LAMMPS, take no seed above 900,000,000.
    return 1 + int(state[0]) % 899_999_999
