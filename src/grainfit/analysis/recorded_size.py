"""What another size of an apparatus changes, by the trials that are recorded with each test."""

from __future__ import annotations

import math
from collections.abc import Iterable

from grainfit.analysis.size_trend import predict
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import sized_for
from grainfit.bulk_tests.recorded_trials import LARGER
from grainfit.bulk_tests.size import size_power
from grainfit.errors import InputError
from grainfit.formatting import in_a_row

#: Relative error of the recorded means.
_ERROR = 0.01
#: Change of a response that is worth words.
_WORTH_TELLING = 0.005


def change_of_size(test: BulkTest, response: str, particles: float) -> float | None:
    """Return the expected relative change of a response with another number of particles.

    The trials held 1, 4 and 10 times the particles of the usual apparatus, of rough soft spheres;
    other sizes follow the trend of `predict`.

    Parameters
    ----------
    test : BulkTest
        The test in its own apparatus.
    response : str
        Name of the response.
    particles : float
        Their number in the other apparatus: smaller, or as large for larger particles.

    Returns
    -------
    float or None
        None where no trial is recorded, or sizes cannot be compared.
    """
    info, power = test.responses.get(response), size_power(test, response)
    known = None if info is None else info.trials
    if known is None or power is None or not any(known.larger):
        return None
    try:
        usual = sized_for(type(test), test.sizes.real).number_of_particles
    except (InputError, TypeError):
        return None
    scales = [1.0, *map(math.cbrt, LARGER)]
    means = [(1 + c) / s**power for c, s in zip((0.0, *known.larger), scales, strict=True)]

    def at(count: float) -> float:
        return predict(scales, means, [_ERROR] * len(scales), math.cbrt(count / usual)).value

    return at(particles) / at(test.number_of_particles) - 1


def changes_in_words(test: BulkTest, responses: Iterable[str], particles: float) -> str:
    """Return by how much responses move with another number of particles, as far as it is known.

    Parameters
    ----------
    test : BulkTest
        The test in its own apparatus.
    responses : iterable of str
        Names of responses.
    particles : float
        As of `change_of_size`.

    Returns
    -------
    str
        An addition in brackets; empty where nothing is known.
    """
    found = {name: change_of_size(test, name, particles) for name in responses}
    moved = [
        f"{name} by {100 * change:+.2g} %"
        for name, change in found.items()
        if change is not None and abs(change) >= _WORTH_TELLING
    ]
    return f" (expected to move {in_a_row(moved)})" if moved else ""
