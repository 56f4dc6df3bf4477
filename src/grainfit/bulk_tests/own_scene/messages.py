"""Messages to users about the scene of the user."""

from __future__ import annotations

from grainfit.messages import Message

NO_SCENE = Message(
    "{reason}.",
)

ENDS_PYTHON = Message(
    "{function} ends Python ({how}).", "Let it return, or raise an error that says what is wrong."
)
NEVER_RETURNS = Message(
    "{function} did not return within {limit:g} s.", "Look for a loop without end."
)
