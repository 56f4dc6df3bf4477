"""Messages of work folders: tables of runs, and what is kept of a calibration."""

from grainfit.messages import Message

# Tables of runs.
CURVE = Message(
    "is a curve, and a table of runs holds single numbers only.",
    "A work folder holds curves: give the one that the runs are in.",
)
CURVE_BESIDE_NUMBERS = Message(
    "is a curve, and a table of runs holds single numbers only.",
    "A work folder holds curves: give the one that the runs are in, or leave the curve out of the "
    "targets of test {test!r}.",
)
OTHER_MATERIAL = Message(
    "is {value:g}, and {fixed:g} in the calibration file: this is a run of another material.",
    "Leave it out, or calibrate with that value.",
)
NO_SEED = Message("is {text!r}.", "A seed is a whole number, 0 or above.")
SOLVER_FOR_IMPORT = Message(
    "{why} It is needed to import runs too: the version of the solver is part of what a run is, "
    "and only runs of the version in use are used."
)
TEST_NOT_GIVEN = Message("must be given: the file has several tests.", "There are: {tests}.")
UNKNOWN_TEST = Message("is {test!r}.", "There are: {tests}.")
RUN_STAYS = Message(
    "line {line}: this run is there already with other responses ({origin}); it stays as it is."
)
MORE_RUNS_STAY = Message("The same of {count} more lines.")
EARLIER_IMPORT_STAYS = Message(
    "{runs} of an earlier import of this table are not in it any more; they stay."
)
UNUSED_COLUMNS = Message("Columns that are not used: {columns}.")
OUTSIDE_OF_INTERVAL = Message(
    "Outside of the interval of {name} ({ends}) by more than {distance:.0%} of its width, and not "
    "used while it is so: line {lines}."
)
NOT_BY_EARLIER_CALIBRATIONS = Message(
    "A calibration that was started in this folder before continues without these runs. A new "
    "one, such as one with another seed, has a warm start from them."
)
NO_TABLES = Message("are not given.", "Name a table of runs.")
NO_RUN_OF_THE_FILE = Message(
    "have no run of the file: {names}.", "Only runs of the tests of the file can be used."
)
WHICH_TEST = Message(
    "{given!r} does not name its test, and the file has several.",
    "Write TEST=TABLE.csv with one of {tests}.",
)

# Runs: selection, export, pruning, measurement.
NO_RUN = Message("there is no run {identity!r} in {store}.", "'grainfit runs list' names the runs.")
SEVERAL_RUNS = Message("{identity!r} is the beginning of {count} runs: {some}.", "Give more of it.")
UNKNOWN = Message("is {wanted!r}.", "{known}")
NO_SUCH_COLUMN = Message("no run has {name!r}.", "{known}")
NO_SUCH_NUMBER = Message("no run has a number called {name!r}.", "{known}")
NO_CONDITION = Message(
    "{text!r} is not a condition.",
    "Write name, operator and value, such as 'particle.density > 2000'.",
)
UNKNOWN_FORMAT = Message("{path!r} has no known format.", "End it in .csv or .parquet.")
RUNS_ARE_A_LINK = Message("{path!r} is a link, and links are not followed.", "Nothing was removed.")
NOTHING_TO_MEASURE = Message("{path!r} does not exist.", "Name a run folder or a dump.")
NO_RUN_FOLDER = Message(
    "{folder!r} is not a run folder: it has no {record} that can be read.",
    "Name a folder below 'runs' of a work folder, or a dump.",
)
RUN_OF_OWN_MODEL = Message(
    "{folder!r} is a run of your own model.", "Only built-in tests can be measured again."
)

