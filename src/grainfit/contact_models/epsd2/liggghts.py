"""EPSD2 in the syntax of LIGGGHTS: ``rolling_friction epsd2``."""

from __future__ import annotations

from grainfit.contact_models.liggghts import LiggghtsWords

EPSD2_LIGGGHTS = LiggghtsWords(
    model="rolling_friction epsd2",
    pair_properties={"coefficientRollingFriction": "rolling_friction"},
)
