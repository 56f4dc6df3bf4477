"""Messages of material cards."""

from grainfit.messages import Message

NO_FORMAT = Message("is {given!r}.", "Use {known} or {last}.")
OTHER_DEFINITION = Message(
    "a run in {folder!r} is not defined as in this version of grainfit: {error}"
)

# Cards of other programs.
OTHER_NEEDS = Message(
    "a card for {program} needs {missing}, which this calibration does not have.",
    "Give them in the calibration file and run it again, or use the format json or csv.",
)
NOT_RUN = Message(
    "grainfit does not run {program}: repeat a bulk test with these values before you rely on them."
)
NO_DASHPOT = Message(
    "the calibration has a dashpot of rolling; its counterpart in {title} could not be verified."
)
NO_CLUMPS = Message(
    "the particles of the calibration are clumps of spheres.",
    "The format json has their places and radii: build them in the program.",
)
