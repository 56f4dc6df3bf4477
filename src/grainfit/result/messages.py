"""Messages to users about the file of a result."""

from grainfit.messages import Message

UNREADABLE = Message("{path!r} cannot be read: {reason}.")
HOLDOUT_RUNS = Message("Hold-outs: {runs}, {failed} failed.")
DAMAGED = Message(
    "{path!r} is damaged: {reason}.",
    "Start the calibration again: the file is written again, and no finished run is repeated.",
)
