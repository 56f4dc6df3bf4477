"""Lengths as small whole numbers, for drawings in three dimensions."""

from __future__ import annotations

import base64

import numpy as np
from numpy.typing import NDArray

#: The largest number that a length becomes.
LARGEST = 32_000


def packed(values: NDArray[np.floating]) -> str:
    """Return values that are not above `LARGEST` as text, two bytes for each."""
    return base64.b64encode(np.round(values).astype("<i2").tobytes()).decode("ascii")
