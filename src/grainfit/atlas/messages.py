"""What the atlas says."""

from grainfit.messages import Message

NO_ROWS = Message("the atlas has no rows of this test")
CLUMPS = Message("the atlas has spheres alone, and this test has {shape}")
COHESION = Message("the atlas has no cohesion, and this material has {model}")
LAW = Message("the atlas has the usual contact law alone, not {models}")
WALLS = Message("the atlas has one material of all walls, and this test has parts of others")
DAMPING = Message("{name} is {value:.3g}, and 0 in the atlas")
SOFT_WALL = Message("walls are hardly stiffer than the particles, and rigid in the atlas")
OTHER_OPTION = Message("{name} is {value}, and {usual} in the atlas for an apparatus of this size")
OUTSIDE = Message("{name} is {value:.3g}, and in the atlas {low:.3g} to {high:.3g}")
