"""Messages to users about the options of a compression test."""

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
EMPTY_POT = Message("no particles are left in the pot")
PISTON_OUT = Message(
    "the piston left the pot's bed: it stands {height:.3g} m above the floor of a pot that was "
    "filled up to {filled:g} m"
)
FEW_RECORDS = Message(
    "{modulus}: the stress was recorded only {count} times between {low:.0%} and {high:.0%} of "
    "{stress:g} Pa; use a lower piston_speed."
)
NO_RISE = Message("{modulus}: stress does not rise with strain.")
