"""Messages of the analysis: runs that are left out, convergence, scatter, refused arguments."""

from grainfit.messages import Message

# Runs that the analysis rests on.
NO_METAMODEL = Message("There is no metamodel of {name}: {why}")
NO_RESPONSES = Message("None of {runs} runs yielded a response: nothing can be said.")
NO_RUNS = Message("There is no run yet that yielded a response: nothing can be said.")
RUNS_FAR_OUTSIDE = Message(
    "{left_out} of {runs} runs are farther outside the intervals than {share:.0%} of their widths "
    "and are left out."
)
RUNS_CHOSEN = Message(
    "The analysis rests on {chosen} of {runs} runs, because its effort grows with the cube of "
    "their number: {which}."
)

# Samples.
BAD_LEVEL = Message("is {given}.", "Give a probability between 0 and 1.")
NO_PARAMETER = Message("{given!r} is no free parameter.", "Use {known}.")
NO_POWER_OF_TWO = Message("is {given}.", "Give a power of two, such as 512.")
ENSEMBLES = Message(
    "{ensembles} ensembles of {walkers} walkers, started independently of each other, made "
    "{steps} steps each; they count as {samples:,.0f} independent samples, R-hat is {r_hat:.3f}."
)
SAMPLES_NEEDED = Message("{needed:,.0f} independent samples are needed")
ENSEMBLES_DISAGREE = Message(
    "R-hat above {most} says that the ensembles do not agree with each other"
)
NOT_CONVERGED = Message(
    "{made} Not converged: {reasons}. Take intervals and correlations as rough."
)

# Scatter over seeds.
NO_EVALUATIONS = Message("are empty.", "Give those of several seeds.")
SEVERAL_PARAMETER_SETS = Message("are at {count} parameter sets.", "Give those of one.")
SEED_TWICE = Message("have more than one run of seed {seeds}.", "Give every run once.")
ONE_RUN_SCATTERS = Message("{name}: one run scatters by {ratio} times the tolerance; {mean_within}")
MANY_RUNS_NEEDED = Message(
    "{scatters} A larger sample in the test, another response or a wider tolerance helps more "
    "than that many runs."
)
MEAN_WITHIN = Message("the mean of {runs} is within it (95 %).")

# Sizes of an apparatus.
NO_SIZE = Message("{given:g} is no size.", "Give numbers above 0: times the particles.")
IMPOSSIBLE_SIZE = Message(
    "test {test} is impossible with {times:.3g} times its particles: {why}",
    "Give sizes nearer to 1.",
)
FEW_SIZES = Message("{count} given.", "Give two or more, as 1,2,4.")
NO_TREND = Message("{response}: too few sizes of test {test} tell a trend.")
SIZE_IN_DOUBT = Message(
    "{response}: the trend to {particles} particles is known to ± {half}, and its tolerance is "
    "{tolerance}. Larger sizes or more seeds tell."
)
SIZE_MATTERS = Message(
    "{response} with {particles} particles is {change} away from that with {first}; its tolerance "
    "is {tolerance}. A calibration in the small apparatus needs a target that is as much lower."
)
NO_FACTOR = Message("{factor:g} is no factor.", "Give numbers above 0.")
FEW_FACTORS = Message("{count} given.", "Give two or more, as 1,4,16.")
MODULUS_OUTSIDE = Message("{value:g} is outside {limits}.", "Give factors nearer to 1.")
NO_RESPONSE_OF_RUNS = Message("the runs give none of the responses")

# The stiffness of particles.
A_RUN_FAILED = Message("A run failed: {why}")
CURVES_NOT_COMPARED = Message("Not compared: {curves}, which {what}.")
NO_SMALLER_MODULUS = Message(
    "No smaller modulus gives what {top} gives{misses}.",
    "Whether {top} is stiff enough is not known: add a larger factor.",
)
MODULUS_ENOUGH = Message(
    "{modulus} is enough: every response is within its tolerance of that at {top}, and at every "
    "modulus between them."
)
MODULUS_IN_DOUBT = Message(
    "{modulus} is the smallest modulus that may be enough: the scatter leaves open whether "
    "{responses} {verb} within tolerance of what {top} gives{sure}.",
    "More seeds tell.",
)
DIFFERS_AT_MODULUS = Message(
    "{response} differs by {difference} at {modulus}, {accepted} are accepted"
)

# Runs that take long.
LONG_RUN = Message("Test {test}: a run takes about {time}.")
STARTS_ANEW = Message("One that is killed starts anew: {why}.")
FASTER_WITH_LARGER = Message(
    "With {factor} it takes about {time} ({particles} particles). Larger particles in the same "
    "apparatus shift responses{moved}, and the calibrated values hold for simulations at that "
    "factor: compare two factors (docs/coarse_graining.md)."
)
FASTER_IN_SMALLER = Message(
    "In an apparatus that holds {particles} of the same particles it takes about {time}{moved}: "
    "strategy.twins = {twin} searches in it, predicts the real one, and verifies it by one run "
    "(docs/size.md)."
)

# What the tests determine.
PAIRS_FIT = Message("{names} cannot be told apart by these tests: any pair along {along} fits.")
SETS_FIT = Message("{names} cannot be told apart by these tests: {sets}.")
KNOWN_BY_ITSELF = Message(
    "{name} is known from its own measurement: {between} with 95 % probability."
)
PARTS_FIT = Message("{name} is not determined: {parts} fits.")
NOT_DETERMINED = Message("{name} is not determined: {between} with 95 % probability.")
NARROWED = Message("{name} is only narrowed: {between} with 95 % probability{but}.")
DETERMINED = Message("{name} is determined: {between} with 95 % probability{but}.")
DETERMINED_TO = Message("{name} is determined to {share} ({between}){but}.")
UP_TO_BOUND = Message(", up to its bound {bound}")
BUT_BIASED = Message(", but biased: {bias}")
KNOWN_BETTER_IF = Message("It would be known better if {others} were.")

# Parameters on which responses depend.
DEPENDS_ON_NONE = Message(
    "{response} depends on none of the free parameters within their intervals."
)
SENSITIVITY_NOT_KNOWN = Message(
    "On which parameters {response} depends is not known: its metamodel explains too little of the "
    "runs, and shares of the variance are uncertain by up to {uncertainty:.0f} %.",
    "More runs, spread over the intervals, or a test that scatters less would tell.",
)
DEPENDS_ON = Message("{response} depends on {parameters}{rest}.")
SHARE = Message("{parameter} ({share:.0f} % of its variance)")
SHARE_WITH_OTHERS = Message(
    "{parameter} ({share:.0f} % of its variance, partly together with others)"
)
