"""How many runs a design needs, wants and may have."""

from __future__ import annotations

from grainfit.errors import Fault, InputError


def smallest_design(dimension: int, wanted: int | None = None) -> int:
    """Return the size of the design that is wanted, or else the smallest that is possible.

    Raises
    ------
    InputError
        What is wanted is too small to fit metamodels.
    """
    smallest = dimension + 3
    if wanted is not None and wanted < smallest:
        raise InputError(
            Fault(
                "design_runs",
                f"{wanted} runs are too few for metamodels of {dimension} parameters.",
                f"Give at least {smallest}.",
            )
        )
    return wanted or smallest


def design_size(dimension: int, wanted: int | None, usual: int, max_evaluations: int | None) -> int:
    """Return the size of a design within a budget.

    Parameters
    ----------
    dimension : int
        Number of free parameters.
    wanted : int, optional
        What the user wants.
    usual : int
        What the strategy would take.
    max_evaluations : int, optional
        The budget. A tight one keeps a third for the runs behind the design.

    Raises
    ------
    InputError
        What is wanted is too small for metamodels or too large for the budget.
    """
    smallest = smallest_design(dimension, wanted)
    if max_evaluations is None:
        return wanted or usual
    if max_evaluations < smallest:
        raise InputError(
            Fault(
                "max_evaluations",
                f"{max_evaluations} are too few for the design.",
                f"Allow at least {smallest}.",
            )
        )
    return wanted or min(usual, max(smallest, (2 * max_evaluations) // 3))
