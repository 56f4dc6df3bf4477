"""Messages of the report."""

from grainfit.messages import Message

CANNOT_BE_WRITTEN = Message(
    "the report {path!r} cannot be written: {reason}.", "Choose another place (output)."
)
AT_THIS_SIZE = Message("{here} in this smaller apparatus, {real} in the laboratory's")
NO_JAMS = Message(
    "No run was outlying, which still leaves a share of jams of up to {share} % possible (95 % "
    "confidence)."
)
NO_OUTLYING_RUNS = Message(
    "No run was outlying, which still leaves a share of up to {share} % possible of runs that do "
    "not belong to the others (95 % confidence)."
)

# The customer's sheet.
SHEET_CANNOT_BE_WRITTEN = Message(
    "the sheet {path!r} cannot be written: {reason}.", "Choose another place (output)."
)
NOT_TO_BE_USED = Message("These values are not those of a calibrated material.")
COARSE = Message(
    "simulated particles are {factor} times as large as the real ones ({real}); all values are "
    "those of the simulated particles"
)
VALID_FOR = Message(
    "The values hold together, not one by one, and for these particles, this contact law and "
    "stresses and speeds like those of the tests."
)
OPEN = Message("Not determined by the tests, other values agree as well: {names}.")
NARROWED = Message("Only narrowed by the tests: {names}.")
MORE = Message("{notices}: see the report.")
TIME_STEP = Message(
    "Time step {step}, which is {share} % of the Rayleigh time step of {rayleigh}: {steps} steps a "
    "simulated second."
)
NO_TIME_STEP = Message(
    "The time step is unknown: density, stiffness or size of the particles is not known."
)
NO_SPEED = Message("No run of this calibration tells how fast a process is simulated.")
SPEED = Message(
    "By the speed of this calibration's runs on their machine, each as it was started; faster on "
    "more cores. Deep beds may need a smaller time step."
)
