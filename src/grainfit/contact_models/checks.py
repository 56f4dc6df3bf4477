"""A check of the contact law of a calibration: solvers that differ."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

from grainfit.checks import Found, check
from grainfit.contact_models import messages
from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.registry import COHESION, contact_law
from grainfit.errors import InputError
from grainfit.formatting import in_a_row
from grainfit.materials.walls import plain_name


class UsedContactLaw(Protocol):
    """A calibration as checks of its contact law see it."""

    @property
    def fixed(self) -> Mapping[str, float]:
        """Parameters that are not free."""

    @property
    def intervals(self) -> Mapping[str, tuple[float, float]]:
        """Ends of the interval of every parameter; twice the value of a fixed one."""

    @property
    def contact_models(self) -> tuple[str, ...]:
        """Contact models that replace the usual ones of their kind."""

    @property
    def dem_solvers(self) -> Mapping[str, str]:
        """Name of the solver of each bulk test."""


@check("solvers-differ", "warning")
def solvers_differ(used: UsedContactLaw) -> Iterator[Found]:
    """Contact laws that are not the same in all solvers of the file."""
    law, material = _law(used), _cohesive(used)
    solvers = sorted(set(used.dem_solvers.values()))
    if law is None or len(solvers) < 2:
        return
    if difference := law.solver_difference(material, solvers):
        yield "", messages.SOLVERS_DIFFER(solvers=in_a_row(solvers), difference=difference)


def _cohesive(used: UsedContactLaw) -> dict[str, float]:
    """Return the fixed parameters, and the free ones of cohesion where it is largest."""
    largest = {name: e[1] for name, e in used.intervals.items() if plain_name(name) in COHESION}
    return {**used.fixed, **largest}


def _law(used: UsedContactLaw) -> ContactLaw | None:
    """Return the contact law; None where there is none, as another message says."""
    try:
        return contact_law(_cohesive(used), used.contact_models)
    except InputError:
        return None
