"""Conditions that end a stage of a scene. Times are simulated, in s."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AtRest:
    """The particles have come to rest.

    Parameters
    ----------
    limit : float
        A bed that is still moving after this time fails the run.
    at_least : float
        The first look is after this time.
    """

    limit: float
    at_least: float = 0.0


@dataclass(frozen=True)
class Clear:
    """A lifted wall is clear of particles at rest, or its travel is over.

    Parameters
    ----------
    wall : str
        Name of the wall, a `Cylinder`.
    limit : float
        Longest time of the travel; then the stage ends well, too.
    """

    wall: str
    limit: float


@dataclass(frozen=True)
class Loaded:
    """The force on a loaded wall is the wanted one at two looks in a row, and the bed is at rest.

    Parameters
    ----------
    wall : str
        Name of the wall; it moves by a `Load` in this stage.
    within : float
        Accepted deviation of the force, as a share.
    limit : float
        A force that is not held after this time fails the run.
    """

    wall: str
    within: float
    limit: float


@dataclass(frozen=True)
class Drained:
    """A share of the loose particles' mass is not above a height any more, or all are at rest.

    Parameters
    ----------
    height : float
        m.
    share : float
        Share of the mass at the beginning of the scene, above 0 and up to 1.
    limit : float
        Particles that are still moving after this time fail the run.
    at_least : float
        The first look is after this time.
    """

    height: float
    share: float
    limit: float
    at_least: float = 0.0

    def left(self, mass: float) -> float:
        """Return how much of a mass may still be above the height at the end, kg."""
        return (1 - self.share) * mass


@dataclass(frozen=True)
class Elapsed:
    """A time has passed."""

    time: float


Condition = AtRest | Clear | Loaded | Drained | Elapsed
