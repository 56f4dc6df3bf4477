"""Messages of the report."""

from __future__ import annotations

from grainfit.messages import Message

CANNOT_BE_WRITTEN = Message(
    "the report {path!r} cannot be written: {reason}.", "Choose another place with --output."
)
