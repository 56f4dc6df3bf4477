"""Messages to users about the options of a discharge."""

from grainfit.messages import Message

OTHER_ORIFICE = Message(
    "{value:g} m belongs to an orifice that is {other_kind}.",
    'Leave it out, or set orifice = "{other}".',
)
