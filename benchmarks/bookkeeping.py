"""Overhead of a run beyond its simulation: 1,000 runs of a function that takes no time.

Usage: python benchmarks/bookkeeping.py [--runs N] [--workers N] [--json PATH]
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path

from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.store.store import RunStore
from grainfit.evaluation import Proposal
from grainfit.solvers.own_model.python_callable import PythonCallable


def at_once(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """Simulate nothing."""
    return {"angle": parameters["friction"] + seed}


def milliseconds_per_run(runs: int, workers: int, folder: Path) -> float:
    """Return the wall time of a campaign per run, in a fresh folder or in one that has the runs."""
    solver = PythonCallable(at_once)
    started = time.perf_counter()
    with hold(folder):
        store = RunStore.in_folder(folder)
        campaign = Campaign({"function": solver}, store, folder, CampaignOptions(workers))
        asked = ended = 0
        while ended < runs:
            while asked < runs and campaign.has_free_worker:
                campaign.start(Proposal({"friction": asked / runs}, asked, "design"))
                asked += 1
            ended += len(campaign.wait())
        campaign.close()
        store.close()
    return 1e3 * (time.perf_counter() - started) / runs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        made = milliseconds_per_run(options.runs, options.workers, Path(folder))
        found = milliseconds_per_run(options.runs, options.workers, Path(folder))
    print(f"{options.runs} runs, {options.workers} workers, store on disk")
    print(f"made:  {made:6.2f} ms a run")
    print(f"found: {found:6.2f} ms a run")
    if options.json:
        options.json.write_text(json.dumps({"made_ms": made, "found_ms": found}))


if __name__ == "__main__":
    main()
