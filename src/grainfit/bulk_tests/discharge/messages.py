"""Messages to users about the options of a discharge."""

from __future__ import annotations

from grainfit.messages import Message

OTHER_ORIFICE = Message(
    "{value:g} m belongs to an orifice that is {other_kind}.",
    'Leave it out, or set orifice = "{other}".',
)
