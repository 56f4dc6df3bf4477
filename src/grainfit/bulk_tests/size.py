"""The same test in a larger or smaller apparatus, with the same particles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Protocol, TypeVar, runtime_checkable

from grainfit.bulk_tests import messages
from grainfit.bulk_tests.base import BulkTest
from grainfit.errors import InputError
from grainfit.options.fields import Amount

_Test = TypeVar("_Test", bound=BulkTest)
#: Particles of a twin of a large apparatus: its run takes a minute.
TWIN = 3000


@runtime_checkable
class CanBeResized(Protocol):
    """A test whose apparatus can be made larger or smaller in all directions."""

    @property
    def size_powers(self) -> Mapping[str, float | None]:
        """Power of the size that a response follows by itself, as the width of a heap does.

        None where sizes cannot be compared; of responses that it does not name it is 0.
        """

    def at_size(self, scale: float) -> dict[str, Amount]:
        """Return the options of an apparatus that is so many times as large.

        Speeds follow by Froude's law. Outlets stay in a larger one, because flow follows them and
        not the vessel; in a smaller one they become narrower as long as nothing arches.
        """


@runtime_checkable
class HasOutlet(Protocol):
    """A test whose outlet becomes narrower with its apparatus, as far as it may."""

    #: Power of the flow of the outlet that a response follows besides the size.
    flow_powers: ClassVar[Mapping[str, float]]

    @property
    def outlet_flow(self) -> float:
        """Flow of the outlet by Beverloo's law, in natural units."""


def scaled(test: BulkTest, scale: float, **powers: float) -> dict[str, Amount]:
    """Return options of a test times a power of a scale; those that it does not have stay away.

    Parameters
    ----------
    test : BulkTest
        The test.
    scale : float
        Size of the apparatus, over the present one.
    **powers : float
        By option: 1 for a length.

    Examples
    --------
    >>> from grainfit.bulk_tests.packing import Packing
    >>> scaled(Packing(diameter="10 mm"), 2.0, fill_height=1)
    {'fill_height': 0.24}
    """
    values = test.resolved_options()
    return {
        name: float(values[name]) * scale**power
        for name, power in powers.items()
        if values[name] is not None
    }


def resized(test: _Test, times: float) -> _Test:
    """Return a test in an apparatus that holds so many times the particles.

    Parameters
    ----------
    test : BulkTest
        Stays as it is.
    times : float
        Number of particles over the present one.

    Raises
    ------
    InputError
        The test has no size of its own, or is impossible at this one.
    """
    if not isinstance(test, CanBeResized):
        raise InputError(messages.NO_SIZE_OF_ITS_OWN.fault("", type=test.type))
    if times == 1:
        return test
    changes: dict[str, Any] = test.at_size(math.cbrt(times))
    if getattr(test, "particle_count", None) is not None:
        changes["particle_count"] = max(1, round(times * test.number_of_particles))
    return replace(test, **changes)


def twin_of(test: _Test) -> _Test | None:
    """Return a test in an apparatus that holds `TWIN` particles; None where that is no help.

    Parameters
    ----------
    test : BulkTest
        Stays as it is.
    """
    if test.number_of_particles <= TWIN:
        return None
    try:
        return resized(test, TWIN / test.number_of_particles)
    except InputError:
        return None


def size_power(test: object, response: str) -> float | None:
    """Return the power of the size of an apparatus that a response follows; None if unknown."""
    powers = test.size_powers if isinstance(test, CanBeResized) else {}
    return powers.get(response, 0.0)


def growth(test: BulkTest, response: str, times: float) -> float:
    """Return how a response grows by itself in an apparatus of so many times the particles.

    Parameters
    ----------
    test : BulkTest
        The test, with a known `size_power`.
    response : str
        Name of the response.
    times : float
        Number of particles over that of the test.

    Raises
    ------
    InputError
        The test is impossible at this size.
    """
    grown = float(math.cbrt(times) ** (size_power(test, response) or 0.0))
    if isinstance(test, HasOutlet) and (power := test.flow_powers.get(response)):
        larger: HasOutlet = resized(test, times)
        grown *= (larger.outlet_flow / test.outlet_flow) ** power
    return grown
