"""Messages of evaluations: refused outcomes, curves, and what custom models gave."""

from grainfit.messages import Message

OTHER_PROPOSAL = Message("is the evaluation of another proposal.")
NO_OUTCOME = Message(
    "is {given!r}.",
    'Give responses by name, {{"angle": 31.2}}, or RunFailedError("why it failed").',
)
NO_RESPONSE = Message(
    "is {given!r}.", 'Give a finite number; a run that has none failed: RunFailedError("why").'
)
NOT_FINITE = Message("are not finite numbers.", "Give at least two.")
UNEQUAL_NUMBERS = Message("are {count}, and there are {values} values.", "Give one for each value.")
NOT_INCREASING = Message("do not increase.", "Sort the points.")
UNKNOWN_KEY = Message(
    "response {name} from {origin} has the key {key}, which is unknown.", "There are: {known}."
)
PARAMETER_NOT_FINITE = Message("is {given!r}, not a finite number.", "Give a finite number.")
