"""Write the input of the heap test for a solver into a run folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from grainfit.bulk_tests.heap.setup import HeapSetup
from grainfit.bulk_tests.shared import mesh
from grainfit.bulk_tests.shared.packing import Column, random_column
from grainfit.contact_models.base import ContactLaw
from grainfit.contact_models.contact import Contact, particle_mass
from grainfit.contact_models.lammps import lammps_clauses, lammps_words
from grainfit.contact_models.liggghts import liggghts_model, liggghts_properties
from grainfit.contact_models.registry import contact_law, with_defaults
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.time_step import rayleigh_time_step

_TEMPLATES = {"lammps": "in.lammps.j2", "liggghts": "in.liggghts.j2"}
_PARTICLES = "particles.data"


@dataclass(frozen=True)
class HeapDeck:
    """Everything that determines the input of one run, except the seed.

    Parameters
    ----------
    setup : HeapSetup
        Geometry and procedure.
    sizes : ParticleSizes
        Particle size distribution.
    material : mapping of str to float
        All material parameters by dotted name; those with a default may be missing.
    plate_sliding_friction, plate_rolling_friction : float
        Between particles and the plate; everything else of that contact is the wall's.
    time_step : float
        s.
    """

    setup: HeapSetup
    sizes: ParticleSizes
    material: Mapping[str, float]
    plate_sliding_friction: float
    plate_rolling_friction: float
    time_step: float

    def write(self, folder: Path, solver: str, seed: int) -> Path:
        """Write every file that the solver reads; return the one to start with."""
        setup = self.setup
        column = random_column(self.sizes, setup.particle_count, setup.cylinder_radius, seed)
        self._write_particles(folder / _PARTICLES, column, solver)
        values = self._common_values(column.height)
        if solver == "lammps":
            values |= self._lammps_values()
        else:
            values |= self._liggghts_values()
            self._write_meshes(folder, column.height)
        deck = folder / _TEMPLATES[solver].removesuffix(".j2")
        template = _environment().get_template(_TEMPLATES[solver])
        deck.write_text(template.render(values), encoding="utf-8")
        return deck

    def _cylinder_top(self, column_height: float) -> float:
        return column_height + 1.25 * max(self.sizes.diameters)

    def _write_meshes(self, folder: Path, column_height: float) -> None:
        setup = self.setup
        mesh.write_cylinder(
            folder / "cylinder.stl",
            setup.cylinder_radius,
            setup.cylinder_gap,
            self._cylinder_top(column_height),
            edge=0.95 * self.sizes.sauter_diameter,
        )
        mesh.write_plate(folder / "plate.stl", setup.plate_radius, setup.rim_height)

    def _box_bottom(self) -> float:
        return -3 * max(self.sizes.diameters)

    def _write_particles(self, path: Path, column: Column, solver: str) -> None:
        largest = max(self.sizes.diameters)
        side = self.setup.plate_radius + 1.5 * largest
        top = self._cylinder_top(column.height) + self.setup.lift_height + 2 * largest
        types = 3 if solver == "liggghts" else len(self.sizes.diameters)
        header = (
            f"Random column of particles: id type diameter density x y z\n\n"
            f"{len(column.positions)} atoms\n{types} atom types\n\n"
            f"{-side!r} {side!r} xlo xhi\n{-side!r} {side!r} ylo yhi\n"
            f"{self._box_bottom()!r} {top!r} zlo zhi\n\nAtoms\n"
        )
        kinds = column.size_indices + 1 if solver == "lammps" else np.ones_like(column.size_indices)
        diameters = np.array(self.sizes.diameters)[column.size_indices]
        density = self.material["particle.density"]
        rows = (
            f"{number} {kind} {diameter!r} {density!r} {x:.12g} {y:.12g} {z:.12g}"
            for number, (kind, diameter, (x, y, z)) in enumerate(
                zip(kinds.tolist(), diameters.tolist(), column.positions.tolist(), strict=True), 1
            )
        )
        path.write_text(header + "\n" + "\n".join(rows) + "\n", encoding="ascii")

    def _steps(self, time: float) -> int:
        return max(1, round(time / self.time_step))

    def _common_values(self, column_height: float) -> dict[str, Any]:
        setup = self.setup
        shares = zip(self.sizes.number_fractions, self.sizes.diameters, strict=True)
        mass = setup.particle_count * sum(share * self._mass(d / 2) for share, d in shares)
        return {
            "particle_count": setup.particle_count,
            "skin": 0.3 * self.sizes.sauter_diameter,
            "time_step": self.time_step,
            "gravity": setup.gravity,
            "cylinder_radius": setup.cylinder_radius,
            "cylinder_bottom": setup.cylinder_gap,
            "cylinder_top": self._cylinder_top(column_height),
            "plate_radius": setup.plate_radius,
            "rim_height": setup.rim_height,
            "box_bottom": self._box_bottom(),
            "strike_off_height": setup.strike_off_height,
            "lift_speed": setup.lift_speed,
            "largest_radius": max(self.sizes.diameters) / 2,
            "energy_at_rest": mass * setup.quiet_speed**2 / 2,
            # All particles falling through the whole column at once would not reach this.
            "energy_limit": mass * setup.gravity * column_height,
            "check_steps": self._steps(setup.check_interval),
            "fill_steps": self._steps(setup.fill_time),
            "fill_step_limit": self._steps(setup.fill_time + setup.settling_time_limit),
            "lift_steps": self._steps(setup.lift_height / setup.lift_speed),
            "heap_step_limit": self._steps(setup.settling_time_limit),
        }

    def _mass(self, radius: float) -> float:
        return particle_mass(self.material, radius)

    @property
    def _law(self) -> ContactLaw:
        return contact_law(self.material)

    def _walls(self) -> dict[str, dict[str, float]]:
        """Material for the contacts with each kind of wall."""
        cylinder = with_defaults(self.material)
        plate = cylinder | {
            "particle_wall.sliding_friction": self.plate_sliding_friction,
            "particle_wall.rolling_friction": self.plate_rolling_friction,
        }
        return {"cylinder": cylinder, "plate": plate}

    def _liggghts_values(self) -> dict[str, Any]:
        properties = liggghts_properties(self._law, list(self._walls().values()))
        return {"contact_model": liggghts_model(self._law), "properties": properties}

    def _lammps_values(self) -> dict[str, Any]:
        law, gravity, walls = self._law, self.setup.gravity, self._walls()
        radii = [diameter / 2 for diameter in self.sizes.diameters]
        material = walls["cylinder"]
        pairs = [
            {
                "i": i,
                "j": j,
                "clauses": lammps_clauses(law, Contact.between(material, radius, other, gravity)),
            }
            for i, radius in enumerate(radii, 1)
            for j, other in enumerate(radii[i - 1 :], i)
        ]
        if self.setup.rim_height > 0:
            walls["rim"] = walls["plate"]
        return {
            "sizes": len(radii),
            "legend": [words.legend for words in lammps_words(law) if words.legend],
            "pairs": pairs,
            "walls": {
                region: [
                    lammps_clauses(law, Contact.on_wall(wall, radius, gravity)) for radius in radii
                ]
                for region, wall in walls.items()
            },
        }


def heap_time_step(sizes: ParticleSizes, material: Mapping[str, float], fraction: float) -> float:
    """Return the time step of a heap test, s: a fraction of the Rayleigh time step."""
    return fraction * rayleigh_time_step(
        sizes.smallest_radius,
        material["particle.density"],
        material["particle.youngs_modulus"],
        material["particle.poissons_ratio"],
    )


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("grainfit.bulk_tests.heap", "decks"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,
    )
