"""The published mixing drum: its filling, its two materials in decks, and what is compared."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from grainfit.bulk_tests.heap import Heap
from grainfit.measurement.particles import Particles
from studies.benchmarks import mixing_drum
from studies.benchmarks.mixing_drum import DIAMETERS, LENGTH, RADIUS, Drum
from studies.benchmarks.page import kept_records
from studies.benchmarks.two_materials import two_materials

KEPT = kept_records().mixed


def deck(solver: str, folder: Path) -> str:
    run = Drum(solver, 1e6, 1.0)
    program = two_materials(solver, mixing_drum.second(run))(Heap(diameter="2 mm"), {})
    return program.deck(mixing_drum.drum_scene(run), folder).write().read_text(encoding="utf-8")


def test_all_drums_of_lammps_are_kept() -> None:
    assert set(KEPT) >= set(mixing_drum.all_drums(["lammps"]))


def test_spheres_fill_the_drum_without_touching_anything() -> None:
    column = mixing_drum.filling()
    radii = np.array(DIAMETERS)[column.size_indices] / 2
    x, y, z = column.positions.T
    assert (np.hypot(y, z) + radii < RADIUS).all()
    assert (x > radii).all()
    assert (x < LENGTH - radii).all()
    tree = cKDTree(column.positions)
    pairs = tree.query_pairs(DIAMETERS[1], output_type="ndarray")
    apart = np.linalg.norm(column.positions[pairs[:, 0]] - column.positions[pairs[:, 1]], axis=1)
    assert (apart > radii[pairs].sum(axis=1)).all()
    # The small ones are above the large ones.
    assert z[column.size_indices == 0].min() > z[column.size_indices == 1].max()


def test_lammps_has_three_contacts_of_two_materials(tmp_path: Path) -> None:
    text = " ".join(deck("lammps", tmp_path).replace("&\n", "").split())
    for pair, modulus, restitution, friction in (
        ("1 1", 1e6, 0.5, 0.3),
        ("1 2", 2 / 3 * 1e6, 0.45, 0.2),
        ("2 2", 0.5e6, 0.4, 0.4),
    ):
        words = text.split(f"pair_coeff {pair} ")[1].split()
        assert float(words[1]) == pytest.approx(modulus)
        assert (float(words[2]), float(words[10])) == (restitution, friction)
    assert "set type 2 density 2000.0" in text


def test_liggghts_has_a_type_for_each_material(tmp_path: Path) -> None:
    text = " ".join(deck("liggghts", tmp_path).replace("&\n", "").split())
    assert "youngsModulus peratomtype 1000000.0 210000000.0 500000.0" in text
    assert "coefficientFriction peratomtypepair 3 0.3 0.2 0.2 0.2 0.2 0.2 0.2 0.2 0.4" in text
    assert "coefficientRestitution peratomtypepair 3 0.5 0.4 0.45 0.4 0.4 0.4 0.45 0.4 0.4" in text
    rows = (tmp_path / "particles.data").read_text().split("Atoms")[1].split("\n")
    types = [row.split()[1] for row in rows if row]
    assert (types.count("1"), types.count("3")) == mixing_drum.COUNTS


def test_spheres_are_counted_in_their_quarters() -> None:
    positions = np.array([[0, 1, 1], [0, -1, -1], [0, -1, -1], [0, 1, -1]], dtype=float)
    radii = np.array([0.001, 0.001, 0.002, 0.002])
    bed = Particles(positions, radii, np.ones(4))
    assert mixing_drum.counted(bed) == [1, 0, 1, 1]


def test_a_drum_that_is_late_has_its_lag() -> None:
    times = np.arange(0, 2, 0.05)
    late = {"times": times.tolist(), "counts": mixing_drum.expected(times - 0.04).tolist()}
    assert mixing_drum.lag(late) == pytest.approx(0.04, abs=0.006)
    assert mixing_drum.deviations(late).max() > mixing_drum.deviations(late, 0.04).max()
