"""Messages of scenes: what a scene cannot be, and what a run that left its files cannot have."""

from grainfit.messages import Message

_SMALLER_STEP = "a smaller time_step_fraction or more dissipative contacts may help"
_SCALE = "scale is the number of m in a unit of the file: 0.001 for mm."

# Numbers and places of a scene.

NOT_ABOVE_ZERO = Message("is {value!r}.", "Give a number above 0.")
NO_LENGTH = Message("is {value!r}.", "Give a length above 0, in m.")
NO_GRAVITY = Message("is {value!r}.", "Give a number in m/s^2, at least 0.")
NO_NUMBER = Message("has {name} = {value!r}.", "Give {wanted}.")
BOX_CORNERS = Message("has the corners {low!r} and {high!r}.", "Give three numbers each, m.")
BOX_SIDES = Message("goes from {low!r} to {high!r} along {axis}.", "low is below high.")
BOX_PERIODS = Message("is periodic along {axes!r}.", 'Write axes, such as "y".')
SHORT_PERIOD = Message(
    "repeats along {axis} every {period:.3g} m, which is less than two diameters of the largest "
    "particles ({diameter:.3g} m).",
    "Use a longer period; five diameters are usual.",
)
NEGATIVE_SEED = Message("{seed} is negative.", "Use 0 or a positive number.")
NO_WHOLE_NUMBER = Message("is {given!r}.", "Give a whole number.")

# Particles.

POSITIONS = Message(
    "positions have the shape {shape} for {count} particles, or are no numbers.",
    "Give one place for each particle.",
)
SIZE_INDICES = Message(
    "size_indices go from {low} to {high}.", "Use 0 to {last}, one for each diameter."
)
VELOCITIES = Message("velocities are not one for each particle.", "Give (n, 3) of them.")
OUTSIDE = Message(
    "{outside} of {count} begin outside of the box, the first at {first} m.",
    "Make the box larger, or move them.",
)
OVERLAPS = Message(
    "{pairs} pairs overlap at the beginning, and would burst apart.",
    "Use random_column(), or place them farther apart.",
)
IN_WALL = Message(
    "{caught} of {count} particles begin in it or behind it, the first at {first} m.",
    "Move the particles or the wall: each begins on its right side, at least a radius away.",
)
SPHERES_TURN = Message(
    "have {name}, and are spheres.",
    "Leave them out: spheres look the same from all sides, and begin without spin.",
)
ONE_FOR_EACH_CLUMP = Message(
    "{name} are not one for each clump.", "Give ({count}, {width}) of them."
)
TOO_MANY_PARTICLES = Message(
    "a column of {count} particles is impossible: 1 to {most} are accepted.",
    "Check the lengths that the number follows from, and their units.",
)
NARROW_CONTAINER = Message(
    "a container of {area:.3g} m^2 is narrower than a particle of {diameter:.3g} m.",
    "Use a wider container, or smaller particles.",
)
NO_ROOM = Message(
    "{count} particles find no room in a tube of {radius:g} m radius.",
    "Use fewer, or a larger tube.",
)
GLUED_POSITIONS = Message("has positions that are no numbers.", "Give finite numbers, m.")
GLUED_OUTSIDE = Message(
    "begins outside of the box with {count} particles, the first at {first} m.",
    "Make the box larger, or move them.",
)
GLUED_COUNT = Message("{count} sizes and positions of shape {shape}")

# Walls.

NO_NUMBERS = Message("{shape!r} has lengths that are no numbers.", "Give finite numbers, m.")
WALL_AXIS = Message("has the axis {axis!r}.", "Use x, y or z.")
BLOCK_SIDES = Message("goes from {low} to {high}.", "low is below high.")
PRISM_PERIOD = Message(
    "is a prism, whose slope does not repeat in a box that is periodic in {axes!r}.",
    "Use a box that is periodic in y alone.",
)
ACROSS_PERIOD = Message(
    "is a plane across {axis}, along which the box repeats: all is on both sides of it.",
    "Leave the plane out, or use a box that does not repeat along {axis}.",
)
BEYOND_PERIOD = Message(
    "goes beyond the box along {axis}, and does not repeat with it.",
    "Use a larger box or a smaller wall; blocks and prisms go on through the sides.",
)
WALL_ENDS = Message("goes from {bottom} up to {top} m.", "bottom is below top.")
NO_RADIUS = Message("{shape!r} has no radius above 0.", "Give one in m.")
NO_SURFACE = Message(
    "has the surface {surface!r}, which the scene does not have.", "Surfaces: {known}."
)
SURFACE_PARAMETER = Message("has {name!r}, which is no parameter of walls.", "Use {known}.")
SURFACE_VALUE = Message("has {name} = {value!r}.", "Give a finite number.")

# Stages.

