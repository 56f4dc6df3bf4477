"""Messages of previews."""

from grainfit.messages import Message

NO_SCENE = Message(
    "has no test that can be previewed: all are models of your own.",
    "Only tests that a DEM program of grainfit simulates have a scene.",
)
CANNOT_BE_WRITTEN = Message("{path!r} cannot be written: {reason}.", "Choose another place.")
