"""Messages of the calibration file: cheaper relatives of its tests."""

from __future__ import annotations

from grainfit.messages import Message

NO_TEST_HAS_RELATIVES = Message(
    "needs a bulk test.", "An own model has no softer, larger or fewer particles."
)
FREE_MODULUS = Message(
    "needs a fixed particle.youngs_modulus.", "A free one is part of the search: leave this out."
)
GIVEN_STIFFNESS = Message(
    "has no effect: {name} is given, and Young's modulus changes no contact.",
    "Leave it out, or leave the stiffness of the springs out.",
)
NOT_SOFTER = Message(
    "is not below particle.youngs_modulus, {modulus} MPa.",
    "Give about a twentieth of it, or leave it out.",
)
OWN_SCENE_HAS_NO_SIZE = Message(
    "cannot change test {test}, whose scene is a function of yours.",
    "Leave it out, or give softer.",
)
NO_SUCH_RELATIVE = Message(
    "makes test {test} impossible: {why}", "Give a value nearer to 1, or leave it out."
)
