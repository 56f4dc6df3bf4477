"""Entries of a test in a calibration file: the keys of its type, and its solver."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
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
    """Entries of a calibration file from which the solver of one test is created.

    Parameters
    ----------
    options : mapping of str to object
        The given keys of the type of test.
    responses : tuple of str
        Responses that have a target, or could be measured.
    free : mapping of str to tuple of float
        Ends of the intervals of the free parameters, by name.
    fixed : mapping of str to float
        Parameters that have a value.
    sizes : ParticleSizes, optional
        Particle sizes.
    contact_models : tuple of str
        Contact models that replace the usual ones of their kind.
    units : mapping of str to str
        Units of the free parameters and of the responses, "" where they have none.
    """

    options: Mapping[str, Any]
    responses: tuple[str, ...]
    free: Mapping[str, tuple[float, float]]
    fixed: Mapping[str, float]
    sizes: ParticleSizes | None
    contact_models: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class TestType:
    """One ``type = "..."`` of a calibration file.

    Parameters
    ----------
    name : str
        Name of the type.
    keys : tuple of Key
        Keys of this type, in addition to those of all tests.
    make_solver : callable
        Creates the solver of a test.
    bulk_test : type, optional
        The bulk test that is simulated; None for custom models.
    check : callable, optional
        Checks combinations of keys, and may complete values.
    has_curves : bool
        Whether custom models of this type can yield curves.
    """

    name: str
    keys: tuple[Key, ...]
    make_solver: Callable[[FileEntry], Solver]
    bulk_test: type[BulkTest] | None = None
    check: Callable[[Values, Place], None] | None = None
    has_curves: bool = True

    # Keeps pytest from taking it for a class of tests.
    __test__ = False
