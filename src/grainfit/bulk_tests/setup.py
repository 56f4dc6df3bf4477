"""Geometry and procedure of a bulk test: its options, with every default resolved."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Protocol

from grainfit.bulk_tests import messages
from grainfit.errors import Fault
from grainfit.materials.sizes import ParticleSizes
from grainfit.one_line import OneLine
from grainfit.options.fields import derived_defaults


class HasOptions(Protocol):
    """A test before its defaults are resolved."""

    @property
    def sizes(self) -> ParticleSizes:
        """The simulated particles."""

    def given_options(self) -> Mapping[str, Any]:
        """Return the value of every option as it was given, None for many of the defaults."""


class Setup(OneLine):
    """Geometry and procedure of a bulk test: an attribute for every option, in SI units.

    A default that follows from the particles and from other options is resolved once, when it is
    first read. So a default is a function of this object, faults of the geometry are found before
    what would follow from it, and a subclass adds what follows from the options as properties.

    Parameters
    ----------
    test : BulkTest
        The test.
    """

    def __init__(self, test: HasOptions) -> None:
        self.sizes = test.sizes
        self._given = dict(test.given_options())
        self._derived = derived_defaults(type(test))
        self._resolved: dict[str, Any] = {}

    @property
    def real(self) -> ParticleSizes:
        """The real particles, which defaults of an apparatus follow."""
        return self.sizes.real

    @property
    def d(self) -> float:
        """Sauter diameter of the real particles, m."""
        return self.real.sauter_diameter

    @property
    def largest(self) -> float:
        """Diameter of the largest simulated particles, m."""
        return max(self.sizes.diameters)

    def is_given(self, name: str) -> bool:
        """Return whether an option was given, and is not its derived default."""
        return self._given[name] is not None

    def option(self, name: str) -> Any:
        """Return the value of an option, as it was given or its default."""
        if name not in self._resolved:
            value, default = self._given[name], self._derived.get(name)
            self._resolved[name] = default.of(self) if value is None and default else value
        return self._resolved[name]

    def __getattr__(self, name: str) -> Any:
        # Private names are looked for in a copy that has no attributes yet.
        if name.startswith("_") or name not in self._given:
            raise AttributeError(f"{type(self).__name__} has no {name!r}")
        return self.option(name)

    def fault_stages(self) -> Iterator[Iterable[Fault]]:
        """Iterate over the stages of what can be impossible; the first one with faults ends it."""
        yield ()

    def short_faults(self, fewest: Mapping[str, float]) -> Iterator[Fault]:
        """Iterate over options that are shorter than so many of the largest particles."""
        for name, count in fewest.items():
            value, least = self.option(name), count * self.largest
            if value < (1 - 1e-9) * least:
                yield messages.LENGTH_IS_SHORT.fault(
                    name, value=value, fewest=count, largest=self.largest, least=least
                )

    def resolve(self) -> None:
        """Resolve every option; functions of defaults are not needed any more."""
        for name in self._given:
            self.option(name)
        self._derived = {}
