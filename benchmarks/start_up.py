"""Processor time of the commands that only read, in a work folder with some hundred runs.

Usage: python benchmarks/start_up.py [--runs N] [--repeat N] [--json PATH]
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.evaluation import Response
from grainfit.run_definition import RunDefinition

COMMANDS = (
    ["--help"],
    ["--version"],
    ["status", "work"],
    ["runs", "list", "work"],
    ["check", "calibration.toml"],
)
EXAMPLE = Path(__file__).parents[1] / "examples" / "glass_beads" / "calibration.toml"
# An image of a container may forbid to keep compiled modules: each start would compile them again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
#: Programs to compare with: their ratio does not depend on the computer.
BARE = {"python": "pass", "python, numpy": "import numpy"}


def fill(folder: Path, runs: int) -> None:
    """Write a store of finished runs of the heap test."""
    model = {"solver": "lammps", "version": "22 Jul 2025", "test": {"type": "heap"}}
    store = RunStore.in_folder(folder)
    store.save_many(
        RunRecord(
            f"{number:032x}",
            "heap",
            "finished",
            RunDefinition(model, {"particle.density": 1500.0 + number}, number),
            {"angle_of_repose": Response(20.0 + 0.01 * number, 0.1)},
            seconds=5.0,
            ended=time.time(),
        )
        for number in range(runs)
    )
    store.close()


def processor_seconds(arguments: list[str], folder: Path) -> float:
    """Return user and system time of a program."""

    def used() -> float:
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = used()
    subprocess.run(arguments, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return used() - before


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--repeat", type=int, default=15)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    program = str(Path(sys.executable).with_name("grainfit"))
    programs = {name: [sys.executable, "-c", code] for name, code in BARE.items()}
    programs |= {" ".join(["grainfit", *command]): [program, *command] for command in COMMANDS}
    seconds: dict[str, list[float]] = {name: [] for name in programs}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "work").mkdir()
        fill(Path(folder) / "work", options.runs)
        shutil.copy(EXAMPLE, folder)
        # In turns, so that a busy computer slows all of them.
        for _ in range(options.repeat):
            for name, arguments in programs.items():
                seconds[name].append(processor_seconds(arguments, Path(folder)))
    found = {name: statistics.median(times) for name, times in seconds.items()}
    print(f"{'processor time':24}  median   least  x numpy")
    for name, median in found.items():
        ratio = median / found["python, numpy"]
        print(f"{name:24}  {median:4.2f} s  {min(seconds[name]):4.2f} s  {ratio:7.1f}")
    if options.json:
        options.json.write_text(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