# The calibration of a work folder, and its answer.
UNREADABLE = Message(
    "the calibration in {store!r} cannot be read: {why:.500}. It was written by another version "
    "of grainfit, or edited."
)
NOTHING_CALIBRATED = Message(
    "nothing has been calibrated in {folder!r} yet.", "Start 'grainfit run' first."
)
NO_RESULT = Message(
    "there is no result in {folder!r}: the calibration is {state}.",
    "'grainfit status' shows its progress.",
)
NO_ANSWER_WHILE_RUNNING = Message(
    "there is no answer yet; the calibration in {folder!r} is running.",
    "Wait for its end: grainfit status {quoted}",
)
NO_ANSWER_INTERRUPTED = Message(
    "there is no answer yet; the calibration in {folder!r} was interrupted before.",
    "Start it again: it continues where it stopped.",
)
NO_ANSWER_FAILED = Message(
    "there is no answer yet; the calibration in {folder!r} failed.",
    "Remove the cause, which 'grainfit status' shows, and start it again: grainfit run {file}",
)
NO_ANSWER_FILE = Message(
    "there is no answer yet; {result!r} is missing.",
    "Start the calibration again: it is written again, and no finished run is repeated.",
)
ONE_CALIBRATION = Message("one calibration is nothing to compare.", "Name two or more.")
NO_PARAMETER_OF_FILE = Message(
    "was calibrated in {folder!r}, and is no parameter of the file.",
    "Add it to the file: a simulation without it would be one of another material.",
)
NO_VALUE_IN_ANSWER = Message(
    "is free in the file, and has no value in the answer of {folder!r}.",
    "Set it (NAME=VALUE), or give it a value in the file.",
)
SEED_TOO_LARGE = Message(
    "{seed} and the {repeat} seeds from it on go beyond {largest}.", "Give a smaller one."
)
SCENE_NOT_IN_RUNS = Message("is a scene of your own, whose file its runs do not hold.", "{remedy}")
OWN_MODEL_NOT_IN_RUNS = Message(
    "was simulated by a model of your own, which its runs do not hold.", "{remedy}"
)
GIVE_FILE_AND_ANSWER = Message("Give the calibration file, and set the answer (NAME=VALUE).")
ADVICE_FOR_BULK_TESTS = Message(
    "Advice is for calibrations of bulk tests on a DEM program alone; where a calibration file has "
    "such tests beside your own, 'grainfit design FILE' ranks further ones."
)
CURVES_ONLY = Message(
    "are curves only, and the study compares single numbers.",
    "Give a target that is one number, such as a bulk density, as well.",
)
SET_BESIDE_ANSWER = Message(
    "does not go with the answer of a calibration.",
    "Give the calibration file instead of the folder to set values.",
)
GIVEN_STIFFNESS = Message(
    "is given, so that Young's modulus changes nothing.",
    "Leave it out: linear springs then follow from Young's modulus.",
)
NO_MODULUS = Message("has no value, so there is no stiffness to study.", "Give it a value.")
NO_SIZES = Message(
    "has no apparatus whose size can be changed.", "Own models and scenes have their own."
)
NOTHING_MEASURED = Message(
    "is not given, and the bulk density neither.", "Give what you measured, such as 34deg."
)
NO_DENSITY = Message(
    "is not given, and the bulk density neither.",
    "Give the density of the particles, such as 900kg/m^3.",
)

# Predictions of hold-outs.
NO_HOLDOUT = Message("there is no [[holdout]] in the file.", "Add one, or name a test of the file.")
NO_SUCH_TEST = Message("{given!r} is no test of the file.", "{remedy}")
FAR_FROM_RUNS = Message(
    "is set to {value}, and was calibrated between {low} and {high}: its runs tell nothing there.",
    "Set a nearer value, or simulate it: 'grainfit simulate FILE --set NAME=VALUE'.",
)
ANOTHER_MATERIAL = Message(
    "{name} is {value} here and {answer} in the answer: this is not the calibrated material, and "
    "its result stays as it is."
)
OF_ANOTHER_FILE = Message("{file} is not the calibration file of {folder}, which stays as it is.")
IN_PLACE_OF_FIXED = Message("{name} is {value}, as in the answer; the file has {fixed}.")
NO_POSTERIOR = Message("no parameter set agrees with the tests fitted in {folder!r}: {why}")
MATERIAL_UNREADABLE = Message(
    "{path!r} cannot be read: {why}.",
    "Give the work folder of a calibration, a material card (JSON) or a TOML file with values.",
)
NO_MATERIAL_CARD = Message(
    "{path!r} is no material card: {why}.", "'grainfit export DIR --to json' writes one."
)

# Scans of heaps.
NO_SCAN = Message(
    "cannot be read as a scan: {reason}.",
    "Export points or triangles as PLY, as XYZ (three numbers a line) or as STL.",
)
FEW_POINTS = Message(
    "has {count} points, and {needed} are needed.", "Export the scan with a finer resolution."
)
COARSE_SCAN = Message(
    "the points are too far apart: half of them show no flanks.",
    "Export the scan with a finer resolution.",
)
NO_GROUND = Message(
    "no ground is found: no plane has a twentieth of the points on it and the others on one side.",
    "Scan the plate or the table around the heap as well, and cut off what is beside it.",
)
NO_HEAP_IN_SCAN = Message("nothing like a heap stands on the ground.", "Scan one heap, whole.")
TWO_HEAPS_IN_SCAN = Message(
    "two things stand on the ground, the second with {share:.0f} % of the area of the first.",
    "Cut the scan to one heap and the ground around it.",
)
SIDES_MISSING = Message(
    "the scan has no points on {share:.0f} % of the heap's sides.",
    "Scan the heap from all sides.",
)
NO_PARTICLES = Message("{path}: its last frame has no particles.")
COMPARED_AS_IT_IS = Message(
    "{text!r} is not a number.",
    "What is given and yielded by models of your own is compared as it is.",
)
NOT_A_NUMBER = Message("{text!r} is not a number.", "Nothing is above or below it.")
