"""Messages of the page that starts a calibration."""

from grainfit.messages import Message

EARLIER_FILE = Message(
    "The file has changed since: these are the values of the earlier file.",
    "A start calibrates the present one.",
)
RUNS_ALREADY = Message("It runs already.", "Follow it, or stop it there.")
TYPED_ALREADY = Message(
    "has typed values, and a target is either typed or measured on pictures.",
    "Empty the field first.",
)
