"""Rows and metamodels of the atlas: grown, kept, checked, opened."""

from __future__ import annotations

import json
import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from benchmarks.atlas_rows import (
    grow,
    is_of_today,
    left_out_in_turn,
    likely_points,
    made,
    point,
    publish,
    write_rows,
)
from grainfit.atlas import messages
from grainfit.atlas.estimate import estimate_of
from grainfit.atlas.row import REPEATS, Row, rows_in
from grainfit.atlas.shelf import CONTENTS, SHIPPED, Atlas
from grainfit.atlas.strata import SIZE, strata
from grainfit.bulk_tests.parameter_names import SLIDING
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES

#: What ships in a wheel, bytes.
LARGEST = 5e6


def test_the_shipped_atlas_is_whole_and_small_enough_for_the_wheel() -> None:
    atlas = Atlas()

    assert {"heap", "packing"} <= set(atlas.strata)
    assert list(atlas.faults()) == []
    assert sum(path.stat().st_size for path in SHIPPED.iterdir()) < LARGEST


@pytest.mark.parametrize("name", Atlas().strata)
def test_shipped_rows_were_simulated_in_the_apparatus_that_their_inputs_mean(name: str) -> None:
    rows = rows_in(SHIPPED / f"{name}.jsonl")

    assert [row.number for row in rows if not is_of_today(strata()[name], row)] == []


def test_rows_of_another_apparatus_are_not_published(tmp_path: Path) -> None:
    rows = rows_in(SHIPPED / "packing.jsonl")
    other = replace(rows[0], inputs={**rows[0].inputs, "fill_height": 1.01})
    write_rows([other, *rows[1:]], tmp_path / "packing.jsonl")
    (tmp_path / "published").mkdir()

    assert list(publish(tmp_path, tmp_path / "published")) == [
        f"packing: {len(rows) - 1} rows, 1 responses"
    ]


@pytest.mark.slow
def test_a_shipped_row_comes_out_again() -> None:
    row = rows_in(SHIPPED / "packing.jsonl")[2]

    again = made(strata()["packing"], row.number)

    assert again.inputs == row.inputs
    density, error = row.responses["bulk_density"]
    assert again.responses["bulk_density"][0] == pytest.approx(density, abs=3 * error)


@pytest.mark.slow
def test_growing_continues_behind_a_line_that_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "packing.jsonl"
    kept = rows_in(SHIPPED / "packing.jsonl")[0].to_text()
    path.write_text(f"{kept}\n{kept[:50]}")

    with ThreadPoolExecutor(1) as pool:
        made_now = [row.number for row in grow(strata()["packing"], path, 2, pool, repeats=1)]

    assert made_now == [1, REPEATS]
    first, _, again = rows_in(path)
    assert (again.point, again.inputs) == (first.number, first.inputs)
    assert again.seed != first.seed


def test_points_without_a_response_are_left_for_later() -> None:
    stratum, known = strata()["packing"], rows_in(SHIPPED / "packing.jsonl")[:96]
    sliding = stratum.ranges[SLIDING]
    rows = [
        replace(row, responses={} if sliding.share(row.inputs[SLIDING]) < 0.5 else row.responses)
        for row in known
    ]
    design = {number: point(stratum, number) for number in range(1000, 1064)}

    likely = likely_points(stratum, rows, design, 0.5)

    shares = {number: sliding.share(inputs[SLIDING]) for number, inputs in design.items()}
    assert all(shares[number] > 0.4 for number in likely)
    assert {number for number, share in shares.items() if share > 0.6} <= {*likely}
    assert [*likely_points(stratum, rows, {number: {} for number in range(8)}, 0.0)] == [*range(8)]


def test_a_row_is_left_out_together_with_its_repeat() -> None:
    row = rows_in(SHIPPED / "packing.jsonl")[0]
    rows = [replace(row, number=number) for number in (0, 1, 2, REPEATS + 1)]

    parts = [*left_out_in_turn(rows, 3, np.random.default_rng(1))]

    assert sorted(one.number for _, left_out in parts for one in left_out) == [0, 1, 2]
    for stay, [left_out] in parts:
        assert left_out.point not in {one.point for one in stay}
        assert len(stay) == (2 if left_out.point == 1 else 3)


