"""Parameter sets simulated outside a calibration."""

from __future__ import annotations

import time
from pathlib import Path

import grainfit as gf
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.study import ExpectedWork, Study, simulate_study
from grainfit.evaluation import Proposal


def slow(parameters: dict[str, float], seed: int) -> dict[str, float]:
    time.sleep(0.2)
    return {"angle": 10 * parameters["friction"] + seed}


def study(max_seconds: float | None = None) -> Study:
    proposals = [Proposal({"friction": 0.1}, seed, "design") for seed in range(1, 11)]
    solvers = {"heap": gf.solvers.PythonCallable(slow, ["angle"])}
    return Study(solvers, proposals, CampaignOptions(), max_seconds)


def test_a_study_stops_in_time_and_keeps_what_has_ended(tmp_path: Path) -> None:
    part = simulate_study(study(max_seconds=0.7), tmp_path)
    assert len(part) < 10
    works: list[ExpectedWork] = []
    done: list[tuple[int, int]] = []
    whole = simulate_study(study(), tmp_path, works.append, lambda *n: done.append(n))
    assert len(whole) == 10
    assert works[0].known >= len(part)
    assert works[0].known + works[0].runs == 10
    assert done[-1] == (10, 10)
