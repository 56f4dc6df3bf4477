"""Parameter sets simulated outside a calibration."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.campaign.batch import ExpectedWork, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.evaluation import Proposal
from grainfit.testing.materials import GLASS_BEADS


def slow(parameters: dict[str, float], seed: int) -> dict[str, float]:
    time.sleep(0.2)
    return {"angle": 10 * parameters["friction"] + seed}


PROPOSALS = [Proposal({"friction": 0.1}, seed, "design") for seed in range(1, 11)]


def test_a_batch_stops_in_time_and_keeps_what_has_ended(tmp_path: Path) -> None:
    solvers = {"heap": gf.solvers.PythonCallable(slow, ["angle"])}
    options = CampaignOptions()
    part = simulate_batch(solvers, PROPOSALS, tmp_path, options, max_seconds=0.7)
    assert len(part) < 10
    works: list[ExpectedWork] = []
    done: list[tuple[int, int]] = []
    whole = simulate_batch(
        solvers, PROPOSALS, tmp_path, options, works.append, lambda *n: done.append(n)
    )
    assert len(whole) == 10
    assert works[0].known >= len(part)
    assert works[0].known + works[0].runs == 10
    assert done[-1] == (10, 10)


class _KnownError(Exception):
    """The expected work is known."""


def test_workers_without_a_run_shorten_nothing(tmp_path: Path) -> None:
    density = "particle.density"
    material = {name: value for name, value in GLASS_BEADS.items() if name != density}
    solver = gf.solvers.Lammps(gf.tests.Packing(diameter="10 mm"), material)
    works: list[ExpectedWork] = []

    def stop(work: ExpectedWork) -> None:
        works.append(work)
        raise _KnownError

    for seeds in (1, 4, 8):
        proposals = [Proposal({density: 2500.0}, seed, "design") for seed in range(1, seeds + 1)]
        with pytest.raises(_KnownError):
            simulate_batch({"packing": solver}, proposals, tmp_path, CampaignOptions(4), stop)

    cost = solver.estimate_cost({density: 2500.0})
    assert cost is not None
    assert [work.seconds for work in works] == pytest.approx(
        [cost.wall_seconds, cost.wall_seconds, 2 * cost.wall_seconds]
    )
