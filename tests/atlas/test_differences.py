"""How far other solvers are from the LAMMPS of the atlas, by rows that both made."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.atlas_rows import publish, write_rows
from grainfit.atlas.differences import FEWEST_PAIRS, Difference, difference, usual_difference
from grainfit.atlas.forecast import Forecast
from grainfit.atlas.row import rows_in
from grainfit.atlas.shelf import SHIPPED, Atlas, rows_of
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.problem import Problem
from grainfit.problem.parameter import Parameter
from grainfit.problem.target import Target
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES

#: The rows have no rolling damping.
_MATERIAL = ROUGH_SPHERES | {"particle_particle.rolling_damping": 0.0}


def test_the_mean_difference_and_what_scatter_does_not_explain_of_it_are_found() -> None:
    rng = np.random.default_rng(1)
    reference = rng.uniform(20.0, 40.0, 4000)
    scatter = np.full(4000, 0.03)
    shift = 1.05 + 0.02 * rng.standard_normal(4000)
    own = reference * shift * (1 + 0.03 * rng.standard_normal(4000))
    reference = reference * (1 + 0.03 * rng.standard_normal(4000))

    found = difference(own, reference, scatter)

    assert found.mean == pytest.approx(0.05, abs=0.005)
    assert found.spread == pytest.approx(0.02, abs=0.004)


def test_an_uncertain_mean_counts_where_scatter_explains_all() -> None:
    rng = np.random.default_rng(2)
    reference = np.full(9, 30.0)
    own = reference * (1 + 0.03 * rng.standard_normal(9))

    assert difference(own, reference, np.full(9, 0.2)).spread > 0.005


def _atlas_with_rows_of_liggghts(folder: Path, factor: float, count: int) -> Atlas:
    """Return an atlas of the packing with rows of LIGGGHTS that are LAMMPS's, but for a factor."""
    source, published = folder / "source", folder / "published"
    source.mkdir()
    published.mkdir()
    shutil.copy(SHIPPED / "packing.jsonl", source)
    rows = rows_in(source / "packing.jsonl")[:count]
    others = [
        replace(row, responses={n: (factor * v, e) for n, (v, e) in row.responses.items()})
        for row in rows
    ]
    write_rows(others, rows_of(source, "packing", "liggghts"))
    list(publish(source, published))
    return Atlas(published)


def _expected(atlas: Atlas, solver: str) -> tuple[float, float]:
    """Return mean and variance of a bulk density, in the middle of an interval of the friction."""
    test = bulk_tests()["packing"](diameter=0.01)
    sliding = Parameter("particle_particle.sliding_friction", 0.3, 0.7)
    problem = Problem((sliding,), (Target("bulk_density", "1300 kg/m^3"),))
    forecast = Forecast(problem, {"packing": DEM_PROGRAMS[solver](test, _MATERIAL)}, atlas)
    means, variances = forecast.predict([[0.5]])
    return float(means[0, 0]), float(variances[0, 0])


def test_a_forecast_for_another_solver_is_shifted_by_what_its_rows_tell(tmp_path: Path) -> None:
    atlas = _atlas_with_rows_of_liggghts(tmp_path, 0.98, 12)

    mean, variance = _expected(atlas, "lammps")
    other, of_other = _expected(atlas, "liggghts")

    assert other == pytest.approx(0.98 * mean, rel=1e-3)
    # No row differs from the others, and so nothing is added to the error.
    assert of_other == pytest.approx(0.98**2 * variance, rel=1e-3)


def test_without_enough_rows_a_usual_spread_is_assumed(tmp_path: Path) -> None:
    atlas = _atlas_with_rows_of_liggghts(tmp_path, 0.98, FEWEST_PAIRS - 1)

    mean, variance = _expected(atlas, "lammps")
    other, of_other = _expected(atlas, "liggghts")

    assert atlas.difference("liggghts", "packing", "bulk_density") is None
    assert other == mean
    spread = usual_difference("kg/m^3").spread
    assert of_other == pytest.approx(variance + (spread * mean) ** 2)


def test_a_damaged_difference_is_none(tmp_path: Path) -> None:
    folder = _atlas_with_rows_of_liggghts(tmp_path, 0.98, 12).folder
    contents = folder / "contents.json"
    atlas = Atlas(folder)
    assert isinstance(atlas.difference("liggghts", "packing", "bulk_density"), Difference)

    contents.write_text(contents.read_text().replace('"bulk_density": [', '"bulk_density": ["x",'))

    assert Atlas(folder).difference("liggghts", "packing", "bulk_density") is None
