"""What a strategy believes in, how far it can be trusted, and what it cannot meet: plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Bound = Literal["min", "max"]


@dataclass(frozen=True)
class MetamodelQuality:
    """How far a metamodel can be trusted, by leave-one-out.

    Parameters
    ----------
    q2 : float or None
        Share of the variance of the responses that is predicted; 1 is perfect. None when the
        responses are all equal.
    coverage : float
        Share of the runs inside their 95 % interval.
    noise : float
        Estimated standard deviation of the response from seed to seed.
    warnings : tuple of str
        Why it is not to be trusted, in words; empty when it is.
    """

    q2: float | None
    coverage: float
    noise: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class OutOfReach:
    """A target that the intervals do not allow to meet.

    Parameters
    ----------
    target : str
        Name of the target.
    value : float
        Its value.
    nearest, standard_error : float
        Nearest expected response within the intervals, and how well it is known.
    jointly : bool
        The target could be met alone, but not together with the others.
    parameter, bound, bound_value : str, {"min", "max"}, float, optional
        The bound that is in the way.
    suggestion : float, optional
        A bound that should do, by linear extrapolation; None when none is in sight.
    """

    target: str
    value: float
    nearest: float
    standard_error: float
    jointly: bool = False
    parameter: str | None = None
    bound: Bound | None = None
    bound_value: float | None = None
    suggestion: float | None = None

    @property
    def shortfall_percent(self) -> float:
        """Deviation of the nearest response from the target, in percent of the target."""
        return 100 * (self.nearest - self.value) / self.value

    def __str__(self) -> str:
        together = " together with the other targets" if self.jointly else ""
        text = (
            f"{self.target} = {self.value:g} is out of reach{together}: the nearest within the "
            f"intervals is {self.nearest:.5g} ({self.shortfall_percent:+.1f} %)."
        )
        if self.parameter is None:
            return f"{text} No single bound is in the way: free another parameter."
        text += f" The bound in the way is {self.parameter}.{self.bound} = {self.bound_value:g}"
        if self.suggestion is None:
            return f"{text}, and no possible value beyond it would do: free another parameter."
        return f"{text}; try {self.suggestion:g}."


@dataclass(frozen=True)
class Answer:
    """What a strategy believes in.

    Parameters
    ----------
    parameters : mapping of str to float
        Values of the free parameters.
    predicted, standard_errors : mapping of str to float
        Expected response and its standard error, by name of the target.
    agreement : float
        Probability, by the metamodels, that all expected responses are within their tolerances.
    out_of_reach : tuple of OutOfReach
        Targets that no parameter set within the intervals meets.
    quality : mapping of str to MetamodelQuality
        By name of the target.
    cut_off : mapping of str to {"min", "max"}
        Parameters of which what agrees reaches a bound, though not everything does: more may agree
        beyond.
    """

    parameters: Mapping[str, float]
    predicted: Mapping[str, float]
    standard_errors: Mapping[str, float]
    agreement: float
    out_of_reach: tuple[OutOfReach, ...] = ()
    quality: Mapping[str, MetamodelQuality] = field(default_factory=dict)
    cut_off: Mapping[str, Bound] = field(default_factory=dict)
