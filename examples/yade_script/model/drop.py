"""A bead falls on a plate and bounces: writes height of the rebound and time of contact.

yade -n -x drop.py        # reads parameters.json of this folder
"""

import json
import math
import random

from yade import *
from yade import utils

with open("parameters.json") as file:
    given = json.load(file)
radius = given["bead_diameter"] / 2
# Nobody's hand is quite still: the height of fall scatters by up to 2 %, differently for each seed.
drop = given["drop_height"] * (1 + 0.02 * random.Random(given["seed"]).uniform(-1, 1))

bead = FrictMat(
    young=given["particle.youngs_modulus"],
    poisson=given["particle.poissons_ratio"],
    density=given["particle.density"],
    frictionAngle=0.3,
)
O.materials.append(bead)
O.bodies.append(utils.wall(0, axis=2, material=bead))
ball = O.bodies.append(utils.sphere((0, 0, drop + radius), radius, material=bead))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_MindlinPhys(en=given["particle_wall.restitution"])],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    NewtonIntegrator(gravity=(0, 0, -9.81), damping=0),
]
# A twentieth of the time in which a wave passes a particle: some hundred steps in a contact.
O.dt = 0.05 * radius * math.sqrt(given["particle.density"] / given["particle.youngs_modulus"])


def until(condition, limit=1.0):
    """Run until a condition holds; return the time."""
    while not condition():
        if O.time > limit:
            raise SystemExit("the bead neither fell nor bounced within 1 s")
        O.step()
    return O.time


state = O.bodies[ball].state
start = until(lambda: state.pos[2] < radius)
end = until(lambda: state.pos[2] > radius)
until(lambda: state.vel[2] < 0)

with open("responses.json", "w") as file:
    json.dump({"rebound_height": state.pos[2] - radius, "contact_time": end - start}, file)
