"""Messages of the calibration file: cheaper relatives of its tests, and twins."""

from grainfit.messages import Message

NO_TEST_HAS_RELATIVES = Message(
    "needs a bulk test.", "An own model has no softer, larger or fewer particles."
)
FREE_MODULUS = Message(
    "needs a fixed particle.youngs_modulus.", "A free one is part of the search: leave this out."
)
GIVEN_STIFFNESS = Message(
    "has no effect: {name} is given, and Young's modulus changes no contact.",
    "Leave it out, or leave the stiffness of the springs out.",
)
NOT_SOFTER = Message(
    "is not below particle.youngs_modulus, {modulus} MPa.",
    "Give about a twentieth of it, or leave it out.",
)
OWN_SCENE_HAS_NO_SIZE = Message(
    "cannot change test {test}, whose scene is a function of yours.",
    "Leave it out, or give softer.",
)
NO_SUCH_RELATIVE = Message(
    "makes test {test} impossible: {why}", "Give a value that changes it less, or leave it out."
)


# Photographs.
PHOTOGRAPHS = Message("Photographs, {response}: {result}; pictures: {count}, heaps: {heaps}.")
PHOTOGRAPHED_CURVE = Message(
    "{count} points up to {reach:.3g} mm from the axis, ± {error:.2g} mm in the mean"
)
PICTURE_MEASURED = Message(
    "{file}: heap {heap}, {angle:.2f} ± {error:.2f} deg (flanks {flanks}; camera {elevation:.1f} ± "
    "{elevation_error:.1f} deg above, {seen_by})"
)
PICTURE_REFUSED = Message("{file}: not measured: {reason}")
DRUM_PHOTOGRAPHED = Message("Drum, {response}: {result}")
DRUM_MEASURED = Message(
    "{file}: {frames}; the bed rises to the {side} and takes {fill:.2f} of the drum"
)
FRAMES = Message("{count} frames in {seconds:.3g} s")
STILLS = Message("the first of {count} pictures")
DRUM_SPEED = Message("{speed} by the mark on the rim")
DISTANCE_ALONE = Message(
    "is of use with the radius and the length of the drum only.",
    "Give the test drum_radius, and the length beside the distance, or drum_length with end_caps.",
)
LENGTH_WITHOUT_DISTANCE = Message(
    "is of use with a distance only.", "Give the distance of the camera, too, or leave it out."
)
OTHER_SPEED = Message(
    "the drum turns at {found} in the video, and at {given} in the test, rotational_speed.",
    "Angles depend on the speed: give the test that of the video.",
)
REPEATS_PHOTOGRAPHED = Message("Photographs, {response}: {result}; measured pictures: {count}.")
REPEAT_MEASURED = Message("{file}: {angle:.2f} deg")
BOX_WITHOUT_DIAMETER = Message(
    "is of use with the diameter of the particles only.", "Give the diameter, too, or leave it out."
)
DIAMETER_WITHOUT_BOX = Message(
    "is of use with the width of the box only.",
    "Give the box beside the diameter, or the test its width.",
)
OVERLAYS = Message("Look at the overlays in {folder}.")
NO_SUCH_PICTURE = Message("is {given}, and there is no such picture.", "{where}")
MOVED_TO = Message("It is {path} now: name it so, or move it back.")
NAME_PICTURES = Message(
    "Relative paths start at {folder}; pictures are JPEG, HEIC, PNG, BMP or TIFF."
)
NO_SUCH_VIDEO = Message("is {given}, and there is no such video.", "{where}")
NAME_VIDEOS = Message("Relative paths start at {folder}; videos are MP4, MOV, AVI, MKV or WebM.")
STILLS_NOT_VIDEO = Message("is {given}, which is no video.", "Name pictures with photos = [...].")
VIDEO_NOT_STILLS = Message(
    "is {given}, which is a video.", 'Videos of a drum are named with video = "...".'
)
NO_KNOWN_LENGTH = Message(
    "is of use with a known length only.",
    "Give the diameter of the plate, or show the marker sheet: marker = true.",
)
NO_PICTURE_MEASURED = Message("cannot be measured: {reasons}")
NOT_KEPT = Message(
    "cannot be measured, because what is found is kept in {folder}, and nothing can be written "
    "there ({reason}).",
    "Start the command in a folder of yours.",
)
PICTURE_GONE = Message(
    "{file} is not there any more; the calibration was begun with it.",
    "Put it back; without it, the target is another one, and so is the calibration.",
)
PICTURE_MOVED = Message(
    "{file} of the calibration is {path} now.", "Its name is none of those that photos gives."
)
PICTURE_CHANGED = Message(
    "{file} is not the picture with which the calibration was begun.",
    "The target is measured on the new one, and the calibration is another one.",
)
PICTURE_NEW = Message(
    "{file} is new since the calibration was begun.",
    "The target is measured with it, and the calibration is another one.",
)
EARLIER_CODE = Message(
    "measured by an earlier version of grainfit, and kept, because the calibration rests on it.",
    "To measure again, remove {folder}.",
)

