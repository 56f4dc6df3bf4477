"""Which contact model a material was calibrated with, and whether that is the one of the card."""

from __future__ import annotations

from grainfit.export.card import MaterialCard
from grainfit.export.comments import comment

_DECKS = {"lammps": "LAMMPS", "liggghts": "LIGGGHTS", "yade": "YADE"}


def origin(card: MaterialCard, solver: str) -> str:
    """Return comments that say how far the values hold in this solver."""
    return "\n".join(comment(line) for line in _lines(card, solver))


def _lines(card: MaterialCard, solver: str) -> list[str]:
    found = {program.name for program in card.programs}
    if found == {solver}:
        return [f"The values were calibrated with {_DECKS[solver]} and this contact model."]
    if found and found <= _DECKS.keys():
        others = " and ".join(_DECKS[name] for name in sorted(found))
        return [
            f"CHECK: the values were calibrated with {others}. Rolling friction is not quite the",
            f"same in {_DECKS[solver]}: repeat the bulk test before you rely on them.",
        ]
    return [
        "CHECK: the values were calibrated with a model of the user's own and hold for its contact",
        "model; that of this card is the one of grainfit's own tests. See that they are the same.",
    ]
