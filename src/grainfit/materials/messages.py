"""Messages of materials: particle sizes, shapes, walls, and the tables that have them."""

from grainfit.messages import Message

# Columns of a sieve curve.
SEVERAL_MAY_BE = Message(
    "has the columns {names}, and more than one of them may be the {meaning}.",
    'Give one column the heading "{example}".',
)
NONE_IS = Message(
    "has the columns {names}, and none of them is the {meaning}.",
    'Give one column the heading "{example}".',
)
ONLY_RETAINED = Message(
    "has the columns {names}, and none of them is the {meaning}.",
    'Give one column the heading "{example}": 100 % minus all that this sieve and the coarser '
    "ones retain.",
)

# Particle sizes.
SAME_DIAMETER = Message("has the same diameter twice.", "Add up their mass fractions.")
SUM_OF_FRACTIONS = Message("mass fractions sum to {sum:.6g}.", "They must sum to 1 (or 100 %).")
SEVERAL_DISTRIBUTIONS = Message("has {given}.", "Keep one of them.")
UNIT_WITHOUT_CURVE = Message("is given without sieve_curve.", "Remove it.")
COARSE_GRAINING = Message(
    "is {factor!r}.", "Particles may be 1 to {largest:g} times as large as the real ones."
)
NUMBER_OF_FRACTIONS = Message("needs one mass fraction for every diameter.")
DIAMETERS_NOT_POSITIVE = Message("{given} must all be above 0.")
NO_MASS_FRACTIONS = Message("mass fractions {given} must be above 0 and sum to 1.")
LIMITS_SWAPPED = Message("{low} is not below largest, {high}.", "Swap them, or leave one out.")
NOTHING_LEFT = Message(
    "the limits leave {left} of the mass of the {distribution}.", "Leave 1 % at least."
)
INFINITE_SURFACE = Message(
    "the surface of the {distribution} is infinite.", "Leave the {end} out: {key} = ..."
)
IMPOSSIBLE_CLASS = Message(
    "a class of the {distribution} would have a diameter of {diameter:.3g} m.",
    "Leave the {end} out: {key} = ...",
)
OPEN_FINE_END = Message(
    "{share} of the mass pass the finest sieve, {opening}, and nothing says how fine they are.",
    "Add the size of the finest particles, which 0 % pass, or leave them out: "
    'smallest = "{limit:.9g} mm".',
)
OPEN_COARSE_END = Message(
    "only {share} of the mass pass the coarsest sieve, {opening}.",
    "Give percentages, and add the size of the coarsest particles, which 100 % pass; or leave "
    'them out: largest = "{limit:.9g} mm".',
)
NO_LOG_NORMAL = Message(
    "has {given}.", "Give median and geometric_standard_deviation, or d10 and d90."
)
PERCENTILES_SWAPPED = Message("{low} is not below d90, {high}.", "Swap them.")
MISSING = Message("is missing.", "Add it, for example: {name} = {example}")
NUMBER_OF_SIEVES = Message("{openings} openings and {shares} shares.", "Give two sieves or more.")
IMPOSSIBLE_OPENING = Message("has an opening of {opening:g} m.", "Openings are {limits}.")
IMPOSSIBLE_PASSING = Message("has a passing of {share}.", "Passing is from 0 to 100 %.")
NOT_SORTED = Message("does not have a larger opening than the one before.", "Sort them.")
FALLING_PASSING = Message(
    "has a passing of {share} at {opening}, below the {share_below} at {opening_below}.",
    "Give the cumulative passing, not what each sieve retains.",
)

# Particle shapes.
NO_SHAPE = Message(
    "is neither a family nor spheres.",
    "Use {families}, or {{ spheres = [{{ position = [0, 0, 0], radius = 1 }}, ...] }}.",
)
NO_FAMILY = Message(
    "{family!r} is no family.",
    "Use {families}, or {{ spheres = [{{ position = [0, 0, 0], radius = 1 }}, ...] }}.",
)
ASPECT_RATIO_OF_FAMILY = Message("is {ratio:g} for {family}.", "Use 1 (a sphere) to {largest:g}.")
NO_ASPECT_RATIO = Message(
    "has no effect on particles that are {what}.",
    'Leave it out, or give a family: particle.shape = "{family}".',
)
NUMBER_OF_SPHERES = Message("has {count} spheres.", "Use 2 to {most}; a sphere needs no shape.")
IMPOSSIBLE_SPHERE = Message("has places or radii that are impossible.", "Radii are above 0.")
SPHERE_TOO_SMALL = Message("has a sphere below {smallest:g} of the largest.", "Leave it out.")
SPHERE_INSIDE = Message(
    "has sphere {inner} inside sphere {outer}: it never touches anything.", "Leave it out."
)
SPHERE_APART = Message(
    "is no body: sphere {number} is apart from the first.", "Let them overlap, or touch."
)
NO_POSITION = Message("has {count} numbers.", "Write three: x, y and z.")

# Materials, walls, and the Rayleigh time step.
NO_STARTING_MATERIAL = Message(
    "{name!r} is no starting material.",
    "{instead} 'grainfit materials' lists all; 'grainfit ask' begins with ranges of the class.",
)
NEAR_MATERIALS = Message("Use one that is near: {names}. Typical of {title}: {ranges}.")
NOTHING_NEAR = Message("None is near; begin with one of its class.")
NONE_OF_CLASS = Message(
    "{words!r} is in no material of the class {name!r}.", "Leave one of them out."
)
LISTED = Message(
    "{number}. Published values, each with its source: 'grainfit materials NAME'. A file of "
    "one: 'grainfit new FILE --material NAME'."
)
NO_CLASS = Message("{name!r} is no class of materials.", "Use one of {known}.")
NEITHER_FIXED_NOR_FREE = Message(
    "is neither fixed nor free, and the Rayleigh time step needs it.",
    "Give its value in RayleighTimeStep, or make it a parameter.",
)
NEEDS_NO_SHAPE = Message(
    "is not free, so it needs no shape.",
    "Leave shape out: the radius is that of the smallest sphere.",
)
NO_VALUE = Message("is None.", "Give a number, or a quantity with its unit.")
NO_TIME_STEP = Message("is {shown}.", "The Rayleigh time step needs numbers {wanted}.")
ANGLE_WITHOUT_UNCERTAINTY = Message("is 0.", "Leave it out, and the value is fixed.")
NO_ANGLE = Message("is {given}.", "An angle must be at least 0, and below {steepest:g} degrees.")
