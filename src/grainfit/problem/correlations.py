"""Correlations of measured values: pairs with coefficients, checked, and their matrix."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from grainfit.arrays import Array
from grainfit.errors import Fault, InputError
from grainfit.problem import messages
from grainfit.problem.quantities import shown
from grainfit.validation import as_number

#: Two names and the coefficient between them.
Correlation: TypeAlias = tuple[str, str, float]

#: Smallest eigenvalue of a matrix that can be inverted without loss of all digits.
_SMALLEST_EIGENVALUE = 1e-9


def correlation_faults(
    names: Sequence[str], correlations: Sequence[Correlation], key: str = "correlations"
) -> list[Fault]:
    """Return why correlations are not those of some quantities; empty if they are.

    Parameters
    ----------
    names : sequence of str
        Names of all quantities.
    correlations : sequence of (str, str, float)
        Pairs with coefficients between -1 and 1, each pair once. Other pairs are not correlated.
    key : str
        Name of the argument, for the messages.
    """
    faults: list[Fault] = []
    seen: set[frozenset[str]] = set()
    for index, (first, second, coefficient) in enumerate(correlations):
        where, pair = f"{key}[{index}]", frozenset((first, second))
        faults += [
            messages.NO_TARGET_HERE.fault(where, name=name, known=", ".join(names))
            for name in (first, second)
            if name not in names
        ]
        if first == second:
            faults.append(messages.NAMED_TWICE.fault(where, name=first))
        elif pair in seen:
            faults.append(messages.SECOND_COEFFICIENT.fault(where, first=first, second=second))
        if not -1 < as_number(coefficient) < 1:
            given = {"given": shown(coefficient), "first": first, "second": second}
            faults.append(messages.BAD_COEFFICIENT.fault(where, **given))
        seen.add(pair)
    if faults or not correlations:
        return faults
    smallest = float(np.linalg.eigvalsh(correlation_matrix(names, correlations)).min())
    if smallest >= _SMALLEST_EIGENVALUE:
        return []
    return [messages.CONTRADICTION.fault(key, smallest=smallest)]


def correlation_matrix(names: Sequence[str], correlations: Sequence[Correlation]) -> Array:
    """Return the matrix of correlations, shape (n, n), in the order of the names."""
    matrix = np.eye(len(names))
    for first, second, coefficient in correlations:
        i, j = names.index(first), names.index(second)
        matrix[i, j] = matrix[j, i] = coefficient
    return matrix


def correlated_groups(matrix: Array) -> list[Array]:
    """Return the indices of quantities that are correlated, directly or through others.

    Quantities without correlations are in no group.
    """
    linked = matrix != 0
    for _ in range(len(matrix)):
        linked = linked @ linked
    groups = {tuple(np.flatnonzero(row).tolist()) for row in linked if row.sum() > 1}
    return [np.array(group) for group in sorted(groups)]


def symmetric_matrix(given: ArrayLike, names: Sequence[str], key: str, row: str) -> Array:
    """Return a matrix of numbers, shape (n, n).

    Parameters
    ----------
    given : array_like
        The matrix.
    names : sequence of str
        Of the n rows, for the messages.
    key : str
        Name of the argument, for the messages.
    row : str
        Meaning of a row, such as ``"target"``, for the messages.

    Raises
    ------
    InputError
        It has another shape, is not symmetric, or has a number that is not finite.
    """
    try:
        matrix = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        matrix = np.empty(0)
    wanted = (len(names), len(names))
    if matrix.shape != wanted:
        shape = matrix.shape
        raise InputError(messages.BAD_SHAPE.fault(key, shape=shape, wanted=wanted, row=row))
    if len(bad := np.argwhere(~np.isfinite(matrix))):
        i, j = bad[0]
        entry = {"given": shown(matrix[i, j]), "first": names[i], "second": names[j]}
        raise InputError(messages.NOT_FINITE_ENTRY.fault(key, **entry))
    if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
        raise InputError(messages.NOT_SYMMETRIC.fault(key))
    return matrix


def split_covariance(
    names: Sequence[str], covariance: ArrayLike
) -> tuple[Array, tuple[Correlation, ...]]:
    """Return the standard deviations and the correlations of a covariance matrix.

    Parameters
    ----------
    names : sequence of str
        Names of the quantities, in the order of the rows.
    covariance : array_like, shape (n, n)
        Symmetric and positive definite.

    Raises
    ------
    InputError
        The matrix has another shape, is not symmetric, or is not positive definite.
    """
    matrix = symmetric_matrix(covariance, names, "covariance", "target")
    deviations = np.sqrt(np.maximum(np.diagonal(matrix), 0.0))
    if not (deviations > 0).all():
        raise InputError(messages.BAD_VARIANCE.fault("covariance"))
    scaled = matrix / np.outer(deviations, deviations)
    found = tuple(
        (names[i], names[j], float(scaled[i, j]))
        for i in range(len(names))
        for j in range(i + 1, len(names))
        if scaled[i, j] != 0
    )
    InputError.raise_for(correlation_faults(names, found, "covariance"))
    return deviations, found
