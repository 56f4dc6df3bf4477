"""Examples of options and targets, for particles of a starting material."""

from __future__ import annotations

import re
from math import radians, tan

from grainfit.materials.starting_materials import StartingMaterial
from grainfit.units import to_unit

#: Diameter and bulk density of the particles that the examples of tests are for, mm and kg/m^3.
DIAMETER_OF_EXAMPLES = 10.0
_BULK_DENSITY_OF_EXAMPLES = 1350.0
#: Powers of diameter and bulk density that quantities of a unit follow, with Froude's number kept.
_POWERS = {
    "mm": (1.0, 0),
    "s": (0.5, 0),
    "m/s": (0.5, 0),
    "rad/s": (-0.5, 0),
    "kg/s": (2.5, 1),
    "kg/m^3": (0.0, 1),
}
_QUANTITY = re.compile(rf'"([\d.]+) ({"|".join(map(re.escape, _POWERS))})"')
#: Size of a heap in diameters, at an angle of repose of 45 degrees, and the power of the tangent of
#: the angle that it follows: fitted to simulated heaps of rough spheres of 20 to 41 degrees, of
#: which all are within 2 % in radius and 8 % in height. A cone of given volume has powers of -1/3
#: and 2/3; heaps have a foot and a round top.
_SIZE_OF_HEAP = {"base_radius": (10.3, -0.21), "heap_height": (8.7, 0.56)}


def scaled_example(example: str, material: StartingMaterial | None) -> str:
    """Return an example for particles of the size and bulk density of a material.

    Parameters
    ----------
    example : str
        TOML, for particles of `DIAMETER_OF_EXAMPLES`.
    material : StartingMaterial, optional
        The material; without it the example is as it was.
    """
    if material is None:
        return example
    size = _diameter(material) / DIAMETER_OF_EXAMPLES
    density = to_unit(material.example_targets["bulk_density"], "kg/m^3")

    def of_material(found: re.Match[str]) -> str:
        of_size, of_density = _POWERS[found[2]]
        ratio = size**of_size * (density / _BULK_DENSITY_OF_EXAMPLES) ** of_density
        return f'"{_rounded(float(found[1]) * ratio)} {found[2]}"'

    return _QUANTITY.sub(of_material, example)


def example_target(response: str, example: str, material: StartingMaterial | None) -> str:
    """Return an example of a target: the material's own value, or one that agrees with it.

    Parameters
    ----------
    response : str
        Name of the response.
    example : str
        TOML, for particles of `DIAMETER_OF_EXAMPLES`.
    material : StartingMaterial, optional
        The material; without it the example is as it was.
    """
    target = scaled_example(example, material)
    if material is None:
        return target
    value = material.example_targets.get(response)
    if response in _SIZE_OF_HEAP:
        diameters, power = _SIZE_OF_HEAP[response]
        slope = tan(radians(to_unit(material.example_targets["angle_of_repose"], "deg")))
        value = f"{_rounded(diameters * _diameter(material) * slope**power)} mm"
    return target if value is None else re.sub(r'value = "[^"]*"', f'value = "{value}"', target)


def _diameter(material: StartingMaterial) -> float:
    return to_unit(material.sections["particle"]["diameter"].value, "mm")


def _rounded(value: float) -> str:
    return f"{float(f'{value:.3g}'):g}"
