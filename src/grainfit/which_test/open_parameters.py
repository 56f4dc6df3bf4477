"""Free parameters that the tests of a calibration will leave open."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.checks import Found, check
from grainfit.solvers.check_context import CheckContext


@check("open-parameters")
def open_parameters(context: CheckContext) -> Iterator[Found]:
    """Free parameters that the tests will leave open, and what would determine them."""
    # Loaded late, for it takes SciPy.
    from grainfit.which_test.narrowing import expected_narrowing

    for note in context.once(expected_narrowing).notes:
        yield "", note


@check("further-response")
def further_response(context: CheckContext) -> Iterator[Found]:
    """Response of the same runs that would narrow a parameter, such as the radius of a heap."""
    from grainfit.which_test.narrowing import expected_narrowing

    if further := context.once(expected_narrowing).further:
        yield "", further
