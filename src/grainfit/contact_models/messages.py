"""Texts of contact models for the user."""

from __future__ import annotations

from grainfit.messages import Message

CONTRADICTION = Message(
    "belongs to the contact model {model}; {models} cannot act together.",
    "Leave out the parameters of all but one of them.",
)
UNKNOWN_MODEL = Message("{name!r} is no model to choose.", "Use {known}.")
NO_EFFECT = Message("is no parameter of the contact model {models}.", "Leave it out.")
NOT_IN_SOLVER = Message(
    "belongs to the contact model {model}, which {solver} does not have.", "{remedy}"
)
TOO_SOFT = Message(
    "{modulus:g} Pa is too soft for this cohesion ({model}): without any load, spheres overlap by "
    "{overlap:.2g} % of their diameter.",
    "Give them {remedy}: {limit:g} % or less is simulated.",
)
