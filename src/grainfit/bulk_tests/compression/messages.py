"""Messages to users about the options of a compression test."""

from __future__ import annotations

from grainfit.messages import Message

BED_IS_HEAVY = Message(
    "{stress:g} Pa is not much more than the bed's own weight of about {weight:.3g} Pa "
    "(particle.density {density:g} kg/m^3).",
    "Use at least {least:.2g} Pa, or a lower strike_off_height.",
)
BED_IS_SHALLOW = Message(
    "a bed of {height:g} m is less than {fewest:g} of the largest particles ({largest:g} m) deep.",
    "Use at least {lowest:g} m.",
)
NO_CURVE = Message(
    "{seating:g} Pa leaves no curve between it and the stress of {stress:g} Pa.",
    "Use about {usual:g} Pa (the default).",
)
