"""EPSD2 in the syntax of LIGGGHTS: ``rolling_friction epsd2``."""

from grainfit.contact_models.liggghts import LiggghtsKeywords

EPSD2_LIGGGHTS = LiggghtsKeywords(
    model="rolling_friction epsd2",
    pair_properties={"coefficientRollingFriction": "rolling_friction"},
)
