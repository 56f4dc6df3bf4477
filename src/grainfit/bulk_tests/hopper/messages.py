"""Messages to users about the options of a hopper."""

from grainfit.messages import Message

FILLED_TWICE = Message(
    "a mass of {mass:g} kg and a height of {height:g} m say twice how much is filled in.",
    "Leave one of them out.",
)
LITTLE_MASS = Message(
    "{mass:g} kg fill the vessel up to {height:g} m, which is lower than {fewest:g} of the largest "
    "particles ({largest:g} m).",
    "Fill in at least {least:.3g} kg.",
)
