"""Insertion seeds of the runs of a calibration."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from grainfit.evaluation import Stage

#: Some generators, such as that of LAMMPS, take no larger one.
LARGEST_SEED = 900_000_000
_STAGE_CODES: Mapping[Stage, int] = {"design": 0, "optimisation": 1, "verification": 2}
#: Beside those of the stages.
_REPEAT_CODE, _HOLDOUT_CODE = 3, 4


def insertion_seed(seed: int, stage: Stage, number: int) -> int:
    """Return the insertion seed of the numbered run of a stage.

    The same calibration seed gives the same insertion seeds.
    """
    return _seed_from(seed, _STAGE_CODES[stage], number)


def repeat_seed(seed: int, number: int) -> int:
    """Return the insertion seed of the numbered run of an evaluation: its own for the first.

    Parameters
    ----------
    seed : int
        Seed of the proposal.
    number : int
        Number of the run, from 1 on.
    """
    return seed if number == 1 else _seed_from(seed, _REPEAT_CODE, number)


def holdout_seed(seed: int, number: int) -> int:
    """Return the insertion seed of the numbered run of a hold-out of a calibration."""
    return _seed_from(seed, _HOLDOUT_CODE, number)


def _seed_from(*numbers: int) -> int:
    state = np.random.SeedSequence(numbers).generate_state(1)
    return 1 + int(state[0]) % (LARGEST_SEED - 1)
