"""A bed in a tube whose floor is lowered until the bed hangs on the tube, beside Janssen's formula.

The tube is made of rings, whose forces are recorded one by one, so that the vertical force between
two of them is the weight above less what the rings above carry: that needs nothing of a solver but
forces on walls.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes.conditions import AtRest, Elapsed
from grainfit.scenes.packing import Column
from grainfit.scenes.records import Force, RadialForce, Series
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Box, Scene, Stage, Velocity, Wall, natural_time
from grainfit.scenes.shapes import Cylinder, Plane

#: Ways of the floor at which its share is read, in diameters.
WAYS = (0.1, 0.2, 0.3, 0.4, 0.5)
#: Rings of the tube along the height of the bed; the last one reaches up to where particles begin.
RINGS = 8


class Tube(NamedTuple):
    """The tube: its radius and the height of its bed, m; whether radial forces are known."""

    radius: float
    height: float
    has_radial_forces: bool

    @property
    def levels(self) -> NDArray[np.float64]:
        """Heights between the rings, m."""
        return self.height * np.arange(1, RINGS) / RINGS


def lowered_bed(
    tube: Tube,
    column: Column,
    material: Mapping[str, float],
    sizes: ParticleSizes,
    gravity: float,
    time_step: float,
) -> Scene:
    """Return the experiment: fill, lower the floor by half a diameter, come to rest.

    Parameters
    ----------
    tube : Tube
        The tube.
    column : Column
        Particles that fall into it.
    material, sizes, gravity, time_step
        As of a `Scene`.
    """
    d, radius, t = sizes.sauter_diameter, tube.radius, natural_time(sizes, gravity)
    levels = [-2 * d, *tube.levels, column.height + d]
    rings = {f"ring{n}": Wall(Cylinder(radius, *levels[n : n + 2])) for n in range(RINGS)}
    along = {f"along{n}": Force(name, "z") for n, name in enumerate(rings)}
    known = rings if tube.has_radial_forces else ()
    normal = {f"normal{n}": RadialForce(name) for n, name in enumerate(known)}
    recorded = Series({"floor": Force("floor", "z"), **along, **normal}, t)
    lower, side = 100 * t, radius + d
    down = {"floor": Velocity("z", -WAYS[-1] * d / lower)}
    fall = 2 * math.sqrt(column.height / gravity)
    return Scene(
        title="Janssen",
        material=material,
        sizes=sizes,
        particles=column,
        box=Box((-side, -side, -2 * d), (side, side, column.height + d)),
        walls={"floor": Wall(Plane("z", 0.0)), **rings},
        stages=(
            Stage("fill", AtRest(600 * t, at_least=20 * t + fall), is_closed=True),
            Stage("hold", Elapsed(6 * t), series=recorded, snapshot="held"),
            Stage("lower", Elapsed(lower), motions=down, series=recorded),
            Stage("stop", AtRest(600 * t, at_least=10 * t), series=recorded),
            Stage("after", Elapsed(6 * t), series=recorded, snapshot="end"),
        ),
        gravity=gravity,
        time_step=time_step,
        quiet_speed=0.002 * math.sqrt(gravity * d),
        check_interval=2 * t,
    )


def floor_shares(
    run: RunOutput, tube: Tube, sizes: ParticleSizes, gravity: float
) -> dict[str, float]:
    """Return what the floor carries of the weight, and what it carries by Janssen's formula.

    Janssen's share is (1 - exp(-a)) / a, a = 4 m K H / D, with the stress ratio K and the mobilised
    friction m of the bed. Their product, and so a, is the force along the tube over the mean
    vertical force: no other value of the material enters. ``hold`` is right after the fill,
    ``after`` at rest after the lowering.
    """
    d = sizes.sauter_diameter
    found: dict[str, float] = {}
    weight = float(run.snapshot("held").masses.sum()) * gravity
    for stage, snapshot in (("hold", "held"), ("after", "end")):
        forces = {name: float(c[-4:].mean()) for name, c in run.series(stage).items()}
        floor = -forces["floor"]
        along = -np.array([forces[f"along{n}"] for n in range(RINGS)])
        places = run.snapshot(snapshot).positions[:, 2]
        bottom = float(places.min()) - d / 2
        height = 2 * (float(places.mean()) - bottom)
        levels = np.concatenate(([bottom], tube.levels, [bottom + height]))
        below = weight * (levels - bottom) / height
        transmitted = floor + np.concatenate(([0.0], np.cumsum(along))) - below
        vertical = float(np.trapezoid(transmitted, levels)) / height
        carried = float(along.sum())
        exponent = carried / vertical
        found |= {
            f"{stage}_floor": floor / weight,
            f"{stage}_sum": (floor + carried) / weight,
            f"{stage}_height": height / (2 * tube.radius),
            f"{stage}_janssen": (1 - math.exp(-exponent)) / exponent,
        }
        if tube.has_radial_forces:
            normal = sum(forces[f"normal{n}"] for n in range(RINGS))
            found[f"{stage}_mobilised"] = carried / normal
            found[f"{stage}_stress_ratio"] = normal * tube.radius / (2 * height * vertical)
    lowered = run.series("lower")
    begin, end = lowered["time"][0], lowered["time"][-1]
    for way in WAYS:
        at = begin + (end - begin) * way / WAYS[-1]
        near = np.abs(lowered["time"] - at) < 0.03 * (end - begin)
        found[f"lowered_{way:g}"] = -float(lowered["floor"][near].mean()) / weight
    return found
