"""SJKR2 in the syntax of LIGGGHTS: ``cohesion sjkr2``."""

from __future__ import annotations

from grainfit.contact_models.liggghts import LiggghtsWords

SJKR2_LIGGGHTS = LiggghtsWords(
    model="cohesion sjkr2",
    pair_properties={"cohesionEnergyDensity": "cohesion_energy_density"},
)