# Balances.
WEIGHED = Message("{file}: {response} {value:.4g} {unit}")
NO_DISCHARGE = Message(
    "its mass changes by {change:.3g} g from its beginning to its end, which is no discharge.",
    "Name the column of the mass (y), or take another record.",
)
BOTH_WAYS = Message(
    "its mass goes up and down.",
    "Cut the record to one discharge, from before the outlet is opened until after the end.",
)
NO_END = Message(
    "its mass changes until the last line.", "Record on until after the end of the discharge."
)
ONE_RECORD = Message(
    "names one record, whose uncertainty as a curve is not known.",
    'Give records of two or more discharges, or the curve with its uncertainty: curve = "...".',
)

# Twins.
TWINS_AND_RELATIVES = Message(
    "is given beside {keys}: the real apparatus is not simulated in the search, so that relatives "
    "of it teach nothing.",
    "Leave one of them out.",
)
NO_TWIN = Message(
    "cannot change test {test}: {why}", "Take the test out of this file, or leave this key out."
)
UNKNOWN_SIZE = Message("it has no size that is known.")
NOT_COMPARED = Message("{response} of different sizes cannot be compared.")
CURVE_OF_TWIN = Message("{curve} is a curve, and sizes of curves are not compared.")
ALL_SMALL = Message(
    "strategy.twins = {twins} changes nothing: no test holds more particles, and all are simulated "
    "as they are."
)
TWINS_SIMULATED = Message(
    "Search in smaller apparatus: {tests}; then larger sizes at the answer. The result is "
    "predicted until 'grainfit run FILE --full-size' has made one run of each real test. One of "
    "{real}."
)
FIRST_SEARCH = Message("Search in smaller apparatus: {tests}.")
NEXT_SEARCH = Message("Search again, with the ratios of the sizes at the answer.")
SIZES_OF = Message("Sizes of {test} at the answer: {sizes} particles, {seeds} runs each.")
FULL_SIZE_RUN = Message("Run {number} at full size: {tests}.")
STARTS_ANEW = Message("A run of {test} that is killed starts anew: {why}.")

