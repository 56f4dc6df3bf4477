"""Messages of metamodels: arrays that cannot be fitted, and runs that are left out."""

from grainfit.messages import Message

NO_ARRAY = Message("is not an array of numbers.")
BAD_SHAPE = Message("has the shape {shape}, needed is {wanted}.")
NOT_FINITE = Message("has the value {value} at {where}.", "Leave failed runs out.")
BAD_MAGNITUDE = Message(
    "are as large as {largest:g}.", "Give responses that are {least:g} to {most:g} large, or 0."
)
NEGATIVE = Message("has the negative value {least:g}.")
OUTSIDE_CUBE = Message(
    "reach from {low:g} to {high:g}.", "Give points of the unit cube (0 to 1 over each interval)."
)
NO_WHOLE_NUMBER = Message("{given!r} is not a whole number of at least {least}.")
TOO_FEW_RUNS = Message(
    "{runs} runs of {parameters} free parameters cannot be fitted.",
    "Give at least {least} runs of at least one parameter.",
)
NO_COMPONENTS = Message("is {given}.", "Keep at least 1 set of hyperparameters.")
BLOWN_UP = Message("gave a response that is no physical answer")
BLOWN_UP_RUNS = Message(
    "{name}: {runs} of {count} gave up to {largest}, which is no physical answer: they count as "
    "failed."
)
IS_A_CURVE = Message(
    "{name} is a curve, and its target is a number.",
    'Give a measured curve as its target (curve = "FILE" in a calibration file), or let the model '
    "return a number.",
)
IS_A_NUMBER = Message(
    "{name} is a number, and its target is a curve.",
    "Give a value as its target, or let the model return a curve: "
    '{{"coordinates": [...], "values": [...]}}.',
)
FEW_RESPONSES = Message("only {known} of {runs} gave the response {name!r}, at {places}")
FEW_PLACES = Message("{runs} gave the response {name!r}, at only {places}")
NO_METAMODEL = Message("{few}, and {needed} are needed for its metamodel.{because}")
FAILURES = Message("Failures: {reasons}.")

# Reasons not to trust a metamodel.
SAME_VALUE = Message(
    "All {runs} runs gave the same value: the response does not depend on the free parameters, or "
    "it is not measured."
)
FEW_RUNS = Message(
    "Only {runs} runs for {parameters} free parameters: at least {needed} are needed to tell a "
    "trend from chance."
)
SCATTERS = Message(
    "Q2 = {q2:.2f}: the response varies by {spread:.3g} (standard deviation) over the runs and "
    "scatters by {noise:.3g} from run to run; within these intervals it hardly depends on the free "
    "parameters, or too few runs show how.",
    "Widen the intervals, run more simulations, or choose another test.",
)
UNEXPLAINED = Message(
    "Q2 = {q2:.2f}: a run left out is predicted hardly better than by the mean of the others, and "
    "the scatter from run to run ({noise:.3g}, of {spread:.3g} over the runs) does not explain it.",
    "More runs are needed, or narrower intervals.",
)
TOO_CERTAIN = Message(
    "Only {coverage:.0f} % of the runs lie inside their 95 % intervals when they are left out: the "
    "metamodel is too certain.",
    "Look for outliers among the runs, or run more simulations.",
)
