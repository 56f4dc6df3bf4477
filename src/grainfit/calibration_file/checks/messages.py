"""Messages to users about values of a calibration file."""

from __future__ import annotations

from grainfit.messages import Message

UNUSUAL_DENSITY = Message(
    "{name} = {value:g} kg/m^3 is that of no solid.",
    'Write it with its unit, such as "{value:g} {unit}".',
)
UNUSUAL_DIAMETER = Message(
    "particle.diameter = {value:g} m is that of no particle in a laboratory.",
    'Write it with its unit, such as "10 mm".',
)
UNUSUAL_GRAVITY = Message(
    "Test {test}: gravity = {value:g} m/s^2 is that of no laboratory.",
    'Write it with its unit: "981 cm/s^2" is 9.81 m/s^2, that on Earth.',
)
SMALL_ANGLE = Message(
    "Test {name} = {value:g} deg is flatter than any bed.",
    'If it was measured in radians, write "{value:g} rad".',
)
STEEP_ANGLE = Message(
    "Test {name} = {value:g} deg is steeper than beds that flow.",
    "If it was measured from the vertical, it is {rest:g} deg.",
)
FINER_THAN_INSTRUMENTS = Message(
    "{name}: its tolerance, {tolerance}, is finer than instruments reach, about {finest}.",
    "Give as tolerance what is good enough for you, and the error of the instrument as "
    "uncertainty, or as systematic beside measurements.",
)
ASSUMED_SIZE = Message(
    "Test {test}: {vessel} is assumed, {size}. In trials with soft spheres, an apparatus that "
    "holds {times} times the particles moved {moved}.",
    "Give {vessel} of the laboratory; 'grainfit size' simulates it in several sizes.",
)
