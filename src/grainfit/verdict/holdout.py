"""Rule of the verdict on a prediction of a test that took no part in the calibration."""

from __future__ import annotations

from typing import Literal

from grainfit.verdict.options import HOLDOUT

HoldoutVerdict = Literal["predicts", "does not predict", "does not tell"]


def judge_prediction(probability: float, width: float, prior_width: float) -> HoldoutVerdict:
    """Return the verdict on a prediction.

    A measured value outside of its interval refutes the prediction, however wide the interval is.

    Parameters
    ----------
    probability : float
        Probability of a measured value as far from the prediction, if this is right.
    width, prior_width : float
        Widths of the intervals of a measurement, after the calibration and before it.
    """
    if probability < 1 - HOLDOUT.confidence:
        return "does not predict"
    return "predicts" if width < HOLDOUT.narrow * prior_width else "does not tell"
