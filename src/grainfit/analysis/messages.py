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
