"""The published silo, drum and sandpile: what is measured on them, and what is kept."""

from __future__ import annotations

import numpy as np
import pytest

from studies.benchmarks import drum_parts, sandpile, silo
from studies.benchmarks.page import kept_records

KEPT = kept_records()


def test_all_silos_of_lammps_are_kept() -> None:
    assert set(KEPT.silos) >= set(silo.all_silos(["lammps"]))


def test_spheres_fill_the_silo_without_touching_anything() -> None:
    orifice = 0.03
    column = silo.filling(20_000, orifice, 1)
    x, y, z = column.positions.T
    radius = silo.DIAMETER / 2
    assert z.min() > radius
    assert (np.hypot(x, y) < silo.RADIUS - radius).all()
    # Distance from a cone of 45 degrees.
    assert ((orifice + z - np.hypot(x, y)) / np.sqrt(2)).min() > radius
    apart = np.linalg.norm(np.diff(column.positions[:400], axis=0), axis=1)
    assert apart.min() > silo.DIAMETER


def test_a_small_silo_flows() -> None:
    found = silo.simulate(silo.Silo("lammps", 60, 1e6, 500, 0.1, 1))
    left = np.array(found["left"])
    assert left[0] == 500
    assert (np.diff(left) <= 0).all()
    # It flows for 60 to 80 ms, at less than the rate of a full silo.
    assert 300 < 500 - left[-1] <= 0.1 * 25_000


def test_a_steady_flow_has_its_rate_without_its_beginning() -> None:
    times = np.linspace(0, 0.5, 101)
    left = 1000 - 600 * np.maximum(times - 0.05, 0)
    found = silo.flow({"times": times.tolist(), "left": left.tolist()})
    assert found.rate == pytest.approx(600)
    assert found.error == pytest.approx(0, abs=1e-6)
    assert (found.most, found.fewest) == pytest.approx((970, 730))


def test_published_flows_are_those_of_the_curves() -> None:
    # 76,015 and 51,271 spheres are left after 1 and 2 s.
    assert silo.published_rate("liggghts", 60, 76015, 51271) == pytest.approx(24744)
    assert np.isnan(silo.published_rate("musen", 40, 14000, 11000))


def test_every_change_of_the_drum_is_kept() -> None:
    parts = [part for _, part in drum_parts.chain()]
    assert set(parts[:6]) <= set(KEPT.drums)
    assert len(set(parts)) == len(parts)


def test_a_triangle_of_spheres_has_its_height_and_slope() -> None:
    d, rows = 0.01, 24
    x, z = (
        np.concatenate(part)
        for part in zip(
            *(
                ((np.arange(rows - n) - (rows - n - 1) / 2) * d, np.full(rows - n, n * 0.866 * d))
                for n in range(rows)
            ),
            strict=True,
        )
    )
    on_floor = z + d / 2 - sandpile.LENGTH - sandpile.FALL
    spheres = np.column_stack([x, 0 * x, on_floor, np.full(len(x), d / 2)])
    height, slope = sandpile.measured(spheres)
    assert height == pytest.approx(((rows - 1) * 0.866 + 1) * d)
    assert slope == pytest.approx(60, abs=1.5)
