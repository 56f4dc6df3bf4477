"""Messages of check, design and advise: what tests leave open, and what determines it."""

from grainfit.messages import Message

# Tests that determine a parameter.
TO_DETERMINE = Message("To determine {name}: {how}")
TO_TELL_APART = Message("To tell {names} apart: {how}")
BETTER_FIXED = Message(
    "{name} hardly changes any common bulk test:",
    "take it out of the free parameters and fix it {where}.",
)
ADD_A_TARGET = Message("add a target of a test that responds to it.")
ADD_A_TARGET_OF_ONE = Message("add a target of a test that responds to one of them only.")
DETERMINE_ONE = Message("determine one of them; {tests}.")
MEASURED_ALREADY = Message(
    "{responses} {is_measured} measured already; a smaller uncertainty narrows it, and 'grainfit "
    "advise' computes which further test does"
)
ANGLES_DO_NOT_HELP = Message(
    "{tests}. Another angle does not help: heap, rotating drum and angle of internal friction "
    "depend on both frictions in nearly the same way."
)

# What stays open.
SLOPES_OF_DRY_SPHERES = Message(
    "What the tests leave open is estimated with the slopes of dry spheres in {tests}, of which "
    "the atlas does not have these particles.",
    "Simulated trials find them: 'grainfit design --simulate'.",
)
EFFECT_NOT_TOLD = Message(
    "The atlas does not tell how the tests respond to {names}, so it is not known how far they "
    "determine {them}."
)
OPEN_EVEN_SO = Message("Even if {they_were} known, {kept} would stay open.")
SHARE_KEPT = Message("{share:.0f} % of the interval of {name}")
NOT_DETERMINED = Message("{name} will not be determined by {tests}. To determine it: {how}")
HARDLY_DETERMINED = Message(
    "{name} will hardly be determined by {tests}{while_free}: {about} {share:.0f} % of its "
    "interval stays open. To determine it: {how}"
)
HARDLY_TOLD_APART = Message(
    "{names} can hardly be told apart by {tests} alone{while_free}: {about} {kept} stays open. "
    "To tell them apart: {how}"
)
MEASURE_AS_WELL = Message(
    "Measure {response} of {test} as well, to {accuracy}{tool}: by the atlas, {name} would "
    "keep ± {after} % instead of ± {before} %. The runs have it anyway; a calibration takes about "
    "two more of them."
)

# Tests that are compared.
UNKNOWN_TEST = Message("{name!r} is not a bulk test.", "{known}")
IS_FITTED = Message("the calibration has it already")
NOTHING_SIMULATED = Message(
    "is for simulated trials, and the atlas answers without any.",
    "Ask for them (simulate), or leave it out.",
)
ONLY_OWN_MODELS = Message(
    "all tests are simulated by models of your own.",
    "Only bulk tests on a DEM program can be compared with others.",
)
OTHER_DEFAULT = Message("{test} has {key} = {value} here: its default does not suit the material.")
SIZED_FOR_PARTICLES = Message(
    "{tests}: their apparatus is sized for the simulated particles, {factor:g} times as large as "
    "the real ones (particle.coarse_graining)."
)
NOT_COMPARED = Message("Not compared: {test}. {why}")
RUNS_DO_NOT_COUNT = Message("{test}: {share} failed and do not count. The first: {reason}.")
RUNS_FAILED = Message("Its runs failed: {reason}.")
TOO_FEW_RUNS = Message("Too few of its runs ended in time.")
NO_TIME = Message("is {given!r}.", "Give a time above 0 s.")
NOT_IN_ATLAS = Message("The atlas has no rows of it; simulated trials compare it.")
OWN_MODEL = Message("It is a model of your own, of which the atlas tells nothing.")
NO_TEST_COMPARED = Message("No test could be compared.")
NO_FURTHER_TEST_COMPARED = Message("No further test could be compared.")

# Which set of tests.
NO_SHARE = Message("is {given!r}.", "Give a share above 0, such as 0.2.")
ATLAS_OF_DRY_SPHERES = Message(
    "In {tests} the slopes of the atlas are those of spheres without cohesion; simulated trials "
    "find those of this material."
)
COUNTS_AS_KNOWN = Message(
    "The atlas does not tell what {name} does: it counts as known. Simulated trials find it. "
    "{otherwise}"
)
EFFECT_ON_TESTS_NOT_TOLD = Message(
    "The atlas does not tell what {name} does to {tests}; simulated trials find it."
)
SLOPES_BY_ATLAS = Message("Slopes are those of the atlas, see docs/choosing_tests.md.")
SETTLED_BY = Message("Measure {tests}: that settles {wanted}.")
SETTLED_IF_FINER = Message("At these accuracies no combination settles {wanted}. {tests} would.")
NOT_SETTLED = Message("No combination of these tests settles {wanted}.")
NOT_SETTLED_TO = Message("None of these tests settles {name} to ± {wanted}. {otherwise}")

# Which test next.
NOTHING_AGREES = Message("{why}", "Widen an interval first: see the report.")
NO_POSTERIOR = Message("{why}", "Let the calibration make more runs first.")
TOO_FEW_RUNS_YET = Message("There are too few runs.")
NEXT_BY_ATLAS = Message(
    "By the atlas: nothing was simulated. Trials are simulated on demand (simulate)."
)
ALL_DETERMINED = Message("Every parameter is determined: no further test is needed.")
DO_NEXT = Message("Do next: {test}. It would leave {left}. Measure {responses}.")
NOTHING_WORTH_DOING = Message("None of these tests tells noticeably more than the runs do.")
PAIR_LEAVES = Message("{tests} leave {left}.")
NOT_SETTLED_BY_ANY = Message("None of these tests settles {name}. {otherwise}")
