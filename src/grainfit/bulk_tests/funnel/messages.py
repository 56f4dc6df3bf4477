"""Messages to users about a funnel, and about the heap below it."""

from grainfit.messages import Message

FUNNEL_IS_NARROW = Message(
    "a funnel of {radius:g} m radius is not wider than its outlet of {outlet:g} m diameter.",
    "Use a radius of at least {least:g} m, or a narrower outlet.",
)
LITTLE_IS_POURED = Message(
    "{volume:.3g} m^3 are {count} particles: too few for a heap with flanks.",
    "Pour at least {least:.3g} m^3.",
)
DISC_IS_LARGE = Message(
    "{volume:.3g} m^3 do not cover a disc of {radius:g} m radius with a heap of {angle:g} degrees.",
    "Pour at least {least:.3g} m^3, or use a smaller disc.",
)
OUTLET_IS_LOW = Message(
    "an outlet {height:g} m above the plate is lower than {fewest:g} of the largest particles "
    "({largest:g} m).",
    "Use at least {least:g} m.",
)
FUNNEL_IN_HEAP = Message(
    "the measured heap is about {apex} high, and the outlet is {height} above the plate: the heap "
    "reaches the funnel, and such a run fails.",
    'Use funnel_height = "{least}" or more, or give raise_speed.',
)
HEAP_AT_FUNNEL = Message(
    "the heap has grown into the funnel: its apex is {apex:.1f} particle diameters above the "
    "plate, the outlet {outlet:.1f}.",
    "Use a larger funnel_height, a raise_speed, or pour less.",
)
STILL_IN_FUNNEL = Message(
    "{arch}: {percent:.0f} % of the particles are still in the funnel.",
    "Use a wider outlet.",
)
FLAT_TOP = Message(
    "{reason} Below a funnel the top is flat, too, where particles fall far or the stream is wide.",
    "Use a lower funnel_height, a narrower outlet, or pour more.",
)
