"""Messages of watching: a calibration that cannot be stopped here."""

from grainfit.messages import Message

ANOTHER_MACHINE = Message(
    "the calibration runs on another machine.", "Stop it on {host}: kill -INT {process}"
)
NOT_IN_USE = Message("no process uses the work folder any more.")
ANOTHER_USER = Message("process {process} belongs to another user, who can stop it.")
NO_INTERRUPTS = Message("process {process} does not handle interrupts.")
NO_SIGNALS = Message(
    "this system lets no other process interrupt process {process}.",
    "Press Ctrl-C in its terminal.",
)
UNKNOWN_PROCESS = Message(
    "the work folder is in use, but {process} is found here to hold it: the calibration may run on "
    "another machine or in a container.",
    "Press Ctrl-C there.",
)