NO_STAGES = Message("are missing.", "Give at least one Stage.")
NOT_A_WORD = Message(
    "{name!r} is not one word.", "Use letters, digits and underscores, a letter first."
)
TAKEN_NAME = Message("{name!r} has another meaning in decks.", "Use another name.")
NAME_TWICE = Message("{name!r} is there twice.", "Give each a name of its own.")
NO_WALL = Message("{does} the wall {name!r}, which is not there.", "Walls of that stage: {known}.")
NO_TIME = Message("has the {name} {value!r}.", "Give a time in s, above 0.")
NO_FIRST_LOOK = Message("looks after {value!r} s first.", "Give a time in s, 0 or more.")
NO_SHARE = Message("ends with {value!r} of the mass.", "Give a share above 0 and up to 1.")
NO_FRAME_INTERVAL = Message("has frames every {value!r} s.", "Give a time above 0.")
NO_RECORD_INTERVAL = Message("records every {value!r} s.", "Give a time above 0.")
RECORD_AXIS = Message("records {column} along {axis!r}.", "Use x, y or z.")
TRAVEL_WITHOUT_AXIS = Message(
    "records the travel of {name!r} along no axis.", 'Name the axis: Travel("plate", "z").'
)
ENDS_AT_ONCE = Message(
    "ends at rest: a bed that is at rest when it begins ends it at once.",
    "Give the condition an at_least, s.",
)
NOT_CLEARED = Message(
    "ends when {wall!r} is clear, which is no upright Cylinder.",
    "Clear is for lifted tubes: name a wall that is an upright Cylinder.",
)
NOT_LOADED = Message(
    "ends when {wall!r} is loaded, but puts no load on it.",
    "Give the wall a Load among the motions of the stage.",
)
MOTION_AXIS = Message("moves {name} along {axis!r}.", "Use x, y or z.")
MOTION_NUMBERS = Message("moves {name} by {motion!r}.", "Give finite numbers.")
NO_AREA = Message(
    "loads {name!r} across {low!r} and {high!r}, which are no two planes of one axis.",
    "Name two parallel walls of the shape Plane, the lower one first.",
)
NO_TURN = Message("turns with a speed of 0.", "Give it no rotation then.")
TURNS_AND_MOVES = Message(
    "turns about an axis, and moves in another way.",
    "Let it turn about one axis in all stages, and move something else.",
)
SEVERAL_MOTIONS = Message(
    "moves the wall {name!r} by {count} motions.",
    "Give it one motion in each stage; only a glued set has several.",
)
MOVED_TWICE = Message("moves {name!r} twice along one axis.", "Give it one motion along each axis.")
TWO_LOADS = Message(
    "puts two loads on {name!r}.",
    "Give it one load; a velocity of 0 holds it along another axis.",
)

# Walls from STL files.

MESH_TOO_LARGE = Message("cannot be read: {reason}.", "Simplify the mesh.")
MESH_UNREADABLE = Message("cannot be read: {reason}.", "Give the path of an STL file.")
MESH_EMPTY = Message("has no triangle.", "Export the wall's surface as STL.")
MESH_TOO_FINE = Message(
    "has {count} triangles; at most {most} are possible.",
    "Export it coarser: facets half a particle wide are enough.",
)
MESH_CORNERS = Message("has corners that are no numbers.", "It is damaged: export it again.")
MESH_FLAT = Message("has no triangle with an area.", "Export the wall's surface as STL.")
MESH_NO_STL = Message("is no STL file.", "Export the wall as STL, text or binary.")
MESH_CUT_OFF = Message(
    "is no STL file, or is cut off: its header announces {count} triangles.",
    "Export the wall as STL, text or binary.",
)
MESH_DAMAGED = Message("is a damaged text STL: a facet has not three corners.", "Export it again.")
MESH_PERIOD = Message(
    "needs too many triangles, each shorter than a quarter of the period.",
    "Use a longer period, or a smaller mesh.",
)
MESH_SCALE = Message("has the scale {scale!r}.", "Give m per unit of the file: 0.001.")
MESH_SIZE = Message(
    "{name} is {size:.4g} m large in a box of {room:.4g} m.",
    f"Is it in another unit? {_SCALE}",
)
MESH_ELSEWHERE = Message("{name} lies outside of the box.", f"Move it. {_SCALE}")
MESH_BEYOND = Message("{name} goes beyond the box along {axis}.", "Make the box larger.")
MESH_BEYOND_PERIOD = Message(
    "{name} goes beyond the box along {axis}.", "Cut it there: it repeats with the box."
)

# Files of a run.

UNREADABLE = Message("{path}: cannot be read ({error}).")
NO_FRAME = Message("{path}: has no complete frame.")
BAD_FRAME = Message("{path}: time step {step}: {error}")
NO_OUTPUT = Message("the run has no {kind} '{name}'. It has: {known}.")
NO_COLUMNS = Message("has no columns")
NO_COLUMN = Message("has no column {names}")
NO_LINE_END = Message("its last line has no end")
NO_STAGES_FILE = Message(
    "{path} is missing: the simulation did not begin, or was made by version 0.1.0, whose dumps "
    "can be measured one by one."
)
OTHER_HEADER = Message("{path}: does not begin with {header}.")
DAMAGED = Message("{path}: is damaged ({error}).")
NOT_FINITE = Message("{path}: has values that are no numbers.")

# Runs that went wrong.

ENDED_EARLY = Message("the simulation ended early (stages done: {stages})")
NOT_FINITE_ENERGY = Message(
    "the simulation became unstable in the {stage} stage (kinetic energy {energy:.3g} J):",
    _SMALLER_STEP,
)
RESTLESS = Message(
    "the bed did not come to rest in the {stage} stage within {time:.3g} s of simulated time "
    "(kinetic energy {energy:.3g} J):",
    "see what moves with 'grainfit simulate --animate'; more rolling friction of the walls, a "
    "longer settling_time_limit, more dissipative contacts or a smaller time_step_fraction may "
    "help",
)
UNLOADED = Message(
    "the load was not reached and held by a bed at rest in the {stage} stage within {time:.3g} s "
    "of simulated time:",
    _SMALLER_STEP,
)
UNSTABLE = Message(
    "the simulation became unstable in the {stage} stage (kinetic energy {energy:.3g} J, more than "
    "gravity can give):",
    _SMALLER_STEP,
)
BROKEN = Message(
    "the simulation became unstable in the {stage} stage: {left} broke out of the {container}:",
    _SMALLER_STEP,
)
LEFT = Message(
    "{left} left the box in the {stage} stage, which is closed:",
    "no wall held them, or they are too soft for the speed of their fall; see where with 'grainfit "
    "preview' and 'grainfit simulate --animate'",
)
