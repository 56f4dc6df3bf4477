"""A new release of LAMMPS is admitted by rows that it makes again, not by its version."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.atlas_rows import OUTCOMES, admitted_programs, made, publish, record, write_rows
from benchmarks.sentinels import COUNT, compare, sentinels
from grainfit.atlas.row import Row, rows_in
from grainfit.atlas.shelf import SHIPPED, Atlas

NEXT = "LAMMPS 1 Jan 2030"
ATLAS = Atlas()


def again(change: Callable[[float, int], float]) -> list[tuple[str, Row]]:
    """Return the sentinels as the next release would make them."""
    return [
        (
            test,
            replace(
                row,
                program=NEXT,
                responses={
                    name: (change(value, number), error)
                    for name, (value, error) in row.responses.items()
                },
            ),
        )
        for number, (test, row) in enumerate(sentinels(ATLAS))
    ]


def test_twenty_cheap_rows_of_several_tests_are_sentinels() -> None:
    chosen = sentinels(ATLAS)

    assert len(chosen) == COUNT == 20
    assert len({test for test, _ in chosen}) >= 4
    assert sum(row.seconds for _, row in chosen) < 120
    assert not any(row.why for _, row in chosen)


def test_a_release_that_changes_what_packings_do_is_admitted() -> None:
    random = np.random.default_rng(1)
    scattered = random.normal(0.0, 0.003, COUNT)

    found = compare(ATLAS, again(lambda value, number: value * (1 + scattered[number])))

    assert 0 < found.largest < found.limit
    assert found.agrees
    assert found.to_plain()["program"] == NEXT


def test_a_release_that_shifts_responses_is_not_admitted() -> None:
    assert not compare(ATLAS, again(lambda value, _: 1.3 * value)).agrees
    # Each within its error, all to one side.
    dense = compare(ATLAS, again(lambda value, _: 1.02 * value))
    assert max(map(abs, dense.shifts.values())) > dense.largest
    one = again(lambda value, _: value)
    assert not compare(ATLAS, one[:-1]).agrees
    without = [(test, replace(row, responses={})) for test, row in one[:1]]
    assert not compare(ATLAS, [*without, *one[1:]]).agrees


def test_outcomes_are_kept_with_the_package(tmp_path: Path) -> None:
    path = tmp_path / "admitted.json"
    shutil.copy(OUTCOMES, path)
    same = compare(ATLAS, again(lambda value, _: value)).to_plain()

    record(same, path)
    assert NEXT in admitted_programs(path)
    record({**same, "agrees": False}, path)
    assert admitted_programs(path) == admitted_programs()


def test_the_rows_that_ship_are_of_admitted_programs() -> None:
    for name in ATLAS.strata:
        programs = {row.program for row in rows_in(SHIPPED / f"{name}.jsonl")} - {""}
        assert programs <= admitted_programs(), name


def test_rows_of_a_release_that_was_not_compared_are_not_published(tmp_path: Path) -> None:
    rows = rows_in(SHIPPED / "packing.jsonl")
    later = [replace(row, program=NEXT) for row in rows[:3]]
    write_rows([*later, *rows[3:]], tmp_path / "packing.jsonl")
    (tmp_path / "published").mkdir()

    said = list(publish(tmp_path, tmp_path / "published"))

    assert said[0].startswith(f"packing: 3 rows of {NEXT} are left out")
    assert said[1].startswith(f"packing: {len(rows) - 3} rows")


@pytest.mark.slow
def test_the_installed_lammps_makes_a_sentinel_again() -> None:
    from grainfit.atlas.strata import strata

    made_again = [
        (test, made(strata()[test], row.number, inputs=row.inputs))
        for test, row in sentinels(ATLAS)[:2]
    ]

    found = compare(ATLAS, made_again)
    assert found.largest <= found.limit
