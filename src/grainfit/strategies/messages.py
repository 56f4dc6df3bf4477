"""Messages of strategies: refused options and budgets, and what a search tells at its end."""

from grainfit.messages import Message

UNKNOWN_STRATEGY = Message("{name!r} is unknown.", "Use one of: {known}.")
NO_STRATEGY = Message("is {given!r}.", "Give {names}, or an object such as grainfit.Sequential().")
NAME_TAKEN = Message("there is another one of this name")
NO_SUBCLASS = Message("it is no subclass of grainfit.Strategy")
OTHER_NAME = Message("its class calls it {name!r}")
LEFT_OUT = Message("the strategy {name!r} ({place}) is left out: {error}")
FOREIGN_OPTION = Message("has no meaning for the {strategy} strategy.", "{instead}")
OPTION_OF_OTHERS = Message("Leave it out, or use strategy {others}.")
FOREIGN_WEIGHT = Message(
    "has no meaning for the {strategy} strategy.",
    'Leave it out, or use a strategy that takes it into account, such as "staged".',
)
FOREIGN_RELATIVES = Message(
    "has no meaning for the {strategy} strategy.", 'Leave it out, or use "sequential".'
)
BUDGET_TOO_SMALL = Message(
    "{runs} runs are too few for the design and the verification.", "Allow at least {fewest}."
)
DESIGN_TOO_SMALL = Message(
    "{runs} runs are too few for metamodels of {dimension} parameters.", "Give at least {fewest}."
)
DESIGN_OVER_BUDGET = Message("{runs} are too few for the design.", "Allow at least {fewest}.")
NO_TARGET_IN_OUTCOME = Message("has {given}, which is no target.", "The targets are: {targets}.")
BOUND_MOVED = Message("{bound} = {was} was in the way and has been moved to {now}.")
LARGEST_TIME_STEP = Message(
    "Of the parameter sets that agree with the measurements, the one with the largest Rayleigh "
    "time step was taken: {gained:+.1%} against the closest one."
)

NO_ANSWER = Message("no parameter set gave all responses, so none can be the answer")

# Half-widths of the 95 % intervals.
HALF_WIDTHS_REACHED = Message(
    "Half of the 95 % intervals: {reached}. All are within the wanted {wanted}."
)
HALF_WIDTHS_MISSED = Message("Half of the 95 % interval is {reached}, where {wanted} was wanted.")
NO_RUNS_BEFORE_ANSWER = Message(
    "Runs for it are made only once the answer agrees with all measurements."
)
MORE_RUNS_NARROW = Message(
    "More runs would narrow it, to {best} at best; a larger budget allows them."
)
MEASUREMENTS_LIMIT = Message("The measurements limit it.")
MORE_MEASUREMENTS_NARROW = Message(
    "Any number of runs would leave {best}. More accurate measurements or another test would "
    "narrow it; `grainfit advise` says which."
)
