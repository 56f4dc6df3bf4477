"""Correlations of measured values: pairs with coefficients, checked, and their matrix."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grainfit.checks import as_number
from grainfit.errors import Fault, InputError

#: Two names and the coefficient between them.
Correlation: TypeAlias = tuple[str, str, float]
Array = NDArray[np.float64]

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
            Fault(where, f"{name!r} has no target here.", f"Use two of {', '.join(names)}.")
            for name in (first, second)
            if name not in names
        ]
        if first == second:
            faults.append(Fault(where, f"names {first!r} twice.", "Name two responses."))
        elif pair in seen:
            words = f"is a second coefficient of {first!r} and {second!r}."
            faults.append(Fault(where, words, "Keep one of them."))
        if not -1 < as_number(coefficient) < 1:
            words = f"has the coefficient {coefficient!r}."
            faults.append(Fault(where, words, "It must be above -1 and below 1."))
        seen.add(pair)
    if faults or not correlations:
        return faults
    smallest = float(np.linalg.eigvalsh(correlation_matrix(names, correlations)).min())
    if smallest >= _SMALLEST_EIGENVALUE:
        return []
    return [
        Fault(
            key,
            f"contradict each other: their matrix has the eigenvalue {smallest:.2g}, and all must "
            "be above 0.",
            "Quantities that both go with a third one go together as well: correct a coefficient.",
        )
    ]


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


def symmetric_matrix(given: ArrayLike, size: int, key: str, row: str) -> Array:
    """Return a matrix of numbers, shape (size, size).

    Parameters
    ----------
    given : array_like
        The matrix.
    size : int
        Number of rows and columns.
    key : str
        Name of the argument, for the messages.
    row : str
        Meaning of a row, such as ``"target"``, for the messages.

    Raises
    ------
    InputError
        It has another shape, or is not symmetric.
    """
    try:
        matrix = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        matrix = np.empty(0)
    wanted = (size, size)
    if matrix.shape != wanted:
        words = f"has the shape {matrix.shape}."
        raise InputError(Fault(key, words, f"Give {wanted}: a row for each {row}."))
    if not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
        raise InputError(Fault(key, "is not symmetric.", "Row i, column j is that of j, i."))
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
    matrix = symmetric_matrix(covariance, len(names), "covariance", "target")
    deviations = np.sqrt(np.maximum(np.diagonal(matrix), 0.0))
    if not (deviations > 0).all():
        raise InputError(Fault("covariance", "has a variance that is not above 0."))
    scaled = matrix / np.outer(deviations, deviations)
    found = tuple(
        (names[i], names[j], float(scaled[i, j]))
        for i in range(len(names))
        for j in range(i + 1, len(names))
        if scaled[i, j] != 0
    )
    if faults := correlation_faults(names, found, "covariance"):
        raise InputError(faults)
    return deviations, found
