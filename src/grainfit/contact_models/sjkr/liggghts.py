"""SJKR in the syntax of LIGGGHTS: ``cohesion sjkr``."""

from grainfit.contact_models.liggghts import LiggghtsKeywords

SJKR_LIGGGHTS = LiggghtsKeywords(
    model="cohesion sjkr",
    pair_properties={"cohesionEnergyDensity": "cohesion_energy_density"},
)
