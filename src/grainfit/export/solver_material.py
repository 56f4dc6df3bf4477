"""What of a card a solver needs, and whether it is all there."""

from __future__ import annotations

from collections.abc import Sequence

from grainfit.errors import Fault, InputError
from grainfit.export.card import MaterialCard
from grainfit.material import MATERIAL_PARAMETERS, ParticleSizes

#: All that decides contacts of particles and walls.
CONTACT_PARAMETERS = tuple(name for name in MATERIAL_PARAMETERS if name != "wall.density")


def require_material(
    card: MaterialCard, solver: str, needed: Sequence[str] = CONTACT_PARAMETERS
) -> dict[str, float]:
    """Return the values of all parameters of a card, having seen that a solver can use them.

    Raises
    ------
    InputError
        A parameter that the solver needs is missing, or has a value that no material has.
    """
    values = card.values
    _require_nothing_missing([name for name in needed if name not in values], solver)
    faults = [
        Fault(name, f"is {values[name]:g}, which no card for {solver} can hold.", _limits(name))
        for name in needed
        if not MATERIAL_PARAMETERS[name].lowest <= values[name] <= MATERIAL_PARAMETERS[name].highest
    ]
    if faults:
        raise InputError(faults)
    return values


def require_sizes(card: MaterialCard, solver: str) -> ParticleSizes:
    """Return the particle sizes of a card.

    Raises
    ------
    InputError
        They are not known.
    """
    if card.sizes is None:
        _require_nothing_missing(["particle.diameter"], solver)
    assert card.sizes is not None
    return card.sizes


def _require_nothing_missing(missing: Sequence[str], solver: str) -> None:
    if missing:
        raise InputError(
            Fault(
                "",
                f"a card for {solver} needs {', '.join(missing)}, which this calibration does not "
                "have.",
                "Give them in the calibration file and run it again, or take --to json or --to "
                "csv and put the values where your model takes them.",
            )
        )


def _limits(name: str) -> str:
    known = MATERIAL_PARAMETERS[name]
    return f"It must be from {known.lowest:g} to {known.highest:g} {known.unit}".rstrip() + "."
