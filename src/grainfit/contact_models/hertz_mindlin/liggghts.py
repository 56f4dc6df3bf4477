"""Hertz-Mindlin in the syntax of LIGGGHTS: ``hertz`` with ``tangential history``."""

from grainfit.contact_models.liggghts import LiggghtsKeywords

HERTZ_MINDLIN_LIGGGHTS = LiggghtsKeywords(
    model="hertz tangential history",
    body_properties={"youngsModulus": "youngs_modulus", "poissonsRatio": "poissons_ratio"},
    pair_properties={
        "coefficientRestitution": "restitution",
        "coefficientFriction": "sliding_friction",
    },
)
