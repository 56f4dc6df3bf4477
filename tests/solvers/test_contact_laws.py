"""The contact laws of the rendered heap decks, in the real solvers: the plate is the plate.

A few particles replace the column of the heap test; everything else of the deck stays as it is.
The contact laws themselves are tested by the contract of contact models.
"""

import math

import pytest
from small_heaps import each_solver

from grainfit.bulk_tests.heap import Heap
from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.particles import read_dump
from grainfit.solvers.base import Workspace
from grainfit.solvers.process.process import run_process
from grainfit.testing.decks import write_deck
from grainfit.testing.materials import GLASS_BEADS

RADIUS = 0.005
DENSITY = 2100.0
MASS = DENSITY * 4 / 3 * math.pi * RADIUS**3
GRAVITY = 9.81
MATERIAL = {
    **GLASS_BEADS,
    "particle.density": DENSITY,
    "wall.youngs_modulus": 2.0e5,
    "wall.poissons_ratio": 0.40,
    "particle_wall.restitution": 0.55,
}
#: Overlap of one particle resting on the plate.
RESTING = hertz_overlap(MASS * GRAVITY, particle_moduli(MATERIAL, "wall"), RADIUS)


def simulate(solver_type, folder, particles, seconds, rolling_damping=0.25, **options):
    """Let particles (position, velocity, angular velocity) move; return their final motion."""
    test = Heap(ParticleSizes((2 * RADIUS,)), time_step_fraction=0.01, **options)
    material = {**MATERIAL, "particle_wall.rolling_damping": rolling_damping}
    solver = solver_type(test, material)
    deck = write_deck(test, folder, solver.name, material, seed=1)
    data = folder / "particles.data"
    header = data.read_text().split("Atoms\n")[0].replace("1500 atoms", f"{len(particles)} atoms")
    atoms, motions = [], []
    for number, (position, velocity, spin) in enumerate(particles, 1):
        atoms.append(" ".join(map(str, (number, 1, 2 * RADIUS, DENSITY, *position))))
        motions.append(" ".join(map(str, (number, *velocity, *spin))))
    data.write_text(
        header + "Atoms\n\n" + "\n".join(atoms) + "\n\nVelocities\n\n" + "\n".join(motions) + "\n"
    )
    steps = round(seconds / test.time_step(MATERIAL))
    deck.write_text(
        deck.read_text().split("# --- fill")[0]
        + f"dump out all custom {steps} out.dump id x z vx vz omegay radius mass y\n"
        + f"dump_modify out sort id\nrun {steps}\n"
    )
    run_process(solver._command(deck), Workspace(folder, 60.0))
    assert len(read_dump(folder / "out.dump")) == len(particles)
    rows = (folder / "out.dump").read_text().strip().splitlines()[-len(particles) :]
    names = ("x", "z", "vx", "vz", "omegay")
    return [dict(zip(names, map(float, row.split()[1:6]), strict=True)) for row in rows]


@each_solver
def test_a_particle_rests_on_the_plate_at_hertz_overlap(solver_type, tmp_path):
    rest = ((0.0, 0.003, RADIUS - RESTING), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    [after] = simulate(solver_type, tmp_path, [rest], 0.05)
    assert RADIUS - after["z"] == pytest.approx(RESTING, rel=1e-3)


@each_solver
def test_sliding_decelerates_with_the_plates_friction(solver_type, tmp_path):
    slide = ((-0.03, 0.003, RADIUS - RESTING), (0.5, 0.0, 0.0), (0.0, 0.0, 0.0))
    options = {"plate_sliding_friction": 0.2, "plate_rolling_friction": 0.0}
    [after] = simulate(solver_type, tmp_path, [slide], 0.05, **options)
    assert 0.5 - after["vx"] == pytest.approx(0.2 * GRAVITY * 0.05, rel=0.03)


def rolling(speed):
    """Rolling along the plate without sliding."""
    return ((-0.03, 0.003, RADIUS - RESTING), (speed, 0.0, 0.0), (0.0, speed / RADIUS, 0.0))


@each_solver
def test_rolling_decelerates_with_five_sevenths_of_the_rolling_friction(solver_type, tmp_path):
    options = {"plate_sliding_friction": 0.5, "plate_rolling_friction": 0.05, "rolling_damping": 0}
    [after] = simulate(solver_type, tmp_path, [rolling(0.3)], 0.15, **options)
    assert 0.3 - after["vx"] == pytest.approx(5 / 7 * 0.05 * GRAVITY * 0.15, rel=0.03)
