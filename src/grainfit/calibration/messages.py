"""Messages of a calibration: what it refuses, why it stops, and what its result notes."""

from grainfit.messages import Message

# Arguments.
NO_SOLVER = Message("is {given!r}.", "Give a function, a solver, or solvers by test.")
NO_SOLVERS_BY_TEST = Message("must map names of tests to solvers.")
NO_TEST = Message("is no test.", "There are: {tests}.")
LEFT_OUT = Message("is None.", "Leave it out for the default.")
GUIDED_BY_ATLAS = Message(
    "What the atlas expects of {tests} guides the search, and no verdict rests on it."
)
WITHOUT_ATLAS = Message("The search goes on without the atlas: {why}.")

# Tests, targets and parameters that do not fit together.
TARGET_NOBODY_YIELDS = Message(
    "is a target, but no test yields such a response.", "There are: {responses}."
)
CURVE_BEYOND_RUNS = Message(
    "is measured from {first:.6g} to {last}, and runs of this test have no values {beyond}.",
    "{change} these points out, or correct their unit.",
)
OTHER_UNIT = Message("is in {unit}, and the response is not.", "{remedy}")
IDLE_TEST = Message(
    "depends on no free parameter.", "Remove the test, or free a parameter that it depends on."
)
IDLE_PARAMETER = Message(
    "is free, but no test depends on it.",
    "Give it a value, or correct its name in the file or in your model.",
)
TEST_WITHOUT_SOLVER = Message("is a test without a solver.", "There are solvers for: {tests}.")
RELATIVE_WITHOUT_SOLVER = Message(
    "has a relative without a solver.", "There are solvers of relatives of: {tests}."
)
NO_RELATIVE = Message(
    "has a solver of a relative that the problem does not declare.",
    "Name it in the relatives of the problem.",
)
TARGET_WITHOUT_TEST = Message(
    "is a target of no test.", "Name every target in the TestScope of its test."
)

# Runs that fail.
ALL_FAILED = Message(
    "the first {runs} runs all failed to give {responses}; the calibration is stopped. The last "
    "one: {why}"
)
HOLDOUT_GIVEN_UP = Message(
    "Its first {runs} runs all failed to give {responses}; no others were made. {why}"
)
RESPONSES_MISSING = Message("there was only {found}")
MACHINE_FAILS = Message(
    "the last {runs} runs failed for the same reason, each after several tries: {why}. Finished "
    "runs are kept; fix the cause and start again to continue."
)
RUNS_FAILED = Message("{failed} of {runs} runs{test} failed{where}; mostly so: {why}")
AT_OR_ABOVE = Message("{parameter} of {limit} or more")
AT_OR_BELOW = Message("{parameter} of {limit} or less")
VERIFICATION_FAILED = Message("{failed} of {ended} verification runs failed: {why}")

# Notices of the result.
ON_BOUND = Message(
    "{parameter} lies on its bound {bound} = {value}: a wider interval may fit better."
)
AGREES_UP_TO_BOUND = Message(
    "{parameter} agrees up to its bound {bound} = {value}: a wider interval may fit better."
)
NO_INTERVALS = Message("The 95 % intervals of the parameters were not calculated: {why}.")
KNOWN_SCATTER = Message(
    "Scatter that is known before the runs counts as that of {runs} more, where they do not "
    "contradict it: {scatters}."
)
ROWS_READ_AGAIN = Message(
    "{runs} runs{of_test} have read {rows} of the table: a row that is read again tells nothing "
    "new, and nothing of the scatter."
)
WARM_START = Message("Warm start from {runs} earlier runs: {places}.")

# Hold-outs.
HOLDOUT_OF_SAME_NAME = Message(
    "has the name of another test.", 'Give it a name of its own: name = "...".'
)
HOLDOUT_WAS_FITTED = Message(
    "is the simulation of the fitted test {test}, and its measured values are fitted there.",
    "Name a test that takes no part in the fit, other responses of this one, or their values in "
    "another measurement.",
)
HOLDOUT_WITHOUT_RESPONSE = Message("yields no {name}.", "There are: {responses}.")
HOLDOUTS_UNREADABLE = Message("{path!r} cannot be read: {why}.")
HOLDOUTS_DAMAGED = Message(
    "{path!r} is damaged: {why}. It holds when hold-outs were registered: remove it to register "
    "them again."
)
NO_POSTERIOR = Message(
    "No parameter sets agree with the fitted tests as far as the runs tell: {why}"
)
