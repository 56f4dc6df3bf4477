"""Compare tangential laws: oblique impacts that stick, and the energy of a gas that sticks.

LAMMPS has several laws, which tell what a difference between programs comes from: the force as
stiffness times displacement (``mindlin``, as grainfit uses it), sums of force increments
(``mindlin/force``), and both with a smaller force while a contact unloads (``mindlin_rescale``).

    python -m benchmarks.tangential_laws

Prints the tangential restitution of Chung & Ooi's fourth impact over the angle of incidence, and
the share of the kinetic energy that 512 spheres without gravity keep (restitution 1, friction 10).
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from grainfit.bulk_tests.heap import Heap
from grainfit.contact_models.contact import Contact
from grainfit.contact_models.hertz_mindlin.lammps import HertzMindlinLammps
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Scene
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.impact_contract import (
    TANGENTIAL_RESTITUTION,
    ImpactContract,
    impact_material,
)
from grainfit.testing.materials import GLASS_BEADS
from studies.benchmarks.gas import gas_scene

LAWS = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
BODY = "oxide"


@contextmanager
def tangential_law(law: str) -> Iterator[None]:
    """Let decks of LAMMPS have another tangential law."""
    usual = HertzMindlinLammps.clauses

    def clauses(self: HertzMindlinLammps, contact: Contact) -> Mapping[str, str]:
        found = dict(usual(self, contact))
        found["tangential"] = found["tangential"].replace("mindlin", law, 1)
        return found

    with patch.object(HertzMindlinLammps, "clauses", clauses):
        yield


def simulate(solver: str, scene: Scene) -> RunOutput:
    """Run a scene on a solver."""
    folder = Path(tempfile.mkdtemp())
    return DEM_PROGRAMS[solver](Heap(diameter="10 mm"), {}).simulate(scene, Workspace(folder))


def tangential_restitution(solver: str) -> list[float]:
    """Return the tangential restitution at each angle of incidence."""
    body, published = TANGENTIAL_RESTITUTION[BODY]
    angles = np.radians(list(published))
    before = 3.9 * np.column_stack((np.sin(angles), np.zeros(len(angles)), -np.cos(angles)))
    values = impact_material(body, 0.98, 0.092)
    after = ImpactContract._rebounds(
        lambda scene: simulate(solver, scene), values, 0.0025, before, 0.0025
    )
    return (after[:, 0] / before[:, 0]).tolist()


def energy_kept(solver: str) -> float:
    """Return the share of the kinetic energy that a gas of sticking spheres keeps."""
    values = {name: 0.0 if "rolling" in name else value for name, value in GLASS_BEADS.items()}
    contact = {"restitution": 1.0, "sliding_friction": 10.0}
    values |= {f"particle_particle.{name}": value for name, value in contact.items()}
    scene = replace(gas_scene(values, spacing=1.5, seconds=1.0, seed=1), time_step=1e-5)
    energy = simulate(solver, scene).series("gas")["energy"]
    return float(energy[-1] / scene.initial_energy)


def main() -> None:
    """Print a line for each law."""
    published = TANGENTIAL_RESTITUTION[BODY][1]
    print("angle of incidence, deg:", *(f"{angle:.1f}" for angle in published), "| energy kept")
    print("published:", *(f"{value:.3f}" for value in published.values()))
    for law in LAWS:
        with tangential_law(law):
            _show(f"LAMMPS, {law}", "lammps")
    for solver in ("liggghts", "yade"):
        _show(solver, solver)


def _show(name: str, solver: str) -> None:
    restitution = tangential_restitution(solver)
    print(f"{name}:", *(f"{value:.3f}" for value in restitution), f"| {energy_kept(solver):.3f}")


if __name__ == "__main__":
    main()
