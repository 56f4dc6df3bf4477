"""SJKR2 in the syntax of LIGGGHTS: ``cohesion sjkr2``."""

from grainfit.contact_models.liggghts import LiggghtsKeywords

SJKR2_LIGGGHTS = LiggghtsKeywords(
    model="cohesion sjkr2",
    pair_properties={"cohesionEnergyDensity": "cohesion_energy_density"},
)
