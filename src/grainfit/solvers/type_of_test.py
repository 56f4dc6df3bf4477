"""Types of test in a calibration file: their keys, and how the solver of a test is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.bulk_tests.base import BulkTest
from grainfit.materials.sizes import ParticleSizes
from grainfit.options.kinds import Quantity
from grainfit.options.places import Place
from grainfit.options.tables import Key, Values
from grainfit.solvers.base import Solver

TIMEOUT_KEY = Key(
    "timeout", Quantity("s", above_zero=True), "Longest wall time of a run.", example='"10 min"'
)


@dataclass(frozen=True)
class FileEntry:
    """All that a calibration file says for making the solver of one test.

    Parameters
    ----------
    options : mapping of str to object
        The keys of the test's type, those that were given.
    responses : tuple of str
        Responses that have a target.
    free : tuple of str
        Names of the free parameters.
    fixed : mapping of str to float
        Parameters that have a value.
    sizes : ParticleSizes, optional
        Of the particles.
    """

    options: Mapping[str, Any]
    responses: tuple[str, ...]
    free: tuple[str, ...]
    fixed: Mapping[str, float]
    sizes: ParticleSizes | None


@dataclass(frozen=True)
class TypeOfTest:
    """One ``type = "..."`` of a calibration file.

    Parameters
    ----------
    name : str
        The type.
    keys : tuple of Key
        Besides those that all tests have.
    make_solver : callable
        Makes the solver of a test.
    bulk_test : type, optional
        The test that is simulated; None when a model of the user simulates.
    check : callable, optional
        Notes what is wrong with several keys together, and may complete them.
    """

    name: str
    keys: tuple[Key, ...]
    make_solver: Callable[[FileEntry], Solver]
    bulk_test: type[BulkTest] | None = None
    check: Callable[[Values, Place], None] | None = None
