"""Messages of material cards."""

from __future__ import annotations

from grainfit.messages import Message

NO_FORMAT = Message("is {given!r}.", "Use {known} or {last}.")
CANNOT_BE_WRITTEN = Message("{path!r} cannot be written: {reason}.")
OTHER_DEFINITION = Message(
    "a run in {folder!r} is not defined as in this version of grainfit: {error}"
)
