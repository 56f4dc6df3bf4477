"""How much faster MPI ranks make a run."""

from __future__ import annotations

import json
from pathlib import Path
from statistics import median

import pytest

from grainfit.solvers.speed import gain_of_ranks

ROWS = Path(__file__).parents[2] / "benchmarks" / "data" / "ranks.jsonl"


def measured() -> dict[int, float]:
    """Return how many times as fast two ranks are as one, by the number of particles."""
    rows = [json.loads(line) for line in ROWS.read_text(encoding="utf-8").splitlines()]
    found: dict[int, list[float]] = {}
    for test, count in {(row["test"], row["particles"]) for row in rows}:
        own = [row for row in rows if (row["test"], row["particles"]) == (test, count)]
        alone, shared = (
            median(row["seconds"] for row in own if row["way"] == way)
            for way in ("alone", "two ranks")
        )
        found.setdefault(count, []).append(alone / shared)
    return {count: sum(gains) / len(gains) for count, gains in found.items()}


def test_the_gain_of_two_ranks_is_what_was_measured() -> None:
    found = measured()

    assert {1500, 50_000} <= found.keys()
    for count, gain in found.items():
        assert gain_of_ranks(2, count) == pytest.approx(gain, rel=0.12), count


def test_more_ranks_gain_more_but_never_more_than_their_number() -> None:
    gains = [gain_of_ranks(ranks, 50_000) for ranks in (1, 2, 3, 4, 8, 64)]

    assert gains[0] == 1
    assert gains == sorted(gains)
    assert all(gain < ranks for gain, ranks in zip(gains[1:], (2, 3, 4, 8, 64), strict=True))
    assert gain_of_ranks(4096, 1500) == gain_of_ranks(16, 1500)
