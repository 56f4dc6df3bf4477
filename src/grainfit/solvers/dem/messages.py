"""Texts of the DEM programs for the user."""

from grainfit.messages import Message

# --- programs ------------------------------------------------------------------------------------

TOO_FEW_RANKS = Message("{ranks} must be at least 1.")
CLUMPS_ON_ONE_CORE = Message(
    "LIGGGHTS-PUBLIC moves clumps on one core, not on {ranks}.", "Leave it out, or use LAMMPS."
)
YADE_ON_ONE_CORE = Message(
    "YADE runs on one core here, not on {ranks}: with threads, two runs of one seed differ.",
    "Leave it out; several runs go at a time.",
)
NOT_FOUND = Message("{title} ({program}) is not found.", "{install}")
NOT_FOUND_ON_WINDOWS = Message(
    "{title} ({program}) is not found.",
    'On Windows, run it in the container: docker run --rm -v "${{PWD}}:/work" grainfit run FILE',
)
DOES_NOT_RUN = Message("{program} does not run: {error}.", "{install}")
IS_ANOTHER_PROGRAM = Message("{program} does not run as {title} does.", "{install}")
WITHOUT_GRANULAR = Message(
    "{program} was built without the GRANULAR package, which the decks need.", "{install}"
)
NO_LAUNCHER_BESIDE = Message(
    "{ranks} MPI ranks need an mpiexec next to {program}, and there is none.", "{install}"
)
NO_LAUNCHER = Message(
    "{ranks} MPI ranks need mpiexec, which is not found.",
    "Install it with: apt-get install openmpi-bin",
)
FOUND = Message("{solver} is found; the first run asks it for its version.")
LACKS_CONCEPT = Message("{solver} cannot simulate this {test} test.", "{reason}.")

# --- materials -----------------------------------------------------------------------------------

NO_VALUE = Message("has no value.")
NO_PARAMETER = Message("is not a material parameter.", "Use one of {known}.")
OUTSIDE_LIMITS = Message("{value:g} is outside {lowest:g} to {highest:g}{unit}.")
NO_ROLLING_DAMPING = Message(
    "{value:g} is above 0, and YADE has no rolling damping.",
    'Set it to 0 for solver = "yade", or use LAMMPS or LIGGGHTS.',
)
RESTITUTION_REFUSED = Message(
    "{value:g} is refused by LIGGGHTS.", "Use a restitution above {limit:g}, or LAMMPS."
)

EMPTY_BOX_PRESSED = Message(
    "All particles have left the box, and LIGGGHTS cannot press on nothing in the stage "
    "{stage!r}. LAMMPS and YADE can."
)

# --- runs that are continued ---------------------------------------------------------------------

CONTINUED = Message("continues at time step {step} of the stage {stage!r}, from {file}")
UNUSABLE_RESTART = Message("{file} cannot be used: {reason}")
OTHER_DECK = Message("starts anew: the restart files are of another deck")
NO_RESTARTS = Message("starts anew after a kill: {why}")
NO_RESTARTS_OF_SOLVER = Message("grainfit has no restart files for {solver}")
NO_RESTARTS_OF = Message("{solver} does not continue {what} exactly")

# --- walls and scenes ----------------------------------------------------------------------------

WALL_OF_NOTHING = Message(
    "do not say what {name!r} is made of.",
    'Write walls = {{ {name} = "..." }}, or give a plain [wall].',
)
NO_PART = Message("is no part of the test.", "{remedy}")
FRICTION_TWICE = Message(
    "is given, but the {part} is of the wall {wall}, which has a friction of its own.",
    "Leave it out, or give the part another wall.",
)
PERIOD_TOO_SHORT = Message(
    "is {length:g} m along a periodic axis, which is too short for YADE.",
    "Use at least {least:g} m.",
)
NO_UPRIGHT_TUBE = Message(
    "is no upright tube: YADE knows of no other wall the force away from the z axis.",
    "Use a Cylinder about the z axis.",
)
RADIAL_FORCE_OF_MESH = Message(
    "is a mesh in LIGGGHTS, whose radial force it does not know.",
    "Use a cylinder from the bottom to the top of the box.",
)

# --- cards ---------------------------------------------------------------------------------------

CALIBRATED_HERE = Message("The values were calibrated with {solver} and this contact model.")
CALIBRATED_ALIKE = Message(
    "The values were calibrated with {solvers}, which agrees without a rolling dashpot."
)
CALIBRATED_DIFFERENTLY = Message(
    "CHECK: the values were calibrated with {solvers}. {difference}",
    "Repeat the bulk test before you rely on them.",
)
CALIBRATED_ELSEWHERE = Message(
    "CHECK: the values were calibrated with a custom model and hold for its contact model. This "
    "card has the contact model of grainfit's own tests.",
    "Check that they are the same.",
)
NOT_ON_CARD = Message("is {value:g}, which no card for {solver} can hold.", "{limits}")
CARD_NEEDS = Message(
    "a card for {solver} needs {missing}, which this calibration does not have.",
    "Give them in the calibration file and run it again, or use the format json or csv and insert "
    "the values in your model.",
)
LONG_TIME_STEP = Message(
    "{share:g} of the Rayleigh time step is too long for the linear springs, whose collision time "
    "decides: beds would come to rest too dense without any error.",
    "Give at most {safe:g}.",
)
