"""Damaged particles end in a message, and never in grids that fill the memory."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from grainfit.bulk_tests.own_scene.picture import ParticlesView, draw_particles
from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.measurement import bulk_density as bulk_density_module
from grainfit.measurement import height_map as height_map_module
from grainfit.measurement import messages
from grainfit.measurement.angle_of_repose import angle_of_repose_in
from grainfit.measurement.bulk_density import bulk_density, masses_between
from grainfit.measurement.grid import MOST_CELLS, require_grid
from grainfit.measurement.height_map import height_map
from grainfit.measurement.particles import Particles
from grainfit.measurement.silhouette import render_silhouette
from grainfit.work_folder.remeasure import measure_path

RADIUS = 0.0005


@pytest.fixture
def little_memory() -> Iterator[None]:
    tracemalloc.start()
    yield
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 300_000_000


def cone(count: int = 2000) -> NDArray[np.float64]:
    """Rows of x, y, z, radius and mass of a heap of 20 mm radius."""
    random = np.random.default_rng(1)
    x, y, z = random.uniform((-0.02, -0.02, RADIUS), (0.02, 0.02, 0.01), (count, 3)).T
    inside = z < 0.5 * (0.02 - np.hypot(x, y)) + RADIUS
    rows = np.column_stack((x, y, z, np.full(count, RADIUS), np.full(count, 1e-6)))
    return rows[inside]


def particles(rows: NDArray[np.float64]) -> Particles:
    return Particles(rows[:, :3].copy(), rows[:, 3].copy(), rows[:, 4].copy())


def dump(path: Path, rows: NDArray[np.float64]) -> Path:
    lines = [" ".join(map(repr, row)) for row in rows.tolist()]
    head = f"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: ATOMS x y z radius mass\n"
    path.write_text(head + "\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("column", "value", "count", "reason"),
    [
        pytest.param(3, 1e3, None, "no heap", id="all radii 1e3"),
        pytest.param(3, 1e3, 1, "silhouette: it would take a grid", id="one radius 1e3"),
        pytest.param(3, 1e-9, None, "no heap", id="all radii 1e-9"),
        pytest.param(3, 1e-9, 300, "silhouette: it would take a grid", id="most radii 1e-9"),
        pytest.param(3, 1e308, 1, "impossible radius", id="one radius 1e308"),
        pytest.param(3, 1e-320, 1, "impossible radius", id="one radius 1e-320"),
        pytest.param(0, 1e308, 1, "impossible position", id="one place 1e308"),
        pytest.param(2, -1e308, None, "impossible position", id="all heights -1e308"),
        pytest.param(4, 1e308, None, "impossible mass", id="all masses 1e308"),
    ],
)
@pytest.mark.usefixtures("little_memory")
@pytest.mark.filterwarnings("error")
def test_measure_says_what_is_wrong_with_absurd_particles(
    tmp_path: Path, column: int, value: float, count: int | None, reason: str
) -> None:
    rows = cone()
    rows[:count, column] = value
    with pytest.raises(NotMeasurableError, match=rf"heap\.dump: .*{reason}"):
        measure_path(dump(tmp_path / "heap.dump", rows))


def test_a_heap_is_measured_although_a_particle_flew_away(tmp_path: Path) -> None:
    rows = cone(20_000)
    alone = measure_path(dump(tmp_path / "heap.dump", rows))
    away = measure_path(
        dump(tmp_path / "away.dump", np.vstack([rows, [1e6, 0, 1e-3, RADIUS, 1e-6]]))
    )
    assert away["base_radius"].value == pytest.approx(alone["base_radius"].value, rel=1e-9)


@pytest.mark.parametrize("sides", [(1e4, 1e4), (np.inf, 1.0), (np.nan,), (MOST_CELLS + 1,)])
def test_a_grid_that_is_too_large_is_refused(sides: tuple[float, ...]) -> None:
    with pytest.raises(NotMeasurableError, match=messages.LARGE_GRID.pattern):
        require_grid("surface", *sides)


def test_a_grid_of_the_largest_size_is_accepted() -> None:
    require_grid("surface", MOST_CELLS / 2, 2)


@pytest.mark.usefixtures("little_memory")
def test_no_quantity_takes_a_grid_without_limit() -> None:
    fine, coarse = cone(), cone()
    fine[:300, 3], coarse[0, 3] = 1e-9, 1e3
    silhouette = render_silhouette(particles(cone()), 0.0, 0.02, 0.01, RADIUS / 10)
    for act in (
        lambda: height_map(particles(fine), -0.02, 0.02, 0.02, 0.0),
        lambda: height_map(particles(coarse), -0.02, 0.02, 0.02, 0.0),
        lambda: render_silhouette(particles(fine), 0.0, 0.02, 0.01, 1e-10),
        lambda: angle_of_repose_in([silhouette], [0.0], 2 * RADIUS, 1e-10),
        lambda: bulk_density(particles(fine[:300]), 0.02, 0.0, 0.01),
    ):
        with pytest.raises(NotMeasurableError, match=messages.LARGE_GRID.pattern):
            act()


def test_large_beds_are_measured_in_parts_with_the_same_result(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bed, planes = particles(cone()), np.linspace(0, 0.01, 11)
    whole, masses = height_map(bed, -0.02, 0.02, 0.02, 0.0), masses_between(bed, planes)
    monkeypatch.setattr(height_map_module, "_AT_ONCE", 2000)
    monkeypatch.setattr(bulk_density_module, "MOST_CELLS", 2000)
    parts = height_map(bed, -0.02, 0.02, 0.02, 0.0)

    assert np.array_equal(parts.heights, whole.heights)
    assert np.allclose(masses_between(bed, planes), masses, rtol=1e-12)


@pytest.mark.usefixtures("little_memory")
def test_absurd_particles_are_drawn_in_little_memory(tmp_path: Path) -> None:
    rows = cone(300)
    rows[0, 3], rows[1, 0] = 1e3, 1e8
    path = tmp_path / "end.png"

    draw_particles(path, particles(rows), "sand", {"angle": Response(20.0)})
    drawn = ParticlesView.of(particles(rows)).drawing()

    assert path.stat().st_size < 1_000_000
    assert drawn.half_width < 10_000
