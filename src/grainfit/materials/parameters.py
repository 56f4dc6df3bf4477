"""Material parameters: their declaration, and those of the two bodies of a contact.

The parameters of the contact itself are declared by the contact models; all of them together are
in `grainfit.contact_models.registry`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from grainfit.materials.particle_shape import ASPECT_RATIO, LARGEST_ASPECT_RATIO
from grainfit.materials.walls import on_wall
from grainfit.options.kinds import Quantity


@dataclass(frozen=True)
class MaterialParameter:
    """Name, unit, physical limits and default of a DEM material parameter.

    Parameters
    ----------
    name : str
        Dotted name as in the calibration file, ``section.key``.
    symbol, unit, description : str
        For axis labels and help; the unit is SI, ``""`` when dimensionless.
    lowest, highest : float
        Physical limits (inclusive) that no interval may leave.
    default : float, optional
        Value when it is not given, at which the parameter has no effect. A
        parameter without a default must be given. At its default it is not part of a run's
        identity, so that a new parameter does not change earlier runs.
    example : str
        A good value, as TOML.
    coarse_graining_power : float
        Power of the factor of coarse graining with which simulated particles have the value.
    """

    name: str
    symbol: str
    unit: str
    description: str
    lowest: float
    highest: float
    default: float | None = None
    example: str = ""
    coarse_graining_power: float = 0.0

    @property
    def possible(self) -> Quantity:
        """Values that are physically possible."""
        return Quantity(self.unit, self.lowest, self.highest)

    @property
    def section(self) -> str:
        """Section of the calibration file."""
        return self.name.partition(".")[0]

    @property
    def key(self) -> str:
        """Key in its section, or in that of its wall."""
        return self.name.rpartition(".")[2]

    def missing(self) -> str:
        """Return what its declaration lacks, in words; empty if that is nothing."""
        if self.section not in SECTIONS:
            return f"its section is none of {', '.join(SECTIONS)}"
        texts = ("symbol", "description", "example")
        if gaps := [name for name in texts if not getattr(self, name)]:
            return f"{' and '.join(gaps)} missing"
        if not (math.isfinite(self.lowest) and self.lowest < self.highest):
            return "its limits are no interval"
        return ""

    def of_wall(self, wall: str) -> MaterialParameter:
        """Return the same parameter of a wall with a name.

        Examples
        --------
        >>> BODY_PARAMETERS[1].of_wall("steel").symbol
        'E_w_steel'
        """
        # Underscores part the words of an index.
        return replace(
            self,
            name=on_wall(self.name, wall),
            symbol=f"{self.symbol}_{wall.replace('_', ' ')}",
            description=f"{self.description} ({wall})",
        )


#: Sections in the order of the calibration file: their words in a description, index of symbols.
SECTIONS = {
    "particle": ("particle", "p"),
    "wall": ("wall", "w"),
    "particle_particle": ("particle-particle", "pp"),
    "particle_wall": ("particle-wall", "pw"),
}
BODIES = ("particle", "wall")
CONTACTS = ("particle_particle", "particle_wall")


def declare(
    sections: Iterable[str],
    key: str,
    symbol: str,
    unit: str,
    description: str,
    limits: tuple[float, float],
    default: float | None = None,
    example: str = "",
    coarse_graining_power: float = 0.0,
) -> tuple[MaterialParameter, ...]:
    """Declare the same parameter in several sections, see `MaterialParameter`.

    Examples
    --------
    >>> [p.symbol for p in declare(CONTACTS, "restitution", "e", "", "restitution", (0.01, 1.0))]
    ['e_pp', 'e_pw']
    """
    return tuple(
        MaterialParameter(
            f"{section}.{key}",
            f"{symbol}_{SECTIONS[section][1]}",
            unit,
            f"{SECTIONS[section][0]} {description}",
            *limits,
            default,
            example,
            coarse_graining_power,
        )
        for section in sections
    )


#: Elasticity and density of particles and walls, and the shape of particles.
BODY_PARAMETERS = (
    *declare(
        BODIES, "youngs_modulus", "E", "Pa", "Young's modulus", (1e3, 1e13), example='"0.36 MPa"'
    ),
    *declare(BODIES, "poissons_ratio", "ν", "", "Poisson's ratio", (0.0, 0.4999), example="0.22"),
    *declare(
        BODIES,
        "density",
        "ρ",
        "kg/m^3",
        "density of the solid",
        (1.0, 3e4),
        example='"2100 kg/m^3"',
    ),
    MaterialParameter(
        ASPECT_RATIO,
        "L/D_p",
        "",
        "particle aspect ratio: largest extent over the width, of a shape that has one",
        1.0,
        LARGEST_ASPECT_RATIO,
        default=1.0,
        example="1.5",
    ),
)
