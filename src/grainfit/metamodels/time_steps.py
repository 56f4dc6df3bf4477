"""Rayleigh time steps of points of the unit cube, and the penalty of a small one."""

from __future__ import annotations

import math

import numpy as np

from grainfit.arrays import Array
from grainfit.problem import Problem

#: Time steps that differ by less than this share count as equal: the closer answer is taken.
EQUAL_TIME_STEPS = 0.05


def time_step_matters(problem: Problem) -> bool:
    """Whether free parameters change the Rayleigh time step by more than `EQUAL_TIME_STEPS`."""
    if problem.rayleigh is None:
        return False
    smallest_step, largest_step = problem.rayleigh.limits(problem.intervals)
    return largest_step * (1 - EQUAL_TIME_STEPS) > smallest_step


def with_long_steps(problem: Problem, points: Array) -> Array:
    """Return the points with every parameter that changes the time step moved to maximise it."""
    moved = points.copy()
    if problem.rayleigh is None:
        return moved
    shortest, longest = problem.rayleigh.extremes(problem.intervals)
    fastest = problem.to_unit({**problem.middle, **longest})
    for axis, parameter in enumerate(problem.parameters):
        if shortest.get(parameter.name) != longest.get(parameter.name):
            moved[:, axis] = fastest[axis]
    return moved


def log_time_steps(problem: Problem, points: Array) -> Array:
    """Logarithms of the Rayleigh time steps at points of the unit cube, shape (m,)."""
    steps = (problem.rayleigh_time_step(problem.from_unit(point)) for point in points)
    return np.array([math.log(step or 1.0) for step in steps])


def handicaps(problem: Problem, points: Array) -> Array:
    """Rayleigh criterion of points on a logarithmic scale, shape (m,); 0 is the fastest.

    If several parameter sets agree equally well, it directs runs to the faster ones.
    """
    if problem.rayleigh is None or not time_step_matters(problem):
        return np.zeros(len(points))
    low, high = (math.log(limit) for limit in problem.rayleigh.limits(problem.intervals))
    return (high - log_time_steps(problem, points)) / (high - low)
