"""Origin of a calibration, stored with its runs, so that a report can say how to repeat it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from grainfit.materials.sizes import ParticleSizes
from grainfit.one_line import OneLine


@dataclass(frozen=True)
class Provenance(OneLine):
    """The calibration file and its values for the material.

    It does not influence the simulations.

    Parameters
    ----------
    file, text : str
        Name of the calibration file, without its folder, and its content.
    fixed : mapping of str to float
        Parameters that are not free, by name, in SI units.
    units : mapping of str to str
        SI units of the parameters that have one.
    laboratory : mapping of str to mapping
        Definitions of the tests of which a smaller apparatus is simulated, by name.
    pictures : mapping of str to mapping of str to str
        Hashes of the photographs that the targets were measured on, by response and file.
    particles : mapping of str to object
        Definition of the particle sizes of the file; empty without any.
    options : mapping of str to sequence of str
        Options of the tests that the file gives, itself or by an instrument, by name of the test.
    contact_models : tuple of str
        Contact models of the file that replace the usual ones.
    """

    file: str = ""
    text: str = ""
    fixed: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    laboratory: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    pictures: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    particles: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Sequence[str]] = field(default_factory=dict)
    contact_models: tuple[str, ...] = ()

    @property
    def sizes(self) -> ParticleSizes | None:
        """The particle sizes; None where they are not known."""
        return ParticleSizes.from_definition(self.particles) if self.particles else None

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Provenance:
        """Read stored data; values that an older version did not store are empty."""
        return cls(
            file=str(data.get("file", "")),
            text=str(data.get("text", "")),
            fixed={str(name): float(value) for name, value in data.get("fixed", {}).items()},
            units={str(name): str(unit) for name, unit in data.get("units", {}).items()},
            laboratory=dict(data.get("laboratory", {})),
            pictures=data.get("pictures", {}),
            particles=dict(data.get("particles", {})),
            options=dict(data.get("options", {})),
            contact_models=tuple(map(str, data.get("contact_models", ()))),
        )
