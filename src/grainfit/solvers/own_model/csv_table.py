"""Columns and lines of tables of runs: seeds, standard errors, repeated runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from grainfit.errors import Fault
from grainfit.evaluation import ERROR_SUFFIX
from grainfit.solvers.own_model import table_messages as messages

#: Column of the seed, if a table has one.
SEED_COLUMN = "seed"
#: Suffix that version 0.1.0 used instead of `ERROR_SUFFIX`.
OLD_ERROR_SUFFIX = "_std_error"


def note_old_error_column(name: str, responses: Iterable[str], where: str) -> Fault | None:
    """Return a fault if a column has the name that a standard error had in version 0.1.0."""
    response = name.removesuffix(OLD_ERROR_SUFFIX)
    if name == response or response not in responses:
        return None
    return messages.OLD_ERROR_NAME.fault(where, response=response, suffix=ERROR_SUFFIX)


def repeated_runs(runs: Iterable[tuple[str, tuple[float, ...]]]) -> Iterator[Fault]:
    """Yield a fault for each run that occurs twice with the same seed.

    Parameters
    ----------
    runs : iterable of (str, tuple of float)
        Place in the table; parameters and seed.
    """
    first: dict[tuple[float, ...], str] = {}
    for place, run in runs:
        if first.setdefault(run, place) != place:
            yield messages.REPEATED_RUN.fault(place, first=first[run])
