"""Stages and settings that tests with a door in the floor share: fill, open the door, come to rest.

The mass that is still in the container is recorded while it flows out.
"""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.bulk_tests.shared.filling import Filling
from grainfit.scenes.conditions import AtRest, Condition, Drained
from grainfit.scenes.records import MassAbove, Series
from grainfit.scenes.scene import Stage

#: Snapshots at the ends of the two stages, and the stage with the flow.
BED, END, FLOW = "bed", "end", "flow"
#: Column of the series with the mass in the container.
INSIDE = "inside"
#: Records of the mass in the time that a look at the end of a stage takes.
_RECORDS_PER_CHECK = 15


@dataclass(frozen=True)
class Flow:
    """Times of the stages, s.

    Parameters
    ----------
    shortest : float
        Shortest time of the flow.
    limit : float
        Longest time in which the particles may come to rest.
    share : float, optional
        Share of the mass with which the flow ends; by default it goes on until all is at rest.
    """

    shortest: float
    limit: float
    share: float | None = None

    @property
    def end(self) -> str:
        """What the flow goes on for, in words."""
        return "all is at rest" if self.share is None else "its flow is known"

    def until(self, underside: float) -> Condition:
        """Return the end of the flow out of a container whose underside is at a height, m."""
        if self.share is None:
            return AtRest(self.limit, at_least=self.shortest)
        return Drained(underside, self.share, self.limit, at_least=self.shortest)


def fill_and_flow(filling: Filling, flow: Flow, underside: float) -> tuple[Stage, ...]:
    """Return the two stages: the column falls and comes to rest, the door is taken away.

    Parameters
    ----------
    filling : Filling
        Particles and when they are at rest.
    flow : Flow
        Times of the stages.
    underside : float
        Height below which particles have left the container, m.
    """
    every = filling.check_interval / _RECORDS_PER_CHECK
    return (
        filling.stage(flow.limit, BED),
        Stage(
            FLOW,
            flow.until(underside),
            f"the door is taken away; until {flow.end}",
            take_away=("door",),
            series=Series({INSIDE: MassAbove(underside)}, every),
            snapshot=END,
        ),
    )
