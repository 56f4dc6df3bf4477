"""Messages of pages that are served on this machine."""

from grainfit.messages import Message

PORT_TAKEN = Message(
    "{port} cannot be used: {reason}.",
    "Choose another one, or leave it out: any free one is taken.",
)
