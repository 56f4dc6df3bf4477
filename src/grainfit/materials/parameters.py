"""The 14 parameters of one particulate medium and one wall, and the sizes of its particles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class MaterialParameter:
    """What a DEM material parameter is called, measured in, and can physically be.

    Parameters
    ----------
    name : str
        Dotted name as in the calibration file, ``section.key``.
    symbol, unit, description : str
        For axis labels and help; the unit is SI, ``""`` when dimensionless.
    lowest, highest : float
        Physical limits (inclusive) that no interval may leave.
    """

    name: str
    symbol: str
    unit: str
    description: str
    lowest: float
    highest: float


_BODY = (
    ("youngs_modulus", "E", "Pa", "Young's modulus", 1e3, 1e13),
    ("poissons_ratio", "ν", "", "Poisson's ratio", 0.0, 0.4999),
    ("density", "ρ", "kg/m^3", "density of the solid", 1.0, 3e4),
)
_CONTACT = (
    ("sliding_friction", "μ", "", "sliding friction coefficient", 0.0, 10.0),
    ("rolling_friction", "μ_r", "", "rolling friction coefficient", 0.0, 10.0),
    ("restitution", "e", "", "coefficient of restitution", 0.01, 1.0),
    ("rolling_damping", "η_r", "", "viscous rolling damping ratio", 0.0, 1.0),
)


def _all_parameters() -> dict[str, MaterialParameter]:
    sections = {
        "particle": ("particle", "p", _BODY),
        "wall": ("wall", "w", _BODY),
        "particle_particle": ("particle-particle", "pp", _CONTACT),
        "particle_wall": ("particle-wall", "pw", _CONTACT),
    }
    parameters = {}
    for section, (words, index, rows) in sections.items():
        for key, symbol, unit, description, lowest, highest in rows:
            name = f"{section}.{key}"
            parameters[name] = MaterialParameter(
                name, f"{symbol}_{index}", unit, f"{words} {description}", lowest, highest
            )
    return parameters


#: The 14 material parameters by dotted name, in the order of the calibration file.
MATERIAL_PARAMETERS: Mapping[str, MaterialParameter] = _all_parameters()
