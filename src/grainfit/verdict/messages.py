"""Messages of the verdict: what it is, and the reasons for it."""

from collections.abc import Mapping

from grainfit.messages import Message
from grainfit.verdict.holdout import HoldoutVerdict

#: Names of the ends of a calibration for people.
END_NAMES = {
    "calibrated": "calibrated",
    "predicted": "predicted, full size pending",
    "undecided": "undecided",
    "out_of_tolerance": "out of tolerance",
    "unreachable": "out of reach",
}
#: The status in words: its name, and what it means.
STATUS_WORDS = {
    "calibrated": f"{END_NAMES['calibrated']}: every target is met within its tolerance",
    "predicted": f"{END_NAMES['predicted']}: by smaller apparatus alone",
    "undecided": f"{END_NAMES['undecided']}: the runs do not tell whether every target is met",
    "out_of_tolerance": (
        f"{END_NAMES['out_of_tolerance']}: no parameter set was found that meets every target"
    ),
    "unreachable": f"{END_NAMES['unreachable']} within the given intervals",
    "interrupted": "interrupted: start it again to continue",
}


def state_name(state: str) -> str:
    """Return the name of a state of a calibration, of its end or before it, for people.

    Examples
    --------
    >>> state_name("unreachable"), state_name("running")
    ('out of reach', 'running')
    """
    return END_NAMES.get(state, state)


ALL_MET = Message("Probability that every target is met, by all runs: {probability}.")

# Reasons.
CONTRADICTED = Message(
    "{target} is in doubt: {runs} at the answer give {mean} on average, but the other runs predict "
    "{expected}.",
    "The metamodel is inaccurate there: allow more runs.",
)
MISSED_BY_RUN = Message(
    "{target} is in doubt: the run at the answer gives {found}, but all runs together predict "
    "{expected}.",
    "The metamodel is inaccurate there: allow more runs.",
)
CURVE_CONTRADICTED = Message(
    "{curve} is in doubt: compared with the curve that all runs together predict, the mean of "
    "{runs} at the answer {miss}.",
    "The metamodels are inaccurate there: allow more runs.",
)
NOT_TOGETHER = Message(
    "{targets} are each within their tolerances, but deviate as their correlation makes unlikely.",
    "Look for an error that they do not share, or lower the coefficient.",
)
OTHER_SHAPE = Message(
    "{curve}: no simulated curve has the shape of the measured one. With the stated errors, such a "
    "difference has a probability of {probability}.",
    "Look at both curves: correct the data, leave out a part that the test does not show, or state "
    "the uncertainty that the model itself has.",
)
OUTLYING_RUNS = Message(
    "{target}: {outlying} of {runs} (seed {seeds}), up to {away} {side} the prediction by the "
    "others{again}."
)
RUN_AGAIN = Message(
    "; of {repeated} that were run again with another seed, {came_again} came out like that again"
)
SCATTER_CHANGES = Message(
    "{target}: the scatter from run to run changes over the intervals, from {low} to {high}; at "
    "the answer it is {here}. All intervals take that into account."
)
TWO_STATES = Message(
    "{target}: the runs scatter about two values rather than one. Their mean is predicted, but no "
    "single run looks like it.",
    "Look at the pictures.",
)
USELESS_SCATTER = Message(
    "{target} scatters by {scatter} from run to run and tells nothing at its tolerance of "
    "{tolerance}: the mean of about {runs} runs has a standard error as large as the tolerance.",
    "Give a wider tolerance, or repeats, whose mean is one evaluation; a bulk test of more "
    "particles scatters less.",
)
OUTLIERS_DECIDE = Message(
    "Undecided because of outlying runs: every target is met with a probability of {with_all} with "
    "them, and of {without} without them.",
    "Look at their pictures: if such runs also happen in the laboratory, make the test wider or "
    'repeat it more often; if not, ask for the typical value with statistic = "median".',
)
TOO_MUCH_SCATTER = Message(
    "Every expected response is within its tolerance with a probability of {probability}, and "
    "{confidence} is demanded. {runs}: {one} scatters by {scatter}.",
    "{wider}, a larger sample in the test, or another response with less scatter helps more.",
)
TOO_FEW_RUNS = Message(
    "Every expected response is within its tolerance with a probability of {probability}, and "
    "{confidence} is demanded. The runs are too few to tell trends of {targets} from scatter.",
    "Allow more runs.",
)
ON_THE_EDGE = Message(
    "The best that can be had lies {where} the edge of the tolerance: expected is {responses}. "
    "Every target is met with a probability of {probability}, and {confidence} is demanded; more "
    "runs at the answer would hardly change that.",
    "If the tolerance is stricter than the measurement is, widen it; else widen the intervals, or "
    "free another parameter.",
)
AT_EDGE = Message("{target} {deviation} tolerances off (standard error {error})")
FRESH_SEEDS_NOT_MADE = Message(
    "Undecided because only {made} of {wanted} runs with fresh seeds at the answer could be made.",
    "Allow more runs.",
)
FRESH_SEEDS_FAILED = Message(
    "Undecided because only {made} of {wanted} runs with fresh seeds at the answer succeeded: "
    "{failed} of {ended} there failed."
)
NO_RECORD_THERE = Message(
    "Undecided because the table{of_test} has no row at the answer; the nearest is {record}, at "
    "{there}.",
    "Simulate the answer: what another row holds, however often it is read, confirms nothing.",
)
RECORDS_REPEATED = Message(
    "Undecided because only {made} of {wanted} fresh seeds at the answer read a row of the table "
    "that no other run had read.",
    "Record more runs there: reading a row again is no repetition.",
)

