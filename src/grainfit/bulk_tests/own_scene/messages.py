"""Messages to users about the scene of the user."""

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
NO_WALL_BELOW = Message(
    "{share:.0%} of the particles begin with no wall below them, in the stage {stage}, in which a "
    "bed is to come to rest.",
    "Let the column begin above its gate and within its vessel, see 'grainfit preview'.",
)
BESIDE_VESSEL = Message(
    "{share:.0%} of the particles begin beside the vessel, level with its walls.",
    "Move the column into the vessel, see 'grainfit preview'.",
)
FORCES_AFTER_FILL = Message(
    "the stage {stage} records forces of a bed as it was filled: the friction of its walls points "
    "down, and its floor can carry more than the weight.",
    "Lower the floor by half a diameter before forces are read, see docs/scenes.md.",
)
NO_FUNCTION_RECORDED = Message("the record of a run has no function for another scene")
SCENE_FAULTS = Message("the scene of {function}: {reason}")
FUNCTION_CHANGED = Message("{path}: was changed after the run.")
EMPTY_BOX = Message("no particles are left in the box")
NOT_KEPT = Message("{reason} It was not kept with the run.")
DID_NOT_RETURN = Message("{function} did not return within {limit:g} s")
NO_FUNCTION = Message("{function} is no function")
UNKNOWN_ARGUMENTS = Message("{function} takes {unknown}; it can take {possible}")
NOT_A_SCENE = Message("{function} gave {kind}, not a Scene: return grainfit.scenes.Scene(...)")
WRONG_TYPE = Message(
    "the scene of {function} has a value of a wrong type: {reason}: see docs/own_scenes.md"
)
MAY_BE_ENLARGED = Message(
    "sizes are {factor:g} times the real ones (particle.coarse_graining). {file} keeps the size of "
    "the apparatus if it takes lengths from sizes.real or from options."
)
