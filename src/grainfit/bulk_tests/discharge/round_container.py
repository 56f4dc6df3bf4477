"""An upright cylinder with a round orifice in its flat floor, which a disc closes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from grainfit.bulk_tests.discharge import messages
from grainfit.bulk_tests.shared.orifice import Orifice
from grainfit.bulk_tests.shared.slot_box import container_faults
from grainfit.bulk_tests.view import Outline, circle
from grainfit.errors import Fault
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.scene import Wall
from grainfit.scenes.shapes import Annulus, Cylinder, Disc


@dataclass(frozen=True)
class RoundContainer:
    """Geometry of a round container; lengths in m, the floor is at z = 0.

    Parameters
    ----------
    radius : float
        Inner radius.
    fill_height : float
        Height of the bed before it settles.
    orifice_radius : float
        Radius of the orifice.
    """

    radius: float
    fill_height: float
    orifice_radius: float

    @property
    def orifice(self) -> Orifice:
        """The hole in the floor."""
        return Orifice("orifice_diameter", "an orifice", 2 * self.orifice_radius)

    def walls(self, top: float, largest: float) -> dict[str, Wall]:  # noqa: ARG002
        """Return tube, floor and door by name; the tube ends at a height, m."""
        return {
            "tube": Wall(Cylinder(self.radius, 0.0, top)),
            "floor": Wall(Annulus(self.orifice_radius, self.radius, 0.0)),
            "door": Wall(Disc(self.orifice_radius, 0.0)),
        }

    def outlines(self, top: float) -> list[Outline]:
        """Return the circles of the container, and two lines along it, as polylines, m."""
        circles = ((self.orifice_radius, 0.0), (self.radius, 0.0), (self.radius, top))
        lines = [circle(radius, z) for radius, z in circles]
        sides: list[Outline] = [[(x, 0.0, 0.0), (x, 0.0, top)] for x in (-self.radius, self.radius)]
        return lines + sides

    def faults(self, sizes: ParticleSizes) -> Iterator[Fault]:
        """Iterate over what is impossible about the container."""
        if self.orifice_radius >= self.radius:
            yield messages.ORIFICE_IS_WIDE.fault(
                "orifice_diameter", width=self.orifice.width, diameter=2 * self.radius
            )
        yield from self.orifice.passing_faults(sizes)
        yield from container_faults(sizes, 2 * self.radius, self.fill_height)
