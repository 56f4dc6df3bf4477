"""Messages of the page that starts a calibration."""

from grainfit.messages import Message

RUNS_ALREADY = Message("It runs already.", "Follow it, or stop it there.")
TYPED_ALREADY = Message(
    "has typed values, and a target is either typed or measured on pictures.",
    "Empty the field first.",
)