DETERMINISTIC = Message(
    "The model{of_test} is deterministic, as far as its runs tell: the seed changes nothing. So "
    "one run at the answer is enough, and no scatter is known."
)
DETERMINISTIC_IN_DOUBT = Message(
    "Every expected response is within its tolerance with a probability of {probability}, and "
    "{confidence} is demanded. The model of {targets} is deterministic: another seed tells "
    "nothing more.",
    "Allow more runs, at other parameters.",
)

# Smaller apparatus instead of the laboratory's.
FULL_SIZE_PENDING = Message(
    "Smaller apparatus were simulated, no run of the laboratory's was made at this answer. "
    "One of {tests}.",
    "'grainfit run FILE --full-size' makes one of each, and the verdict follows; stopped at any "
    "time, it continues.",
)
NOT_MEASURED = Message(
    "How their responses change with the size was not simulated yet.",
    "Start the same command again to continue.",
)
REAL_TEST = Message("{test} ({particles} particles instead of {simulated}) takes {time}")
FULL_SIZE_AGREES = Message(
    "{target} at full size is {found} by the run at the answer; predicted is {predicted}."
)
FULL_SIZE_DIFFERS = Message(
    "{target} at full size is {found} by the run at the answer, but predicted is {predicted}: what "
    "is expected rests on the run alone."
)
FULL_SIZE_FAILED = Message("The full-size run of {test} failed: {why}")

# Parts of TOO_MUCH_SCATTER.
RUNS_NEEDED = Message("It would take about {runs} at the answer")
RUNS_NEEDED_OF_FAILING = Message(
    "It would take about {runs} at the answer, as {failed} of {ended} failed {where}"
)
RUNS_NEEDED_ALL_FAIL = Message(
    "About {runs} at the answer would have to succeed, but {failed} of {ended} failed {where}"
)
NOISY_RESPONSE = Message("{scatter} in {target} (tolerance {tolerance})")
NOISY_CURVE = Message(
    "{ratio} σ of the measured points in {curve} (root mean square, most at {place})"
)

# Out of reach.
CURVE_MISS = Message(
    "deviates by {deviation} standard uncertainties of the measured points (root mean square), "
    "most at {coordinate} = {worst}"
)
OUT_OF_REACH = Message(
    "{target} = {value} is out of reach{together}: the nearest that the metamodels expect within "
    "the intervals is {nearest}{share}."
)
WITH_RATIO = Message("; with the uncertainty of the ratio to the real apparatus, {nearest}")
CURVE_OUT_OF_REACH = Message(
    "{target} is out of reach{together}: the nearest curve that the metamodels expect within the "
    "intervals {miss}."
)
NO_SUCH_SHAPE = Message("No simulated curve has the shape of the measured one.")
RUNS_FAIL_NEARER = Message(
    "Runs fail where the metamodels expect it nearer: see why they do, or free another parameter."
)
NO_BOUND = Message(
    "The runs do not tell which bound is in the way: widen the intervals, or free another "
    "parameter."
)
BOUND = Message("The bound in the way is {bound}; try {suggestion}.")
NO_BOUND_BEYOND = Message(
    "The bound in the way is {bound}, and no possible value within three intervals of it is "
    "enough: check what was measured, or free another parameter."
)

