"""Messages of animations."""

from grainfit.messages import Message

NO_SCENE = Message(
    "has no test that can be animated: all are models of your own.",
    "Only grainfit's own scenes tell where particles and walls are.",
)
OWN_MODEL = Message("a model of your own has no scene to draw")
NO_FRAMES = Message("there are no frames ({reason})")
