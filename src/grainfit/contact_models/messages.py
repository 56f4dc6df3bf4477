"""Texts of contact models for the user."""

from grainfit.messages import Message

CONTRADICTION = Message(
    "belongs to the contact model {model}; {models} cannot act together.",
    "Leave out the parameters of all but one of them.",
)
UNKNOWN_MODEL = Message("{name!r} is no model to choose.", "Use {known}.")
NO_EFFECT = Message("is no parameter of the contact model {models}.", "Leave it out.")
NOT_CHOSEN = Message(
    "is a parameter of the contact model {model}, which is not chosen.",
    'Write {kind} = "{model}" into [contact_models], or leave it out.',
)
NOT_BESIDE = Message(
    "{solver} cannot compute {other} ({kind}) beside the contact model {model}.",
    "Set it to 0{instead}.",
)
ONE_SIZE = Message(
    "{solver} computes the contact model {model} for spheres of one diameter only: it has the same "
    "dashpots for all.",
    "{remedy}",
)
NOT_IN_SOLVER = Message(
    "belongs to the contact model {model}, which {solver} does not have.", "{remedy}"
)
TOO_SOFT = Message(
    "{modulus:g} Pa is too soft for this cohesion ({model}): without any load, spheres overlap by "
    "{overlap:.2g} % of their diameter.",
    "Give them {remedy}: {limit:g} % or less is simulated.",
)
SOLVERS_DIFFER = Message(
    "The tests run with {solvers}. {difference}", "Use one solver for all tests."
)
