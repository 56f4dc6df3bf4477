"""
Measured and expected curves
============================

A curve as a target: stress over strain of an oedometer, from the page on curves. The points are
the measurements, the band is where the calibrated model is expected with 95 % probability.
"""

import tempfile

import numpy as np

import grainfit as gf


def press(parameters, seed):
    """One simulated compression: stress over strain."""
    strains = np.linspace(0.0, 0.05, 40)
    stresses = parameters["modulus"] * strains * (1 + parameters["stiffening"] * 20 * strains)
    scatter = 1 + 0.02 * np.random.default_rng(seed).normal()
    return {"stress": gf.Curve(strains, scatter * stresses)}


strains = [0.005, 0.010, 0.015, 0.020, 0.025, 0.030, 0.035, 0.040]
stresses = [1.27e3, 2.69e3, 4.25e3, 5.93e3, 7.83e3, 9.78e3, 11.90e3, 14.30e3]  # Pa
problem = gf.Problem(
    [gf.Parameter("modulus", 1e5, 4e5), gf.Parameter("stiffening", 0.0, 1.0)],
    targets=[],
    curves=[gf.CurveTarget("stress", strains, stresses, "1 %", systematic="2 %")],
)
folder = tempfile.mkdtemp()
result = gf.calibrate(problem, gf.solvers.PythonCallable(press, identity="press"), workdir=folder)
gf.plots.curves(gf.open(folder))

# sphinx_gallery_thumbnail_path = 'images/gallery/curves.png'
