"""Messages to users about the options of a discharge."""

from __future__ import annotations

from grainfit.messages import Message

ORIFICE_IS_WIDE = Message(
    "an orifice of {width:g} m is not narrower than the container of {diameter:g} m.",
    "Make the orifice smaller or the container wider.",
)
OTHER_ORIFICE = Message(
    "{value:g} m belongs to an orifice that is {other_kind}.",
    'Leave it out, or set orifice = "{other}".',
)
