"""Whatever a cell of a store contains, a command answers or names the file."""

from __future__ import annotations

import random
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from grainfit.campaign.store.store import STORE_NAME
from grainfit.errors import StoreError
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.status import read_status
from tests.crash.damaged_cells import READING, USES, complaints, damage_cell, finished_calibration


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finished_calibration(tmp_path_factory.mktemp("finished"))


@pytest.fixture
def copy(original: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(original, tmp_path / "copy"))


def test_whole_stores_are_read(copy: Path) -> None:
    for use in READING.values():
        use(copy)


@pytest.mark.parametrize("seed", range(30))
def test_damaged_cells_are_read_or_named(original: Path, tmp_path: Path, seed: int) -> None:
    assert not list(complaints(original, tmp_path, seed, READING))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60, 72))
def test_damaged_cells_end_reports_and_runs_with_a_message(
    original: Path, tmp_path: Path, seed: int
) -> None:
    assert not list(complaints(original, tmp_path, seed, USES))


@pytest.mark.slow
def test_whole_stores_are_reported_and_continued(copy: Path) -> None:
    for use in USES.values():
        use(copy)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("UPDATE runs SET seconds = 'long'", "table runs, row .*: seconds is 'long', not a finite"),
        ("UPDATE runs SET definition = '[1'", "table runs, row .*: definition is not JSON: '.1'"),
        ("UPDATE runs SET log_tail = x'ff'", "table runs, row .*: log_tail is b'.xff', not a text"),
        ("UPDATE runs SET ended = 1e300", "table runs, row .*: ended is 1e.300, not a time"),
        ("UPDATE runs SET test = NULL", "table runs, row .*: test is None, not a text"),
        ("UPDATE calibrations SET name = NULL", "table calibrations, row .*: name is None"),
        ("UPDATE calibrations SET status = 'over'", "table calibrations, row .*: status is 'over'"),
        ("UPDATE requests SET seed = 0.5", "table requests, row .*: seed is 0.5, not a whole"),
        ("UPDATE requests SET stage = 'x'", "table requests, row .*: stage is 'x', not one of"),
        ("UPDATE requests SET parameters = '{\"a\": 1.0}'", "its parameters are not those of"),
    ],
)
def test_damaged_cell_is_named(copy: Path, change: str, words: str) -> None:
    with closing(sqlite3.connect(copy / STORE_NAME)) as store:
        store.execute(change)
        store.commit()
    with pytest.raises(StoreError, match=words) as caught:
        SavedCalibration.open(copy)
    assert STORE_NAME in str(caught.value)


def test_large_contents_are_not_repeated_in_messages(copy: Path) -> None:
    with closing(sqlite3.connect(copy / STORE_NAME)) as store:
        store.execute("UPDATE requests SET stage = ?", ("x" * 5_000_000,))
        store.commit()
    with pytest.raises(StoreError) as caught:
        read_status(copy)
    assert len(str(caught.value)) < 600


def test_every_table_is_damaged(original: Path, tmp_path: Path) -> None:
    def damages() -> Iterator[str]:
        for seed in range(60):
            store = Path(shutil.copy(original / STORE_NAME, tmp_path / f"{seed}.sqlite"))
            yield damage_cell(store, random.Random(seed))

    assert {damage.partition(".")[0] for damage in damages()} == {
        "about",
        "calibrations",
        "requests",
        "runs",
    }
