"""SJKR in the syntax of LIGGGHTS: ``cohesion sjkr``."""

from __future__ import annotations

from grainfit.contact_models.liggghts import LiggghtsWords

SJKR_LIGGGHTS = LiggghtsWords(
    model="cohesion sjkr",
    pair_properties={"cohesionEnergyDensity": "cohesion_energy_density"},
)
