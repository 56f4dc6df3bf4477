"""Messages to users about the options of a rotating drum."""

from grainfit.messages import Message

DRUM_IS_NARROW = Message(
    "a drum of {drum_radius:g} m radius is narrower than {fewest:g} of the largest "
    "particles ({largest:g} m).",
    "Use at least {least:g} m.",
)
DRUM_IS_SHORT = Message(
    "a length of {drum_length:g} m is less than {fewest:g} of the largest particles "
    "({largest:g} m).",
    "Use at least {length:g} m.",
)
SPEED_GIVEN_TWICE = Message(
    "{froude_number:g} is given beside the rotational_speed {rotational_speed}.",
    "Give one of them.",
)
TOO_FAST = Message(
    "{rotational_speed} is a Froude number of {froude:.3g}. Above {fastest:g} particles "
    "fly, and the surface has no one angle.",
    "Use at most {slowest}; the default is a Froude number of {usual:g}.",
)
FAST_DRUM = Message(
    "the Froude number is {froude:.2g}. Above {fastest:g} the bed cascades: its surface is bent to "
    "an S, and the dynamic angle is that of its centre of mass.",
    "Compare it with an angle that the laboratory measured in the same way, or turn slower.",
)
SOFT_DRUM = Message(
    "particles of {number} \u03c1 g d are soft: the dynamic angle of rough spheres is about "
    "{less:.1f} degrees below that of stiff ones, and fitted frictions make up for it.",
    "It is less than {told:g} degrees with {enough} MPa.",
)
NO_ROOM = Message(
    "{fill_level:g} leaves no room to place {particle_count} particles at random.",
    "Use at most {highest:g}, or a larger drum.",
)
NO_END_CAPS = Message(
    "the caps are of {wall}, and the drum has none: it repeats along its axis.",
    "Give end_caps = true, or leave caps out of walls.",
)
COARSE_CAPS = Message(
    "end caps carry larger particles up more: with a coarse_graining of {factor:g} the dynamic "
    "angle is about {more:.1f} degrees above what real particles have by the caps alone, and "
    "fitted frictions make up for it.",
    "It is less than {told:g} degrees with a coarse_graining of {largest}.",
)
CARRIED_ROUND = Message(
    "the drum carries the particles round: {percent:.0f} % of them are above the ends of the "
    "bed, which has no surface then; use a lower rotational_speed"
)
BED_SLIDES = Message(
    "the bed slides in the drum: its outermost layer is {percent:.0f} % slower than the wall, "
    "and {allowed:.0f} % are allowed; line the drum (lining = true), or use a larger friction "
    "between particles and wall"
)
NOT_STEADY = Message(
    "the bed is not steady: its inclination changes by {change:.1f} degrees from the first to "
    "the second half of the averaged turns; use larger discarded_turns"
)
FEW_FRAMES = Message(
    "the bed was recorded {count} times while the drum turned; {fewest} times are needed"
)
PARTICLES_LOST = Message(
    "particles were lost while the drum turned: {first} at first, {last} at the end"
)
NONE_AT_WALL = Message(
    "wall slip: no particles are at the wall of the drum deep below the surface; use a larger "
    "drum or fill_level"
)
NO_STAGE = Message("{folder} has no stage that ended")
