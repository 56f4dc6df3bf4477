"""EPSD in the syntax of LIGGGHTS: ``rolling_friction epsd``."""

from __future__ import annotations

from grainfit.contact_models.liggghts import LiggghtsWords

EPSD_LIGGGHTS = LiggghtsWords(
    model="rolling_friction epsd",
    pair_properties={
        "coefficientRollingFriction": "rolling_friction",
        "coefficientRollingViscousDamping": "rolling_damping",
    },
)
