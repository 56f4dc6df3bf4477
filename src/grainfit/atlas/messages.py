"""What the atlas says."""

from grainfit.messages import Message

NO_ROWS = Message("the atlas has no rows of this test")
DAMAGED = Message(
    "the rows of this test in the atlas are damaged, or of another version: install grainfit again"
)
PARTICLES = Message("of this test the atlas has {known}, and not {given}")
NO_VALUE = Message("the material has no {name}")
LAW = Message("the atlas has the usual contact law alone, not {models}")
WALLS = Message("the atlas has one material of all walls, and this test has parts of others")
DAMPING = Message("{name} is {value:.3g}, and 0 in the atlas")
SOFT_WALL = Message("walls are hardly stiffer than the particles, and rigid in the atlas")
OTHER_OPTION = Message("{name} is {value}, and {usual} in the atlas for an apparatus of this size")
OUTSIDE = Message("{name} is {value}, and in the atlas {low} to {high}")
LEFT_OUT = Message(
    "The atlas has {name} from {low} to {high} alone: the estimate is of that part of the "
    "intervals."
)
LESS_SURE = Message(
    "{name} is {value:.3g} times the usual one, and {low:.3g} to {high:.3g} in the atlas: "
    "responses are those at its end, and less sure by what the range changes."
)
CURVE = Message("the atlas has numbers alone, and this is a curve")
NO_RESPONSE = Message("too few rows of the atlas have this response")
NOTHING_TOLD = Message(
    "the atlas tells nothing about any target ({reasons}).",
    "Calibrate with 'grainfit run', which simulates the tests.",
)
NOT_SIMULATED = Message(
    "Estimate by the atlas: not simulated. It is no calibration: 'grainfit run' verifies it."
)
ESTIMATED = Message("{name}: {value}, 95 % interval {interval}.")
ERRORS = Message("± standard error of the atlas; of measured values, the tolerance")
OUT_OF_REACH = Message("{response}: no parameters within the intervals give the measured value.")
AT_ODDS = Message(
    "{response}: some parameters within the intervals give the measured value, but none that give "
    "the other measured values, too."
)
BEYOND_BOUND = Message(
    "{responses}: off by more than the tolerance. Values of {names} beyond the ends of the "
    "intervals would be nearer."
)
OPEN = Message("The targets leave open: {names}.")
WOULD_NARROW = Message(
    "{response} of a {test} test, measured to {accuracy}, would narrow {name} to about {left:.0f} "
    "% of its present interval."
)
EXPECTED_TO_FAIL = Message("the atlas expects that a run there lacks a response")
MAY_FAIL = Message(
    "A run there has all responses with a chance of {chance:.0f} % only: the others cannot be "
    "measured."
)
UNTOLD = Message("Left out, {responses}: {why}.")
TO_VERIFY = Message("A calibration verifies it with about {runs} runs of each test{time}.")
TOO_MANY_RUNS = Message(
    "No calibration of a usual length verifies it: {response} scatters by {times} times its "
    "tolerance from run to run, which takes more than {most:,} runs."
)