def test_opened_metamodels_predict_as_the_fitted_ones(tmp_path: Path) -> None:
    shutil.copy(SHIPPED / "packing.jsonl", tmp_path)
    (tmp_path / "published").mkdir()
    list(publish(tmp_path, tmp_path / "published"))

    found, shipped = (
        Atlas(tmp_path / "published").of_stratum("packing"),
        Atlas().of_stratum("packing"),
    )

    assert found is not None
    assert shipped is not None
    fitted, opened = found.models["bulk_density"], shipped.models["bulk_density"]
    points = np.random.default_rng(1).random((20, fitted.kriging.d))
    mean, variance = fitted.predict(points)
    assert mean == pytest.approx(opened.predict(points)[0], rel=1e-3)
    assert (variance > 0).all()


@pytest.mark.parametrize(
    "damage", ["changed", "gone", "revision", "no contents", "nonsense", "foreign"]
)
def test_a_damaged_or_foreign_atlas_tells_nothing(tmp_path: Path, damage: str) -> None:
    folder = tmp_path / "atlas"
    shutil.copytree(SHIPPED, folder)
    contents, rows = folder / CONTENTS, folder / "packing.jsonl"
    if damage == "changed":
        rows.write_text(rows.read_text().replace("bulk_density", "bulk_densitz", 1))
    elif damage == "gone":
        rows.unlink()
    elif damage == "revision":
        plain = json.loads(contents.read_text())
        plain["strata"]["packing"]["revision"] = "0.0"
        contents.write_text(json.dumps(plain))
    elif damage == "no contents":
        contents.unlink()
    elif damage == "foreign":
        contents.write_text('{"strata": ["packing"], "materials": {}}')
    else:
        contents.write_text("[1, 2")

    atlas = Atlas(folder)

    assert atlas.of_stratum("packing") is None
    if damage in ("changed", "gone", "revision"):
        assert "packing" in list(atlas.faults())
    else:
        assert not atlas.is_readable


def test_clumps_are_not_told_beside_other_rows_of_dry_spheres(tmp_path: Path) -> None:
    folder = tmp_path / "atlas"
    shutil.copytree(SHIPPED, folder)
    first, *others = rows_in(folder / "packing.jsonl")
    value, error = first.responses["bulk_density"]
    denser = replace(first, responses={"bulk_density": (1.01 * value, error)})
    write_rows([denser, *others], folder / "packing.jsonl")

    assert Atlas().of_stratum("packing-clumps") is not None
    assert Atlas(folder).of_stratum("packing-clumps") is None


def test_an_estimate_names_a_damaged_atlas_and_goes_on_without_it(tmp_path: Path) -> None:
    folder = tmp_path / "atlas"
    shutil.copytree(SHIPPED, folder)
    (folder / "packing.models.json").write_text("{}")
    material = {
        **ROUGH_SPHERES,
        "particle_particle.rolling_damping": 0.0,
        "particle_wall.rolling_damping": 0.0,
    }
    del material["particle.density"]
    solvers = {
        "heap": gf.solvers.Lammps(gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE), material),
        "bed": gf.solvers.Lammps(gf.tests.Packing(diameter="10 mm"), material),
    }
    targets = [gf.Target(f"{name}.bulk_density", 1300.0) for name in solvers]
    scopes = [gf.TestScope(n, [f"{n}.bulk_density"], ["particle.density"]) for n in solvers]
    density = gf.Parameter("particle.density", 1500.0, 3000.0)

    found = estimate_of(gf.Problem([density], targets, tests=scopes), solvers, Atlas(folder))

    assert [one.target.name for one in found.responses] == ["heap.bulk_density"]
    assert messages.DAMAGED.is_in(found.untold["bed.bulk_density"])


def test_the_chance_of_a_heap_falls_with_the_rolling_friction() -> None:
    surrogate = Atlas().of_stratum("heap")
    assert surrogate is not None
    model = surrogate.models["angle_of_repose"]
    points = np.full((2, model.kriging.d), 0.5)
    points[:, 1] = (0.02, 0.8)

    low, high = model.chance_at(points)

    assert low < 0.5 < high


def test_beyond_the_rows_the_error_grows_with_what_the_trend_adds() -> None:
    surrogate = Atlas().of_stratum("packing")
    assert surrogate is not None
    model = surrogate.models["bulk_density"]
    points = np.full((3, model.kriging.d), 0.5)
    size = list(strata()["packing"].ranges).index(SIZE)
    points[:, size] = (0.9, 1.0, 2.0)

    mean, variance = model.predict(points)

    assert mean[1] < mean[2]
    assert variance[2] > max(variance[:2]) + (0.4 * (mean[2] - mean[1])) ** 2


def test_a_row_survives_its_text() -> None:
    row = Row(3, 4, {"size": 1.0}, "0a1b", {"bulk_density": (0.6, 0.01)}, "", 1.5, "LAMMPS 1")

    assert Row.from_plain(json.loads(row.to_text())) == row
