"""Messages on quantities with units, counts, files to write, and packages of extras."""

from grainfit.messages import Message

NO_UNIT = Message("{given!r} has no unit.", "{remedy}")
NO_UNIT_AT_ALL = Message(
    "{given!r} has no unit.", "Write a quantity with its unit, or a number without quotes."
)
TOO_LARGE = Message("{given!r} is too large.", "{remedy}")
NOT_A_UNIT = Message("{unit} is not a known unit.", "{remedy}")
NOT_A_UNIT_IN = Message("{unit} in {given!r} is not a known unit.", "{remedy}")
NOT_MECHANICAL = Message("{unit!r} is not made of mass, length and time.", "{remedy}")
TOO_LONG = Message("{beginning!r}... is too long for a quantity.", "{remedy}")
NOT_A_QUANTITY = Message("{given!r} is not a quantity.", "{remedy}")
OTHER_UNIT = Message("{given!r} has the unit {written}, which {reason}.", "{remedy}")
NOT_CONVERTED = Message("{given!r} cannot be converted to {unit}.", "{remedy}")

# Usual slips.
COMMA = Message("{given!r} has a comma.", "Write a decimal point, and nothing between thousands.")
SPACE = Message("{given!r} has a space in its number.", "Write the number without spaces.")
UNCERTAINTY = Message(
    "{given!r} has an uncertainty in it.",
    'Write the value alone; that of a target has a key of its own: uncertainty = "1 %".',
)

NOT_INSTALLED = Message(
    "{user} needs the Python package {package}, which is not installed.", "{remedy}"
)
CANNOT_BE_WRITTEN = Message("{path!r} cannot be written: {reason}.")
NO_COUNT = Message("is {given!r}.", "Give a whole number from 1 on.")
NO_LIST_OF = Message("are {given}.", "Give a list of {kind} objects.")
NO_NUMBERS = Message("are {given}.", "Give a list of numbers, or an array.")
NOT_BY_NAME = Message("is {given}.", "Give values by name: {example}.")
NOT_ACCEPTED = Message("is {given}.", "Give {wanted}.")
