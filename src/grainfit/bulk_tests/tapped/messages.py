"""Messages to users about the options of a tapped test."""

from grainfit.messages import Message

DROP_IS_HIGH = Message(
    "a drop of {drop:g} m is more than half of the bed, {height:g} m high.",
    "Use at most {highest:g} m, or a bed that is at least {least:g} m high (fill_height).",
)
FEW_TAPS = Message(
    "the density is that after {taps} taps; a laboratory taps {usual} times or more, and has a "
    "higher one.",
    "Give the taps of the laboratory, or as target the density that it had after {taps}.",
)
