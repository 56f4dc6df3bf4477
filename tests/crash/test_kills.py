"""A calibration that is killed, wherever it is, goes on when it is started again.

Nothing that was finished is lost or made again, and the answer is that of a calibration that nobody
disturbed. Runs are counted by the program itself, see `tests.crash.crash_harness`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.crash.crash_harness import (
    VARIANTS,
    Tally,
    Variant,
    damage_stores,
    fill_disks,
    kill_at_random,
    kill_pool_workers,
    kill_solvers,
    remove_folders,
    small_disk,
    truncate_newest,
)

TRUNCATED = Variant("files truncated", same_history=False)


def assert_nothing_happened(tally: Tally, injected: int) -> None:
    assert tally.injected == injected
    assert not tally.lost
    assert not tally.repeated
    assert not tally.different


@pytest.mark.parametrize("kills", [10, pytest.param(30, marks=pytest.mark.thorough)])
def test_a_calibration_killed_at_random_moments_comes_to_the_same_answer(
    kills: int, tmp_path: Path
) -> None:
    assert_nothing_happened(kill_at_random(VARIANTS[0], kills, tmp_path), kills)


@pytest.mark.parametrize(
    "variant",
    [
        pytest.param(variant, marks=[pytest.mark.thorough] * (variant.strategy != "sequential"))
        # The first variant is that of the kills above.
        for variant in VARIANTS[1:]
    ],
    ids=lambda variant: variant.name,
)
def test_a_killed_calibration_goes_on_and_repeats_no_finished_run(
    variant: Variant, tmp_path: Path
) -> None:
    assert_nothing_happened(kill_at_random(variant, 5, tmp_path, seed=2), 5)


def test_a_killed_solver_is_started_again_and_costs_no_other_run(tmp_path: Path) -> None:
    assert_nothing_happened(kill_solvers(6, tmp_path), 6)


def test_a_killed_worker_of_a_pool_ends_in_a_message_and_the_next_start_goes_on(
    tmp_path: Path,
) -> None:
    assert_nothing_happened(kill_pool_workers(3, tmp_path), 3)


def test_files_that_a_power_cut_left_incomplete_give_no_wrong_number(tmp_path: Path) -> None:
    tally = kill_at_random(TRUNCATED, 3, tmp_path, disturb=truncate_newest)
    assert_nothing_happened(tally, 3)


def test_a_store_cut_short_is_made_again_by_following_the_message(tmp_path: Path) -> None:
    assert_nothing_happened(damage_stores(6, tmp_path), 6)


def test_folders_removed_at_work_end_in_a_message_or_another_try(tmp_path: Path) -> None:
    assert_nothing_happened(remove_folders(4, tmp_path), 4)


def test_a_full_disk_ends_in_a_message_and_the_next_start_goes_on(tmp_path: Path) -> None:
    try:
        with small_disk(tmp_path / "trial", 2**20):
            pass
    except PermissionError as error:
        pytest.skip(str(error))
    assert_nothing_happened(fill_disks(4, tmp_path / "disks"), 4)
