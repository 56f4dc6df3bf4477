"""Messages of the page that starts a calibration."""

from grainfit.messages import Message

RUNS_ALREADY = Message("It runs already.", "Follow it, or stop it there.")
