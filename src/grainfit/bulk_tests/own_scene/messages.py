"""Messages to users about the scene of the user."""

from __future__ import annotations

from grainfit.messages import Message

NO_SCENE = Message(
    "{reason}.",
)
