"""
Your own Python model, in a notebook
====================================

A model is any function of parameters and a seed that returns responses. Here a bead falls on a
plate, and its rebound and the time of contact determine the spring and the restitution of the
contact. You write the model, calibrate it, and look at the runs with pandas and Plotly. It takes
seconds; ``pip install "grainfit[notebook]"`` has all that it needs.

The model
---------

The contact is a spring of stiffness *k* with a dashpot. Its force is integrated in small steps
until the bead leaves the plate. The seed stands for what differs from drop to drop: the hand that
lets the bead go.
"""

import math
import tempfile

import numpy as np

import grainfit as gf

MASS = 1.3e-3  # kg
GRAVITY = 9.81  # m/s^2


def drop(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """Simulate one drop from 200 mm, and return rebound height (m) and contact time (s)."""
    stiffness, restitution = parameters["stiffness"], parameters["restitution"]
    height = 0.2 + np.random.default_rng(seed).normal(0, 1e-3)
    log_e = math.log(restitution)
    damping_ratio = -log_e / math.hypot(math.pi, log_e)
    damping = 2 * damping_ratio * math.sqrt(stiffness * MASS)
    step = 0.01 * math.sqrt(MASS / stiffness)
    overlap, speed, time = 0.0, math.sqrt(2 * GRAVITY * height), 0.0
    while overlap >= 0:
        speed += step * (GRAVITY - (stiffness * overlap + damping * speed) / MASS)
        overlap += step * speed
        time += step
    return {"rebound_height": speed**2 / (2 * GRAVITY), "contact_time": time}


# %%
# Try it once: does it do what you expect? A restitution of 0.9 returns 0.81 of the height.

drop({"stiffness": 1e5, "restitution": 0.9}, seed=1)

# %%
# The problem
# -----------
#
# What you do not know has an interval; what you measured is a target with its uncertainty. Here a
# high-speed camera saw five rebounds and timed the contact.

problem = gf.Problem(
    parameters=[
        gf.Parameter("stiffness", 1e4, 1e6, scale="log", unit="N/m"),
        gf.Parameter("restitution", 0.5, 0.99),
    ],
    targets=[
        gf.Target.of_measurements(
            "rebound_height", [0.1298, 0.1312, 0.1289, 0.1305, 0.1296], tolerance="2 %", unit="m"
        ),
        gf.Target("contact_time", 3.2e-4, uncertainty="2 %", unit="s"),
    ],
)

# %%
# The calibration
# ---------------
#
# Name a folder of your own as ``workdir`` to keep the runs: started again, the calibration
# continues there. In a notebook, ``progress=True`` shows a bar.

folder = tempfile.mkdtemp()
gf.calibrate(problem, drop, workdir=folder)

# %%
# Check it by hand: a linear spring has a contact time of about π √(m / k), and the restitution is
# the root of rebound over drop height.

print(f"k = {MASS * (math.pi / 3.2e-4) ** 2:.3g} N/m, e = {math.sqrt(0.13 / 0.2):.3f}")

# %%
# Runs as a table
# ---------------
#
# ``runs()`` is a pandas DataFrame with one row for each run.

saved = gf.open(folder)
runs = saved.runs()
runs[["seed", "stiffness", "restitution", "rebound_height", "contact_time"]].round(6)

# %%
# Figures
# -------
#
# Which parameter sets agree with the measurements:

gf.plots.posterior(saved)

# %%
# How near the simulated responses come to the measured ones, run by run:

gf.plots.convergence(saved)

# sphinx_gallery_thumbnail_path = 'images/gallery/posterior.png'
