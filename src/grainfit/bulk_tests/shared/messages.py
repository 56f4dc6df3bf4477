"""Messages to users about the containers of bulk tests."""

from grainfit.messages import Message

BETWEEN_HEIGHTS = Message(
    "between {bottom:g} m and {top:g} m there is less than one particle diameter to "
    "measure the bulk density in.",
    "Measure higher, or use a larger fill_height.",
)
ABOVE_SETTLED_BED = Message(
    "{top:g} m is higher than a bed of {height:g} m settles.",
    "Measure up to {highest:g} m at most, or use a larger fill_height.",
)
CYLINDER_IS_NARROW = Message(
    "a cylinder of {radius:g} m radius is narrower than {fewest:g} of the largest "
    "particles ({largest:g} m).",
    "Use a radius of at least {least:g} m.",
)
TOO_MANY_PARTICLES = Message(
    "{count} particles are more than {most} ({container}).",
    "Use particles at least {factor:g} times as large (particle.coarse_graining), or a smaller "
    "container.",
)
NOT_FILLED = Message(
    "{count} particles do not fill the cylinder up to the strike-off height {strike_off:g} m.",
    "Use {needed} (the default) or a lower strike-off height.",
)
NO_PARTICLE_PASSES = Message(
    "no particle of {largest:g} m passes {opening} of {width:g} m.",
    "Arches may block {opening} of less than {arches:g} diameters ({least:g} m).",
)
ENLARGED_PARTICLES_ARCH = Message(
    "{opening} of {width:g} m is {times} times as wide as the largest simulated "
    "particles ({largest:.4g} m): they arch below {arches:g}.",
    "{way_out}, or {least}.",
)
ORIFICE_IS_WIDE = Message(
    "an orifice of {width:g} m is not narrower than the container of {diameter:g} m.",
    "Make the orifice smaller or the container wider.",
)
SLOPE_IS_FLAT = Message(
    "{half_angle:g} deg from the vertical is a slope that is nearly flat.",
    "Use {flattest:g} deg at most, or {flat:g} deg for a flat floor.",
)
SLOT_IS_WIDE = Message(
    "a slot of {slot_width:g} m is not narrower than the box of {width:g} m.",
    "Make the slot narrower or the box wider.",
)
BOX_IS_SHORT = Message(
    "a depth of {depth:g} m repeats after less than {fewest:g} of the largest particles "
    "({largest:g} m).",
    "Use at least {least:g} m.",
)
CONTAINER_IS_NARROW = Message(
    "{width:g} m is narrower than {fewest:g} of the largest particles ({largest:g} m).",
    "Use at least {least:g} m.",
)
BED_IS_LOW = Message(
    "a bed of {fill_height:g} m is lower than {fewest:g} of the largest particles "
    "({largest:g} m): its bulk density cannot be measured.",
    "Use at least {least:g} m.",
)
TOO_SOFT = Message(
    "{stress:g} Pa is too much for a Young's modulus of {modulus:g} Pa: E / stress is "
    "{ratio:.3g}, and below {smallest:g} overlaps of the particles {otherwise}",
    "Use a Young's modulus of at least {least:g} Pa, or a stress of at most {most:g} Pa.",
)
FLOW_DEPTH = Message(
    "mass_flow is that through the whole simulated depth of {depth}, which is assumed: the file "
    "gives no depth.",
    "Multiply the measured flow by {depth} over the depth of the slot in the laboratory, or give "
    "depth; the flow of another depth would be taken for another density.",
)
UNUSUAL_FLOW = Message(
    "mass_flow = {measured:.3g} kg/s is {times:.2g} times what Beverloo's law gives for this "
    "opening, {expected:.2g} kg/s.",
    "Compare units, opening and depth with those of the laboratory.",
)
NARROW_CYLINDER = Message(
    "the cylinder is {radius:.2g} Sauter diameters in radius. Below {least:g} walls loosen the bed "
    "and arches hold it: beads in one of 3 were 3 % lighter, and a heap of them 4 degrees flatter.",
    "Use {option} = {usual} or more if that of the laboratory is as wide.",
)
SMOOTH_PLATE = Message(
    "the {kind} friction of the plate is {value:g} ({key}). Below {least:g} heaps slide or roll "
    "apart, and runs may fail.",
    "If the plate of the laboratory is rough, give {option}.",
)
NO_HEAP_ON_PLATE = Message(
    "{reason} On a smooth plate heaps slide apart.",
    "If the plate of the laboratory is rough, give plate_sliding_friction and "
    "plate_rolling_friction.",
)
ASSUMED_PLATE = Message(
    "the {kind} friction of the plate is not given, so it is that of the walls, {value:.3g}. Heaps "
    "spread on it: beads of 21.6 degrees on a rough plate had 17.6 at a sliding friction of 0.27, "
    "13.7 at a rolling friction of 0.05, and 10.8 with both.",
    "If the plate of the laboratory is rougher, give {option}.",
)
SMALL_PLATE = Message(
    "the plate of {plate} radius is too small for {needed}: the measured heap has a base radius of "
    "about {radius}, and a run whose heap reaches the edge fails.",
    'Use plate_radius = "{least}" or more.',
)
BASE_OF_DISC = Message(
    "the measured base radius is {radius}, but a heap on a disc ends at its edge, at {disc}: no "
    "run meets the target.",
    "Leave base_radius out, as it tells nothing of the material; or correct it, or plate_radius.",
)
NOT_COVERED = Message(
    "the heap does not cover the disc: its base radius is {base:.1f} particle diameters, that of "
    "the disc {disc:.1f}.",
    "Pour more, or use a smaller disc.",
)
EMPTY_CONTAINER = Message("no particles are left in the container")
OVERLAP = Message(
    "the particles overlap grossly, by {percent:.0f} % of their diameter on average: Young's "
    "modulus is too small for this load"
)
STRESS_NOT_HELD = Message(
    "the stress was not held in the {stage} stage: {stress:.4g} Pa instead of {wanted:g} Pa at "
    "its end"
)
BLOCKED = Message("{arch}; use a wider {orifice}")
CHOKED = Message(
    "the heap chokes the slot: its apex is {found:.1f} particle diameters below the shelf, and "
    "must be {needed:.1f}; use a larger floor_distance"
)
FOOT_OFF_FLOOR = Message(
    "the foot of the heap is not on the floor: {percent:.1f} % of it has left over the edges; "
    "use a larger floor_half_width, or a larger floor_rolling_friction if the floor of the "
    "laboratory is rough"
)
MAY_ARCH = Message(
    "{opening} of {width} is {times} times as wide as the largest particles ({largest}). Below "
    "{arches:g} they may arch, and nothing flows."
)
SURPLUS_PARTICLES = Message(
    "particle_count = {given}, but {needed} fill it up to strike_off_height ({height}); the rest "
    "is cut off there, before anything is measured.",
    "Leave particle_count out, or raise strike_off_height.",
)
