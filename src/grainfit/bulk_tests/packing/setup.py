"""Geometry and procedure of a packing test: defaults resolved, impossible values rejected."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grainfit.bulk_tests.shared.slot_box import Filling, count_faults, plan_filling
from grainfit.errors import Fault, InputError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.packing import Round

_NARROWEST = 4.0
#: A settled bed is this share lower than planned at least.
_REACHED = 0.9


@dataclass(frozen=True)
class PackingSetup:
    """Geometry and procedure of one packing test; lengths in m, times in s.

    Parameters
    ----------
    container_radius, fill_height : float
        Inner radius, and height of the bed at a solid fraction of 0.58.
    bulk_density_bottom, bulk_density_top : float
        The bulk density is that of the bed between these heights.
    filling : Filling
        Particles, and when they are at rest.
    settling_time_limit : float
        Longest simulated time in which the bed may come to rest.
    """

    container_radius: float
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
    diameter, gravity = sizes.sauter_diameter, given["gravity"]
    radius = given.get("container_radius", 6 * diameter)
    height = given.get("fill_height", 12 * diameter)
    bottom = given.get("bulk_density_bottom", diameter)
    top = given.get("bulk_density_top", 9 * diameter)
    faults = [*_geometry_faults(sizes, radius, height, bottom, top)]
    if faults:
        raise InputError(faults)
    filling = plan_filling(sizes, Round(radius), height, gravity)
    if faults := [*count_faults(filling.particle_count)]:
        raise InputError(faults)
    fall_time = math.sqrt(2 * filling.column_height / gravity)
    limit = given.get("settling_time_limit", 10 * fall_time)
    return PackingSetup(radius, height, bottom, top, filling, limit)


def _geometry_faults(
    sizes: ParticleSizes, radius: float, height: float, bottom: float, top: float
) -> Iterator[Fault]:
    largest = max(sizes.diameters)
    if 2 * radius < _NARROWEST * largest:
        yield Fault(
            "container_radius",
            f"a container of {2 * radius:g} m diameter is narrower than {_NARROWEST:g} of the "
            f"largest particles ({largest:g} m).",
            f"Use at least {_NARROWEST / 2 * largest:g} m.",
        )
    if top - bottom < largest:
        yield Fault(
            "bulk_density_top",
            f"between {bottom:g} m and {top:g} m there is less than one particle diameter to "
            "measure the bulk density in.",
        )
    if top > _REACHED * height:
        yield Fault(
            "bulk_density_top",
            f"{top:g} m is higher than a bed of {height:g} m settles.",
            f"Measure up to {_REACHED * height:g} m at most, or use a larger fill_height.",
        )
