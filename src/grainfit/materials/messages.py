"""Messages of materials: particle sizes, shapes, walls, and the tables that have them."""

from grainfit.messages import Message

# Columns of a sieve curve.
SEVERAL_MAY_BE = Message(
    "has the columns {names}, and more than one of them may be the {meaning}.",
    'Give one column the heading "{example}".',
)
NONE_IS = Message(
    "has the columns {names}, and none of them is the {meaning}.",
    'Give one column the heading "{example}".',
)
ONLY_RETAINED = Message(
    "has the columns {names}, and none of them is the {meaning}.",
    'Give one column the heading "{example}": 100 % minus all that this sieve and the coarser '
    "ones retain.",
)