# Hold-outs.
TWINS_AND_HOLDOUTS = Message(
    "is given beside [[holdout]], and smaller apparatus have no prediction for another test.",
    "Leave the hold-out out: 'grainfit predict' simulates it from a file of its own.",
)
HOLDOUT_LINE = Message(
    "Hold-out {test}: {runs} after the verdict, if the material is calibrated, {at_answer} of them "
    "at the answer{time}. {measured}"
)
HOLDOUT_MEASURED = Message("Its measured values take no part in the fit.")
HOLDOUT_UNMEASURED = Message("It has no measured value: what is expected will be told.")
NO_ACCURACY = Message("{given!r} has no value.", "Write NAME=VALUE.")
ENLARGED_PARTICLES = Message(
    "{names}: more particles of this size than can be simulated. Simulated ones are {factor:g} "
    "times as large, at most {count:,} of them in a run. What that changes, and when it is right: "
    "docs/coarse_graining.md"
)
RAISED_MODULUS = Message(
    "{source} That is {usual}; here they are stiffer, because the stress of the instrument would "
    "compress such particles instead of the bed."
)
NO_BULK_TEST = Message("{name!r} is not a bulk test.", "{remedy}")
NO_RESPONSE_OF_TESTS = Message("is no response of a bulk test.", "{remedy}")
UNIT_OF_OWN_MODEL = Message(
    "is {written}, which cannot be converted to {of_model} = {own}.",
    "Name a unit of the same dimension there, or convert the column.",
)
UNIT_NOT_CLEAR = Message(
    "is {given}, and {why}: its unit is not clear.",
    'Write it with its unit, such as "{value:g} {unit}".',
)
SHARE_OF_ZERO_IN_LINE = Message(
    "is {percent:g} %, and the value in line {line} of {file} is 0.",
    "Give an absolute one{such_as}, or leave the point out.",
)
RENAMED_TO_SYSTEMATIC = Message("is called systematic now.", "Rename the key.")
NO_CURVE = Message("is missing.", "Give a table with the curve, or several as measurements.")
BESIDE_MEASURED_CURVES = Message(
    "is given beside measurements.", "The measurements say it: remove {key}."
)
NO_UNCERTAINTY_OF_CURVE = Message(
    "is missing.",
    'Give the standard uncertainty of the values, such as "2 %", or a covariance; or give the '
    "file a column with the standard error, or two with the standard deviation and the number "
    "of measurements.",
)
CURVE_NEEDS = Message(
    "does not go as far as the curve {curve}.", 'Remove it, or set {name} = "{value}".'
)
BESIDE_COVARIANCE = Message("is given beside covariance.", "The covariance says it: remove {key}.")
NO_TEST = Message("is missing.", "Add a section [[test]] with type and targets.")
NOTHING_FREE = Message(
    "there is no free parameter, so there is nothing to calibrate.",
    'Give at least one an interval, for example particle.density = {{ min = "1400 kg/m^3", max '
    '= "2800 kg/m^3" }}.',
)
NO_SECTION = Message("is missing.", "{what} {verb} [{section}] with {names}.")
PARAMETER_OF_NO_TEST = Message(
    "is used by no test: {words} {verb} the material parameters only.",
    "Remove it, or add a [[test]] of your own model.",
)
NAME_OF_A_TEST = Message(
    "{name} is the name of a [[test]] too.", 'Give it a name of its own: name = "...".'
)
MISSING_FOR_SHAPE = Message("is missing for the shape {shape}.", "{remedy}")
FIXED_IN_TABLE = Message(
    "is not a known key.",
    "A fixed parameter is written {key} = {example}; a free one has min and max.",
)
NO_TANGENT = Message("is not the tangent of an angle.", "Angles measure {known}.")
NO_INTERVAL = Message("is {given}.", "An interval is written {{ min = ..., max = ... }}.")
NO_PARAMETER_OF_FILE = Message("is not a parameter of the file.", "{remedy}")
NO_VALUE_GIVEN = Message("is given no value.", "Write {name}=VALUE.")
SHARE_OUT_OF_RANGE = Message("is {given}.", "It must be above 0 % and at most 1000 %.")
NO_MEASURED_VALUE = Message("is missing.", "Give the measured value, or a list of measurements.")
SYSTEMATIC_ALONE = Message(
    "is given without measurements.",
    "The uncertainty of a value has all parts: give it as uncertainty.",
)
BESIDE_MEASUREMENTS = Message(
    "is given beside measurements.",
    "The measurements say it: remove {key}. An uncertainty that all of them share, such as "
    "that of a scale, is systematic.",
)
NO_TARGETS = Message("are empty.", "Give at least one target.")
EMPTY_LIST = Message("is empty.", "Give at least one {table}.")
NO_TYPE = Message("is missing.", "Choose one of: {known}.")
NAME_OF_ANOTHER_TEST = Message(
    "{name} is the name of another test too.", 'Give each test its own name: name = "...".'
)
NO_NAME_OF_A_WALL = Message(
    "{name!r} cannot be the name of a wall: it means something else already.",
    "Call it differently: [{section}.steel], for example.",
)
PART_WITHOUT_WALL = Message(
    "do not say what {part} is made of, and there is no plain [wall].",
    "Write walls = {{ {parts} = ... }}, each with {walls}.",
)
PLAIN_WALL_OF_NO_TEST = Message(
    "is used by no test: every part of theirs is of a wall with a name.", "Remove it."
)
WALL_OF_NO_TEST = Message(
    "is used by no test.",
    'Name a part that is made of it in a [[test]]: walls = {{ PART = "{wall}" }}, or remove it.',
)
FILE_REFUSED = Message("is {file}, and {reason}")
NO_SUCH_WALL = Message("is {given}, and there is no [wall.{wall}].", "{remedy}")
PLANNED_CURVE = Message(
    "is a curve, and tests are compared by single responses only.",
    "Leave it out of the file from which tests are chosen.",
)
CURVE_OF_TABLE = Message(
    "is a curve, and a recorded table holds single numbers only.",
    "Give a value that a column of the table can be compared with.",
)

# Plan of a calibration.
CORRELATIONS = Message("Correlations of the errors of the measured values: {pairs}.")
RAYLEIGH_TIME_STEP = Message(
    "Rayleigh time step within the intervals: {smallest:.4g} to {largest:.4g} s."
)
NO_RAYLEIGH_TIME_STEP = Message(
    "The Rayleigh time step is not known, so it plays no part in the choice of the answer: "
    "{missing} {verb} not in the file."
)
PARTICLES_ARE_ENLARGED = Message(
    "Its particles are {factor:g} times as large as the real ones (docs/coarse_graining.md)."
)
COST_IN_THE_MIDDLE = Message("In the middle of the intervals: {cost}.")
PART_OF_SEARCH = Message(
    "Test {test}: a part of the search runs with {what}, in about {share:.2g} % of the computing "
    "time; the verdict rests on the others alone."
)
DEM_RUNS = Message(
    "DEM runs: {runs.to_come}, {runs.design} of them for the design; the last {runs.verification} "
    "or more are fresh seeds at the answer. {workers} at a time. Strategy: {runs.strategy}."
)
RUNS_WITH_SIZES = Message(
    "These are of the first search. Larger sizes at the answer take {series.runs} runs, about "
    "{time}, once to {series.most} times, with fresh seeds where the answer moves: {low} to {high} "
    "runs in all."
)
TIME_OF_RUNS = Message("Time: {time}, by the estimated cost of a run, with a core for each rank.")
REPEATS = Message("Test {test}: the mean of {count} runs with different seeds is one evaluation.")
FINEST_CLASS = Message(
    "The finest class, {diameter}, has {mass} of the mass and {particles} of the particles, and "
    "sets the time step: without it, a run would take {share:.2g} of the time."
)
WITHOUT_FINEST = Message(
    'With smallest = "{smallest:.3g} mm", which leaves out {which} {mass} of the mass, it would '
    "take {share:.2g} of the time."
)
