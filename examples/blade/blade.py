"""A pile that is pushed by a blade: none of grainfit's own tests.

Particles are poured between the blade and a gate. The gate is taken away, the bed slumps to a
pile that leans on the blade, and the blade pushes it over the floor. The bed is a slice: it
repeats along y.
"""

import numpy as np

from grainfit.scenes import (
    AtRest,
    Block,
    Box,
    Elapsed,
    Force,
    Plane,
    Rectangle,
    RunOutput,
    Scene,
    Series,
    Stage,
    Travel,
    Velocity,
    Wall,
    natural_speed,
    natural_time,
    random_column,
)

# Lengths in diameters of the real particles: coarse graining enlarges those of the simulation.
WIDTH, DEPTH, FILL, PUSH = 8.0, 5.0, 7.0, 12.0
SOLID_FRACTION = 0.58


def scene(material, sizes, seed, gravity, time_step, options):
    """Return the experiment, from the parameters of the run."""
    d, time = sizes.sauter_diameter, natural_time(sizes, gravity)
    unit = sizes.real.sauter_diameter
    width, depth = WIDTH * unit, DEPTH * unit
    volume = SOLID_FRACTION * WIDTH * DEPTH * FILL * (unit / d) ** 3
    count = round(volume / (np.pi / 6))
    particles = random_column(sizes, count, Rectangle(width, depth), seed)
    back, gate, top = -width / 2, width / 2, particles.height + d
    speed = options["blade_speed"]
    return Scene(
        title="A pile pushed by a blade",
        material=material,
        sizes=sizes,
        particles=particles,
        box=Box((back - 3 * d, 0.0, -2 * d), (gate + 45 * unit, depth, top + d), periodic="y"),
        walls={
            "floor": Wall(Plane("z", 0.0)),
            "blade": Wall(Block((back - d, 0.0, 0.1 * unit), (back, depth, top))),
            "gate": Wall(Block((gate, 0.0, 0.1 * unit), (gate + d, depth, top))),
        },
        stages=(
            Stage("fill", AtRest(limit=80 * time, at_least=12 * time), is_closed=True),
            Stage(
                "slump",
                AtRest(limit=80 * time, at_least=8 * time),
                take_away=("gate",),
                snapshot="pile",
            ),
            Stage(
                "push",
                Elapsed(PUSH * unit / speed),
                motions={"blade": Velocity("x", speed)},
                series=Series(
                    {"force": Force("blade", "x"), "travel": Travel("blade")}, every=0.2 * time
                ),
                is_closed=True,
            ),
        ),
        gravity=gravity,
        time_step=time_step,
        quiet_speed=0.0128 * natural_speed(sizes, gravity),
        check_interval=1.57 * time,
    )


def measure(run: RunOutput, sizes):
    """Return the force of the second half of the push, and the slope of the pile before it."""
    d, unit = sizes.sauter_diameter, sizes.real.sauter_diameter
    push = run.series("push")
    later = push["travel"] > PUSH / 2 * unit
    # The bed pushes the blade back, along -x. Ten parts of the push are nearly independent.
    parts = np.array_split(-push["force"][later] / (DEPTH * unit), 10)
    means = np.array([part.mean() for part in parts])
    pile = run.snapshot("pile")
    return {
        "push_force": (means.mean(), means.std(ddof=1) / np.sqrt(len(means))),
        "slope": slope(pile.positions, pile.radii, d),
    }


def slope(positions, radii, d):
    """Return the inclination of the pile's surface and its standard error, degrees."""
    x, tops = positions[:, 0], positions[:, 2] + radii
    edges = np.arange(x.min(), x.max() - d, d)
    heights = np.array([tops[(x >= edge) & (x < edge + d)].max(initial=0.0) for edge in edges])
    middle = (heights > 1.5 * d) & (heights < heights.max() - 0.5 * d)
    (gradient, _), spread = np.polyfit(edges[middle], heights[middle], 1, cov=True)
    angle = np.degrees(np.arctan(-gradient))
    return angle, np.degrees(np.sqrt(spread[0, 0]) / (1 + gradient**2))
