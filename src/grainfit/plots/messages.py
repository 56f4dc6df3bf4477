"""Messages of figures that cannot be drawn yet."""

from grainfit.messages import Message

NOTHING_TO_DRAW = Message("there is nothing to draw yet:", "{reasons}")
NO_RUN = Message("No run has ended.")
NO_CURVE = Message("No curve was measured.")
NO_PAIR = Message("A single parameter has no pair.")
NO_YIELD_LOCUS = Message("No material was sheared at two or more normal stresses.")
NO_HOLDOUT = Message("No test that took no part in the fit was predicted.")