# Hold-outs: tests that take no part in the fit.
#: What is said of a prediction, in its own sentences and in the one about all.
HOLDOUT_WORDS: Mapping[HoldoutVerdict, str] = {
    "does not predict": "is not predicted",
    "does not tell": "tells nothing",
    "predicts": "is predicted",
}
#: What is said of a hold-out without a prediction.
HOLDOUT_STATES = {
    "failed": "no prediction",
    "interrupted": "interrupted",
    "pending": "not simulated yet",
}
HOLDOUTS_IN_SHORT = Message("Tests that were not fitted: {found}.")
_PREDICTED = f"{{name}}, which was not fitted, {HOLDOUT_WORDS['predicts']}: "
_NOT_PREDICTED = f"{{name}}, which was not fitted, {HOLDOUT_WORDS['does not predict']}: "
_TELLS_NOTHING = f"{{name}}, which was not fitted, {HOLDOUT_WORDS['does not tell']}: "
HOLDOUT_PREDICTS = Message(
    f"{_PREDICTED}{{measured}} was measured and {{interval}} expected; a value as far off has a "
    "probability of {probability}. The intervals of the parameters allow {prior}."
)
_OTHER_CAUSE = (
    "What the fitted tests do not show matters there: the apparatus, the contact law, the shape or "
    "a parameter that is fixed."
)
HOLDOUT_REFUTED = Message(
    f"{_NOT_PREDICTED}{{measured}} was measured, but {{interval}} expected; a value as far off has "
    "a probability of {probability}.",
    _OTHER_CAUSE,
)
HOLDOUT_TELLS_NOTHING = Message(
    f"{_TELLS_NOTHING}{{measured}} was measured and {{interval}} expected, but that is more than "
    "half of what the intervals of the parameters allow, {prior}."
)
HOLDOUT_EXPECTED = Message(
    "{name} is expected at {predicted}, within {interval} (95 %). The intervals of the parameters "
    "allow {prior}."
)
HOLDOUT_CURVE_PREDICTED = Message(
    f"{_PREDICTED}its {{points}} lie within the band that holds 95 % of the expected curves. "
    "Farthest off at {place}: {measured} was measured and {interval} "
    "expected; a curve as far off has a probability of {probability}. The band is {share} times as "
    "wide as what the intervals of the parameters allow."
)
HOLDOUT_CURVE_REFUTED = Message(
    f"{_NOT_PREDICTED}of its {{points}}, {{outside}} lie outside the "
    "band that holds 95 % of the expected curves. Farthest off at {place}: {measured} was "
    "measured, but {interval} expected; a curve as far off has a probability of {probability}.",
    _OTHER_CAUSE,
)
HOLDOUT_CURVE_TELLS_NOTHING = Message(
    f"{_TELLS_NOTHING}its {{points}} lie within the band that holds 95 % "
    "of the expected curves, but this is {share} times as wide as what the intervals of the "
    "parameters allow. At {place}, {measured} was measured and {interval} expected."
)
HOLDOUT_PENDING = Message(f"Hold-out {{test}}: {HOLDOUT_STATES['pending']}.")
HOLDOUT_INTERRUPTED = Message(
    f"Hold-out {{test}}: {HOLDOUT_STATES['interrupted']}.",
    "Start the same command again to continue.",
)
HOLDOUT_NOT_CALIBRATED = Message(
    "Hold-out {test}: not simulated, as no calibrated material is there to predict it.",
    "'grainfit predict FILE' simulates it all the same.",
)
HOLDOUT_FAILED = Message(f"Hold-out {{test}}: {HOLDOUT_STATES['failed']}. {{why}}")
HOLDOUT_SOME_FAILED = Message("Hold-out {test}: {failed} of {runs} failed. {why}")
HOLDOUT_LATE = Message(
    "Hold-out {test} was registered on {date}, when {runs} of the work folder were known."
)
HOLDOUT_CHANGED = Message(
    "Hold-out {test} has other targets since {changed} than those registered on {date}."
)
HOLDOUT_OF_INTERVALS = Message(
    "Hold-out {test}: the material comes with single intervals, so that what is expected is drawn "
    "from these as if the parameters were independent."
)
HOLDOUT_OF_VALUES = Message(
    "Hold-out {test}: the material comes without intervals of the free parameters, so that what is "
    "expected is as exact as if the values were."
)
