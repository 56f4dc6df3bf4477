"""Messages to users about values of options, and about functions in Python files."""

from grainfit.messages import Message

NO_REFERENCE = Message(
    "{reference!r} does not name a function in a file.",
    'Write the file and the function in it: "model.py:simulate".',
)
NO_SUCH_FUNCTION = Message("has no function {function!r}.", "{remedy}")
NESTED_TOO_DEEPLY = Message("is nested too deeply for Python.", "Simplify it.")
TOO_LARGE_TO_READ = Message(
    "cannot be read: {reason}.", "Move its data to a file that the function reads."
)
CANNOT_BE_READ = Message("cannot be read: {reason}.", "Give the path of a Python file.")
NOT_PYTHON = Message("is not valid Python: {reason}.")
TAKES_OTHER_ARGUMENTS = Message("is {given}, which takes {unknown}.", "It can take {arguments}.")
BAD_REFERENCE = Message("is {reference}: {reason}", "{remedy}")
WRONG_KIND = Message("is {given}, {kind}; it must be {expected}.", "{remedy}")
BAD_NAME = Message("{name} cannot be a name.", "{remedy}")
NOT_A_CHOICE = Message("is {given}.", "{remedy}")
NO_SHARE = Message("is {given}.", "{remedy}")
NOT_FINITE = Message("is {given}.", "Give a finite number.")
UNIT_OF_MODEL_UNKNOWN = Message(
    "is {given}, and nothing says which unit your model takes.",
    'Write a plain number, or name the unit beside it, such as unit = "J/m^3".',
)
TOO_FEW_ENTRIES = Message("has {count}.", "Give at least {shortest}.")
NOT_ONE_LINE = Message("is {given}.", "Write one line of 1 to {longest} characters.")
COUNT_OUT_OF_LIMITS = Message("is {given}.", "It must be {limits}.")
NO_SUCH_SIZE = Message("is {given}.", "No DEM quantity is of such size.")
NOT_ABOVE_ZERO = Message("is {given}.", "It must be above 0.")
OUT_OF_LIMITS = Message("is {given}.", "It must be {limits}.{why}{hint}")
NOT_THERE = Message("is {given}, but there is no such {kind}.", "Relative paths start at {folder}.")
MISSING = Message("is missing.", "{remedy}")
MEANT = Message('Did you mean "{name}"?')
UNKNOWN_KEY = Message("is not a known key.", "{remedy}")
RESERVED_NAME = Message('"{name}" means something else already.', "Choose another name.")
