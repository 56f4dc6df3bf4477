"""Messages of the command line."""

from grainfit.messages import Message

INTERRUPTED = Message("Interrupted.")
STOPPED = Message("Interrupted. Finished runs are kept; start again to continue.")
NO_MEMORY = Message(
    "The machine has no memory left{why}.", "Use fewer particles, or end other programs."
)
QUIET_AND_VERBOSE = Message("--quiet and --verbose exclude each other.")
NOT_IN_LIST = Message("Choose from the list.")

# Arguments.
NO_NUMBER = Message("{given!r} is not a number.", "Write them as 1,4,16.")
NO_TIME = Message("is {given!r}.", "Give a time above 0, as 10min.")
NO_SHARE = Message("is {given!r}.", "Give a percentage above 0, as 20%.")
FRAMES_WITHOUT_ANIMATION = Message("--frames is for --animate.", "Give both, or none.")
ANIMATION_OF_ONE_RUN = Message(
    "--animate shows one run, not --repeat of them.", "Choose the run with --seed instead."
)
SEVERAL_SIMULATIONS = Message(
    "run {number} has {count} simulations: {names}.", "Give the name of one of them."
)

FULL_SIZE_OF_NOTHING = Message(
    "the file has no strategy.twins: its tests are simulated as they are.",
    "Leave it out, or add twins = 4000 to [strategy].",
)

# Files.
EXISTS = Message("{file!r} exists already.", "Choose another name.")
NOT_REPLACED = Message("{file!r} exists already.", "Replace it with --force.")
OTHER_KIND = Message(
    "{file!r} would have the content of a {kind} file.", "Give a name that ends in {kind}."
)
WRITTEN = Message("Wrote {file}. Edit it, then: grainfit check {file}")
NO_REPORT = Message("No report was written ({reason}).", "Try again: grainfit report {folder}")

# Beside a run.
CUT_OFF = Message(
    "The last start was killed, or crashed, in the middle of runs, which are made again: "
    "{runs}{others}."
)
NO_PAGE = Message("No page follows this run: {reason}.")
NOTIFICATION_FAILED = Message("The command of --notify failed: {reason}.")
NOTIFICATION_TOO_LONG = Message("it took longer than {seconds:.0f} s and was ended")
SIMULATED_AGAIN = Message("Simulating {tests} again: the stored run has too few frames or none.")
NOTHING_TO_ESTIMATE = Message(
    "is not given, and --diameter neither.",
    "Give a calibration file, or: --diameter 3mm --bulk-density 540kg/m^3 --angle 34deg.",
)
BESIDE_FILE = Message(
    "is for an estimate without a file.", "Leave it out, or write what you measured in the file."
)
DAMAGED_ATLAS = Message(
    "The rows of {test} in {folder} are damaged, or of another version, and tell nothing.",
    "Install grainfit again.",
)
MARKER_SHEET = Message(
    "Wrote {path}.", "Print it at 100 %: its line is 100 mm long. Lay it flat and level."
)
EDIT_ONE = Message("is to be one picture.", "Edit one picture at a time.")
NO_PICTURES = Message("is not given.", "Give pictures, or --marker FILE.pdf for the sheet.")

# The interview.
ANSWERS_KEPT = Message("The answers are kept in {file}. Go on with: grainfit ask {file}")
LEFT = Message(
    "The answers are in {file}. A sheet for the laboratory: grainfit ask {file} --sheet FILE.pdf"
)
READY = Message("The calibration is in {file}. Start it: grainfit run {file} --watch")
NO_ESTIMATE = Message("No estimate yet: {why}.")
SHEET_WRITTEN = Message("Wrote {file}. Print it, and take it to the laboratory.")
GOES_ON = Message("The calibration goes on. Follow it: grainfit watch {folder}")
