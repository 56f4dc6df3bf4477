"""Abilities that few bulk tests have: a test that has one is an instance of its protocol."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self, runtime_checkable

from grainfit.errors import Fault
from grainfit.options.fields import Amount, option_remarks
from grainfit.scenes.scene import Scene


@dataclass(frozen=True)
class CurveRange:
    """Coordinates beyond which no run of a test has values of a curve.

    Parameters
    ----------
    low, high : float
        Ends, in the unit of the coordinate.
    low_option, high_option : str
        Option of the test that is the end; empty where none is.
    """

    low: float = -math.inf
    high: float = math.inf
    low_option: str = ""
    high_option: str = ""


@runtime_checkable
class LimitsCurves(Protocol):
    """A test whose options limit the coordinates of its curves."""

    def curve_range(self, name: str) -> CurveRange:
        """Return the coordinates that a curve can have."""


def curve_range(test: object, name: str) -> CurveRange:
    """Return the coordinates that a curve of a test can have; all if that is not known."""
    return test.curve_range(name) if isinstance(test, LimitsCurves) else CurveRange()


@dataclass(frozen=True)
class LocusPoint:
    """Point of a yield locus that a bulk test gives.

    Parameters
    ----------
    normal_stress : float
        Pa.
    angle : str
        Response whose tangent is the shear stress over the normal stress.
    """

    normal_stress: float
    angle: str


@runtime_checkable
class GivesLocusPoint(Protocol):
    """A test that gives a point of a yield locus."""

    @property
    def locus_point(self) -> LocusPoint:
        """The point."""


def locus_point(test: object) -> LocusPoint | None:
    """Return the point of a yield locus that a test gives; None for most tests."""
    return test.locus_point if isinstance(test, GivesLocusPoint) else None


@runtime_checkable
class AdaptsOptions(Protocol):
    """A test whose apparatus a laboratory would choose by the material."""

    @classmethod
    def options_for(cls, material: Mapping[str, float]) -> dict[str, Amount]:
        """Return options that suit a material where the defaults fail."""


def options_for(test: type[Any], material: Mapping[str, float]) -> dict[str, Amount]:
    """Return options that a laboratory would choose where defaults fail; none for most tests."""
    return test.options_for(material) if isinstance(test, AdaptsOptions) else {}


@runtime_checkable
class RefusesMaterials(Protocol):
    """A test that means nothing with some materials."""

    #: Parameters of which one end of an interval is the worse one: 0 the lower one, 1 the upper.
    worse_ends: ClassVar[Mapping[str, int]]

    def material_faults(self, material: Mapping[str, float]) -> Iterable[Fault]:
        """Return why the test means nothing with a material."""


def material_faults(test: object, material: Mapping[str, float]) -> Iterable[Fault]:
    """Return why a test means nothing with a material; nothing for most tests.

    Parameters
    ----------
    test : BulkTest
        The test.
    material : mapping of str to float
        Material parameters by dotted name: those that are known.
    """
    return test.material_faults(material) if isinstance(test, RefusesMaterials) else ()


def worse_ends(test: object) -> Mapping[str, int]:
    """Return the parameters of which one end of an interval is the worse one for a test."""
    return test.worse_ends if isinstance(test, RefusesMaterials) else {}


@runtime_checkable
class HasUserFunctions(Protocol):
    """A test whose scene and measurement are functions of the user."""

    def executes(self) -> tuple[str, ...]:
        """Describe the user's code that a run executes, in one line for each function."""

    def planned(self, material: Mapping[str, float]) -> Scene:
        """Return the scene of one seed."""

    def with_targets(self, names: Sequence[str]) -> Self:
        """Return the test that requires these responses of the user's function."""


def is_of_user(test: object) -> bool:
    """Return whether scene and measurement are functions of the user, also of recorded tests."""
    return isinstance(test, HasUserFunctions)


def user_functions(test: object) -> tuple[str, ...]:
    """Describe the user's code that a run of a test executes, in one line for each function."""
    return test.executes() if isinstance(test, HasUserFunctions) else ()


def friction_options(test: type[Any]) -> dict[str, tuple[str, ...]]:
    """Return the options of a test that give a part a friction of its own, by part."""
    parts = option_remarks(test, "part")
    return {
        part: tuple(name for name, one in parts.items() if one == part)
        for part in dict.fromkeys(parts.values())
    }


def starter_remarks(test: type[Any]) -> dict[str, str]:
    """Return the options that a first calibration file sets to their examples, with a remark.

    Their defaults suit few materials.
    """
    return option_remarks(test, "starter")
