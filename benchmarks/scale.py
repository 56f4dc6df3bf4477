"""Time of status, restart and warm start with a work folder of many finished runs.

The runs are those of the heap test, with definitions as LAMMPS has them and a folder each.

Usage: python benchmarks/scale.py [--runs N] [--json PATH]
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from rich.progress import track

from grainfit.calibration_file.build import CalibrationSetup, build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.reuse import models_of, runs_of
from grainfit.campaign.store.records import RequestRecord, RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import RECORD_NAME, recover, run_folder
from grainfit.evaluation import Proposal, Response
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.known_runs import nearest_runs
from grainfit.work_folder.status import read_status

EXAMPLE = Path(__file__).parents[1] / "examples" / "glass_beads" / "calibration.toml"
#: Each of them should take less than this, s.
GOAL = 1.0


def fill(folder: Path, setup: CalibrationSetup, count: int) -> list[Proposal]:
    """Write a work folder such as a calibration of so many runs leaves."""
    [(test, solver)] = setup.solvers.items()
    cube = maximin_latin_hypercube(100, setup.problem.dimension, 1)
    proposals = [
        Proposal(setup.problem.from_unit(cube[number % 100]), 1 + number, "design")
        for number in range(count)
    ]
    with closing(RunStore.in_folder(folder)) as store:
        store.begin_calibration("scale", setup.name, {})
        records = []
        for position, proposal in enumerate(track(proposals, "writing"), start=1):
            definition = solver.definition(proposal.parameters, proposal.seed)
            identity = definition.identity
            responses = {"bulk_density": Response(1500.0), "angle_of_repose": Response(22.0, 0.3)}
            record = RunRecord(
                identity, test, "finished", definition, responses, seconds=6.0, ended=position
            )
            records.append(record)
            run_folder(folder, identity).mkdir(parents=True)
            text = json.dumps(record.to_json())
            (run_folder(folder, identity) / RECORD_NAME).write_text(text)
            store.add_request(
                "scale",
                RequestRecord(
                    position, "design", dict(proposal.parameters), proposal.seed, {test: identity}
                ),
            )
        store.save_many(records)
    return proposals


def resume(folder: Path, setup: CalibrationSetup) -> None:
    """Open the work folder, read the history, and take all its runs from the store."""
    with hold(folder), closing(RunStore.in_folder(folder)) as store:
        recover(folder, store)
        campaign = Campaign(setup.solvers, store, folder, CampaignOptions())
        requests = store.requests("scale")
        campaign.fetch([run for request in requests for run in request.runs.values()])
        for request in requests:
            campaign.start(Proposal(request.parameters, request.seed, request.stage))
            [evaluation] = campaign.wait()
            assert evaluation.reused
        campaign.close()


def warm_start(folder: Path, setup: CalibrationSetup) -> None:
    """Read all runs and find those of the problem."""
    with closing(RunStore.read_only(folder)) as store:
        records = store.runs_of(models_of(setup.solvers))
        known = runs_of(setup.problem, setup.solvers, records)
    assert nearest_runs(setup.problem, known)


def command(folder: Path) -> None:
    """Run the command as a user does, including the start of Python."""
    program = [sys.executable, "-m", "grainfit", "status", str(folder)]
    subprocess.run(program, check=True, capture_output=True)


def seconds(work: Callable[[], object]) -> float:
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    setup = build_calibration(load_calibration_file(EXAMPLE))
    for solver in setup.solvers.values():
        solver.version()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fill(folder, setup, options.runs)
        figures = {
            "status": seconds(lambda: read_status(folder)),
            "grainfit status": seconds(lambda: command(folder)),
            "going on": seconds(lambda: resume(folder, setup)),
            "learning": seconds(lambda: warm_start(folder, setup)),
        }
    print(f"{options.runs:,} finished runs (goal: under {GOAL:g} s each)")
    for name, took in figures.items():
        print(f"{name:16} {took:6.2f} s")
    if options.json:
        options.json.write_text(json.dumps(figures))


if __name__ == "__main__":
    main()
