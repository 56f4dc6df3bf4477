"""An upright cylinder with a round outlet in a flat floor or a cone, which a disc closes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from grainfit.bulk_tests.shared import messages
from grainfit.bulk_tests.shared.orifice import Orifice
from grainfit.bulk_tests.shared.slot_box import container_faults
from grainfit.bulk_tests.shared.vessel import FLAT, Vessel
from grainfit.bulk_tests.view import Outline, circle
from grainfit.errors import Fault
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.scene import Wall
from grainfit.scenes.shapes import Annulus, Cone, Cylinder, Disc


@dataclass(frozen=True)
class RoundContainer(Vessel):
    """Geometry of a round container; lengths in m, the outlet is at z = 0.

    Parameters
    ----------
    radius : float
        Inner radius.
    fill_height : float
        Height of the bed before it settles.
    orifice_radius : float
        Radius of the orifice.
    half_angle : float
        Angle between cone and vertical, degrees; 90 is a flat floor.
    stem_length : float
        Length of the tube below floor or cone.
    """

    radius: float
    fill_height: float
    orifice_radius: float
    half_angle: float = FLAT
    stem_length: float = 0.0

    @property
    def period(self) -> None:
        """None: it is no slice."""
        return None

    @property
    def half_outlet(self) -> float:
        """Radius of the outlet, m."""
        return self.orifice_radius

    @property
    def half_width(self) -> float:
        """Inner radius, m."""
        return self.radius

    @property
    def underside(self) -> float:
        """Height below which particles have left, m."""
        return 0.0

    @property
    def orifice(self) -> Orifice:
        """The round outlet."""
        return Orifice("orifice_diameter", "an orifice", 2 * self.orifice_radius)

    def walls(self, top: float, largest: float) -> dict[str, Wall]:  # noqa: ARG002
        """Return tube, floor and door by name; the tube ends at a height, m."""
        outlet, stem, slope_top = self.orifice_radius, self.stem_length, self.slope_top
        floor = Cone(outlet, self.radius, stem, slope_top)
        return {
            "tube": Wall(Cylinder(self.radius, slope_top, top)),
            "floor": Wall(Annulus(outlet, self.radius, stem) if self.is_flat else floor),
            **({"stem": Wall(Cylinder(outlet, 0.0, stem))} if stem else {}),
            "door": Wall(Disc(outlet, 0.0)),
        }

    def outlines(self, top: float) -> list[Outline]:
        """Return the circles of the container, and its section, as polylines, m."""
        corners = self.section(top)
        sides: list[Outline] = [[(side * x, 0.0, z) for x, z in corners] for side in (-1, 1)]
        return [*(circle(radius, z) for radius, z in corners), *sides]

    def faults(self, sizes: ParticleSizes) -> Iterator[Fault]:
        """Iterate over what is impossible about the container."""
        if self.orifice_radius >= self.radius:
            yield messages.ORIFICE_IS_WIDE.fault(
                "orifice_diameter", width=self.orifice.width, diameter=2 * self.radius
            )
        yield from self.orifice.passing_faults(sizes)
        yield from self.slope_faults()
        yield from container_faults(sizes, 2 * self.radius, self.fill_height)
