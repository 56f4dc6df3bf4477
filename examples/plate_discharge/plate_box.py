"""Discharge of a box over a plate: the pile that stays on the plate has the angle of repose.

The floor of a wide box is a plate in the middle and a door on either side of it. Once the bed is at
rest both doors are taken away, and what the plate cannot hold flows past its edges. The box is a
slice that repeats along y, or, with the option end_walls, stands between two walls. After Zhou, Xu,
Yu and Zulli, Powder Technology 125 (2002) 45.
"""

from dataclasses import replace

import numpy as np

from grainfit import NotMeasurableError
from grainfit.scenes import (
    AtRest,
    Block,
    Box,
    Plane,
    Rectangle,
    RunOutput,
    Scene,
    Stage,
    Wall,
    natural_speed,
    natural_time,
    random_column,
)

SOLID_FRACTION = 0.58
# A flank is fitted between these parts of the pile's height.
LOW, HIGH = 0.1, 0.9


def scene(material, sizes, seed, gravity, time_step, options):
    """Return the experiment, from the parameters of the run."""
    d, time = sizes.sauter_diameter, natural_time(sizes, gravity)
    width, plate, depth = options["width"], options["plate"], options["depth"]
    volume = SOLID_FRACTION * width * depth * options["fill_height"]
    count = round(volume / (np.pi / 6 * d**3))
    end_walls = {}
    if options.get("end_walls", False):
        # A column for a periodic slice fits between walls half a diameter beyond its ends.
        largest = max(sizes.diameters)
        particles = random_column(sizes, count, Rectangle(width, depth - largest), seed)
        shifted = particles.positions.copy()
        shifted[:, 1] += largest / 2
        particles = replace(particles, positions=shifted)
        end_walls["front"] = Wall(Plane("y", 0.0))
        end_walls["back"] = Wall(Plane("y", depth, upwards=False))
    else:
        particles = random_column(sizes, count, Rectangle(width, depth), seed)
    top, side = particles.height + d, width / 2
    patience = 40 * np.sqrt(2 * top / gravity)
    return Scene(
        title="Discharge of a box over a plate",
        material=material,
        sizes=sizes,
        particles=particles,
        box=_box(side + d, depth, -6 * d, top, is_periodic=not end_walls),
        walls={
            **end_walls,
            "left": Wall(Plane("x", -side)),
            "right": Wall(Plane("x", side, upwards=False)),
            "plate": Wall(Block((-plate / 2, 0.0, -d), (plate / 2, depth, 0.0))),
            "left_door": Wall(Block((-side - d, 0.0, -d), (-plate / 2, depth, 0.0))),
            "right_door": Wall(Block((plate / 2, 0.0, -d), (side + d, depth, 0.0))),
        },
        stages=(
            Stage("fill", AtRest(limit=patience, at_least=12 * time), is_closed=True),
            Stage(
                "flow",
                AtRest(limit=patience, at_least=12 * time),
                take_away=("left_door", "right_door"),
            ),
        ),
        gravity=gravity,
        time_step=time_step,
        quiet_speed=0.0128 * natural_speed(sizes, gravity),
        check_interval=1.57 * time,
    )


def _box(half_width, depth, bottom, top, is_periodic):
    # Particles may not touch the faces of a box that does not repeat.
    beyond = 0.0 if is_periodic else 0.1 * depth
    low, high = (-half_width, -beyond, bottom), (half_width, depth + beyond, top)
    return Box(low, high, periodic="y" if is_periodic else "")


def measure(run: RunOutput, sizes, options):
    """Return the angle of repose of the pile on the plate, degrees."""
    d, half = sizes.sauter_diameter, options["plate"] / 2
    pile = run.snapshot("end")
    x, y, z = pile.positions.T
    on_plate = (np.abs(x) < half) & (z > 0)
    columns, slices = round(2 * half / d), round(options["depth"] / d)
    # Tops of the particles in cells of one diameter, columns along x and slices along y.
    heights = np.zeros((columns, slices))
    cells = (
        ((x[on_plate] + half) * columns / (2 * half)).astype(int),
        (y[on_plate] % options["depth"] * slices / options["depth"]).astype(int) % slices,
    )
    np.maximum.at(heights, cells, z[on_plate] + pile.radii[on_plate])
    if heights.mean(axis=1).max() < 4 * d:
        raise NotMeasurableError("the pile on the plate is lower than 4 particle diameters")
    middles = (np.arange(columns) + 0.5) * 2 * half / columns - half
    flanks = [flank(middles[side], heights[side]) for side in (middles > 0, middles < 0)]
    angles = np.array(flanks)
    # Slices next to each other are alike: those of five diameters count as one.
    independent = max(2.0, angles.size / 5)
    return {"angle_of_repose": (angles.mean(), angles.std() / np.sqrt(independent - 1))}


def flank(x, heights):
    """Return the inclinations of the slices of one flank, degrees."""
    profile = heights.mean(axis=1)
    outwards = np.argsort(np.abs(x))
    inside = profile[outwards] > HIGH * profile.max()
    begin = np.flatnonzero(inside)[-1] + 1
    low = np.flatnonzero(profile[outwards[begin:]] < LOW * profile.max())
    used = outwards[begin : begin + low[0] if len(low) else None]
    if len(used) < 4:
        raise NotMeasurableError("the pile on the plate has no flanks: its sides are steps")
    slopes = np.polyfit(np.abs(x[used]), heights[used], 1)[0]
    return np.degrees(np.arctan(-slopes))
