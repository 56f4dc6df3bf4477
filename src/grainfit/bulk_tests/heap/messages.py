"""Messages to users about the options of a heap test."""

from grainfit.messages import Message

PLATE_IS_NARROW = Message(
    "a plate of {plate_radius:g} m radius does not carry a cylinder of "
    "{cylinder_radius:g} m radius.",
    "Make the plate wider or the cylinder narrower.",
)
NOTHING_TO_MEASURE = Message(
    "between {bulk_density_bottom:g} m and {bulk_density_top:g} m there is less than one "
    "particle diameter to measure the bulk density in.",
)
MEASURED_ABOVE_BED = Message(
    "{bulk_density_top:g} m is above the strike-off height {strike_off_height:g} m.",
    "Measure lower or strike off higher.",
)
RIM_ABOVE_BED = Message(
    "{rim_height:g} m is not below the strike-off height {strike_off_height:g} m.",
)
LIFT_IS_SHORT = Message(
    "{lift_height:g} m leaves the cylinder in the heap.",
    "Use about the strike-off height, {strike_off_height:g} m.",
)
FAST_LIFT = Message(
    "a lift_speed of {lift_speed:g} m/s is {speed:.2g} sqrt(g d). Above {fastest:g} the column "
    "collapses rather than flows out, and the angle is several degrees lower.",
    "Keep it only if the laboratory lifts as fast; the default is {usual:.3g} m/s.",
)
CLINGING = Message(
    "angle of repose: {percent:.0f} % of the particles cling to the lifted cylinder, so that "
    "the heap is not that of the bed; use a wider cylinder, or less cohesion on walls."
)
