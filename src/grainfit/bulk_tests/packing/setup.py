"""Geometry and procedure of a packing test: defaults resolved, impossible values rejected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.shared.filling import (
    Fall,
    Filling,
    count_faults,
    cylinder_faults,
    least_radius,
    plan_filling,
)
from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Round

#: Height that every settled bed reaches, over the height that it was planned with at a solid
#: fraction of 0.58. The densest beds, of smooth or soft particles and of mixtures, have 0.65 to
#: 0.67: they reach 0.86 to 0.89 of it.
_REACHED = 0.85
_SLACK = 1e-9


@dataclass(frozen=True)
class PackingSetup:
    """Geometry and procedure of one packing test; lengths in m, times in s.

    Parameters
    ----------
    cylinder_radius, fill_height : float
        Inner radius, and height of the bed at a solid fraction of 0.58.
    bulk_density_bottom, bulk_density_top : float
        The bulk density is that of the bed between these heights.
    filling : Filling
        Particles, and when they are at rest.
    settling_time_limit : float
        Longest simulated time in which the bed may come to rest.
    """

    cylinder_radius: float
    fill_height: float
    bulk_density_bottom: float
    bulk_density_top: float
    filling: Filling
    settling_time_limit: float

    @property
    def measured_heights(self) -> str:
        """Heights between which the bulk density is measured, in words."""
        low, high = 1000 * self.bulk_density_bottom, 1000 * self.bulk_density_top
        return f"between {low:.3g} and {high:.3g} mm"


def plan_setup(sizes: ParticleSizes, options: Mapping[str, float | None]) -> PackingSetup:
    """Resolve every default of a packing test.

    Parameters
    ----------
    sizes : ParticleSizes
        The length scale of all defaults is the Sauter diameter.
    options : mapping of str to float or None
        The options of `Packing`, each within its limits; None stands for the default.

    Raises
    ------
    InputError
        The test is impossible; names every option at fault.
    """
    given = {name: value for name, value in options.items() if value is not None}
    real, gravity = sizes.real, given["gravity"]
    diameter = real.sauter_diameter
    radius = given.get("cylinder_radius", max(6 * diameter, least_radius(real)))
    bottom = given.get("bulk_density_bottom", diameter)
    top, height = _heights(sizes, bottom, given)
    faults = [*cylinder_faults(sizes, radius)]
    faults += _height_faults(sizes, height, bottom, top, "bulk_density_top" in given)
    if faults:
        raise InputError(faults)
    filling = plan_filling(sizes, Round(radius), height, gravity)
    lengths = {"cylinder_radius": radius, "fill_height": height}
    if faults := [*count_faults(filling.particle_count, lengths, count_is_given=False)]:
        raise InputError(faults)
    fall = Fall(filling.column_height, gravity)
    limit = given.get("settling_time_limit", fall.settling_time_limit)
    return PackingSetup(radius, height, bottom, top, filling, limit)


def _heights(
    sizes: ParticleSizes, bottom: float, given: Mapping[str, float]
) -> tuple[float, float]:
    """Return the height up to which the bulk density is measured, and that of the bed, m."""
    real = sizes.real
    diameter = real.sauter_diameter
    top = max(9 * diameter, bottom + 2 * max(real.diameters))
    if "fill_height" in given:
        top = min(top, _REACHED * given["fill_height"])
    top = given.get("bulk_density_top", top)
    return top, given.get("fill_height", max(12 * diameter, top / _REACHED))


def _height_faults(
    sizes: ParticleSizes, height: float, bottom: float, top: float, top_is_given: bool
) -> Iterator[Fault]:
    if top - bottom < max(sizes.diameters):
        yield Fault(
            # A default top is this low only in a bed that is too low.
            "bulk_density_top" if top_is_given else "fill_height",
            f"between {bottom:g} m and {top:g} m there is less than one particle diameter to "
            "measure the bulk density in.",
            "Measure higher, or use a larger fill_height.",
        )
    if top > (1 + _SLACK) * _REACHED * height:
        yield Fault(
            "bulk_density_top",
            f"{top:g} m is higher than a bed of {height:g} m settles.",
            f"Measure up to {_REACHED * height:g} m at most, or use a larger fill_height.",
        )
