"""Messages of measurements: why a quantity cannot be measured, and what is wrong with a dump."""

from grainfit.messages import Message

# Heaps.

NOT_ON_PLATE = Message("angle of repose: none of {count} particles is left on the plate.")
NO_ANGLE = Message("angle of repose: {reason}")
NO_HEAP = Message(
    "there is no heap: it is {height:.1f} particle diameters high; flanks need at least "
    "{needed:.1f}."
)
ONE_SIDED_HEAP = Message(
    "the heap lies on one side: its centroid is {offset:.1f} particle diameters off the axis, at a "
    "base radius of {base:.1f}."
)
COLUMN_OR_LAYER = Message(
    "it has no flanks: {height:.1f} particle diameters high, its sides are steps (a column that "
    "stands, or a layer that ends at the plate's edge)."
)
FEW_FLANKS = Message(
    "only {found} of {count} flanks can be measured (without gaps, and inclined by {low:g} to "
    "{high:g} degrees); a heap needs {percent:g} %."
)
FLANKS_DISAGREE = Message(
    "the flanks disagree: they are inclined by {low:.0f} to {high:.0f} degrees, so this is no heap "
    "about the axis."
)
TWO_SLOPES = Message(
    "the flanks have two slopes, {upper:.0f} degrees above and {lower:.0f} degrees below, so this "
    "is no cone; use a test that suits cohesive materials, such as shear at two stresses."
)
NO_BASE = Message("base radius: nothing is higher than {ground:g} m.")
BLANK = Message("{quantity}: the silhouettes are blank.")

# Surfaces.

LOW_PILE = Message("it is {height:.1f} particle diameters high; flanks need at least {needed:g}.")
FLANK_INCLINATION = Message(
    "a flank is inclined by {angle:.0f} degrees; flanks are inclined by {low:g} to {high:g} "
    "degrees."
)
STEPS = Message("it has no flanks: {height:.1f} particle diameters high, its sides are steps.")
FEW_AVALANCHES = Message(
    "there are {found} whole avalanches in the averaged turns, and {needed} are needed for a "
    "standard error; use larger averaged_turns"
)
SHORT_SURFACE = Message("surface: it is too short to be fitted; use a larger drum")
LARGE_GRID = Message(
    "{quantity}: it would take a grid of {cells} cells, and at most {most} are possible. Some "
    "particles are too large, too small or too far away for the others: the simulation went "
    "astray, or the dump is not in SI units."
)

# Densities, flows and yield loci.

NO_VOLUME = Message("nothing between heights {bottom:g} and {top:g} m.")
EMPTY_CONTAINER = Message("bulk density: there is no particle in the {container}.")
NOT_FULL = Message(
    "bulk density: the bed does not fill the {container} from {bottom:g} to {top:g} m all around "
    "(its highest particle reaches {highest:.4g} m);",
    "fill in more particles or measure lower.",
)
NO_FLOW = Message("mass flow: no mass has left the container.")
SHORT_FLOW = Message(
    "mass flow: it is over within {records} records; {needed} are needed.",
    "Fill in more particles or use a narrower orifice.",
)
FEW_RECORDS = Message("mass flow: the mass over time has fewer than two records.")
TWO_STRESSES = Message("needs an angle for each of two or more different normal stresses")
NO_ERRORS = Message("needs normal stresses and standard errors above zero")

# Dumps.

UNREADABLE = Message("{path}: cannot be read ({reason}).")
BAD_FRAME = Message("{path}: frame at line {line}: {error}")
NO_DUMP = Message("is not a text dump of LAMMPS or LIGGGHTS (no 'ITEM: TIMESTEP' in it).")
NO_ATOMS = Message("is truncated: no 'ITEM: ATOMS' in its last frame.")
NO_COUNT = Message("is truncated: no 'ITEM: NUMBER OF ATOMS' in its last frame.")
BAD_COUNT = Message("the number of atoms {count!r} is not a whole number.")
NO_COLUMNS = Message(
    "line {line} lacks the column(s) {names};", "dump 'id type x y z radius mass'."
)
TRUNCATED = Message(
    "is truncated or damaged: its last frame announces {count} particles and has {lines} lines of "
    "them."
)
NO_LINE_END = Message("is truncated: its last line has no end.")
FEW_VALUES = Message("line {line} has {values} values for {columns} columns.")
NO_NUMBER = Message("holds something that is not a number: {error}.")
DIFFERENT_LENGTHS = Message(
    "particles: {positions} positions, {radii} radii and {masses} masses do not belong together."
)
IMPOSSIBLE = Message(
    "particles: {wrong} of {count} have an impossible {name} (number {first}: {value}); the "
    "simulation went astray."
)
