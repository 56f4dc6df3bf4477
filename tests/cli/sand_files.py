"""A calibration file, and a model of one parameter with its scatter: plain files of a user."""

from __future__ import annotations

MODEL = """
import random

def drum(parameters, seed):
    noise = random.Random(seed).gauss(0, 0.3)
    return {"angle": 20 + 40 * parameters["friction"] + noise}
"""
FILE = """
name = "sand"

[parameters]
friction = { min = 0.1, max = 0.9 }

[[test]]
type = "python"
function = "model.py:drum"
targets.angle = { value = 36, uncertainty = 0.4, unit = "deg" }
"""
