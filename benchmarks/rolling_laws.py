"""Compare rolling laws on the heap: agreement of solvers, time to rest, creep, scatter, time step.

Finished runs are kept in the file ``--kept`` and not repeated, so that the command can be stopped
and started again.

    python benchmarks/rolling_laws.py --kept benchmarks/data/rolling_laws.jsonl [--seeds 20]
        [--materials rough beads] [--solvers lammps liggghts yade] [--table]

The laws are EPSD with a rolling damping of 0.25, EPSD without, and EPSD2. Prints the angle of
repose with its scatter on each solver, the time from the end of the filling to rest, how far the
angle creeps in two further seconds, and the time steps.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np

from grainfit.bulk_tests.heap import Heap
from grainfit.errors import GrainfitError
from grainfit.evaluation import Response, scalars
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.run_output import STAGES, RunOutput, snapshot_file
from grainfit.scenes.scene import Stage
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_PLATE
from kept_runs import measure, read
from solver_agreement import MATERIALS

#: Rolling damping and contact models of each law.
LAWS: Mapping[str, tuple[float | None, tuple[str, ...]]] = {
    "epsd, damping 0.25": (0.25, ()),
    "epsd, damping 0": (0.0, ()),
    "epsd2": (None, ("epsd2",)),
}
DAMPING = ("particle_particle.rolling_damping", "particle_wall.rolling_damping")
CREEP = 2.0
Record = dict[str, Any]


class Run(NamedTuple):
    """One heap."""

    material: str
    law: str
    solver: str
    seed: int


def simulate(run: Run) -> Record:
    """Simulate a heap once, and two seconds more."""
    damping, models = LAWS[run.law]
    values = {n: v for n, v in MATERIALS[run.material].items() if n not in DAMPING}
    values |= {} if damping is None else dict.fromkeys(DAMPING, damping)
    try:
        test = Heap(diameter=0.01, **ROUGH_PLATE)
        program = DEM_PROGRAMS[run.solver](test, values, contact_models=models)
        scene = program._scene(program.run_parameters({}), run.seed)
        creep = Stage("creep", Elapsed(CREEP), snapshot="later")
        longer = replace(scene, stages=(*scene.stages, creep))
        with tempfile.TemporaryDirectory() as folder:
            out = program.simulate(longer, Workspace(Path(folder)))
            ends = {end.name: end for end in out.ends}
            _forget(out.folder / STAGES, "creep")
            at_rest = _measured(test, out)
            shutil.copy(out.folder / snapshot_file("later"), out.folder / snapshot_file("heap"))
            later = _measured(test, out)
    except GrainfitError as error:
        return {"why": str(error)}
    return {
        "angle": at_rest["angle_of_repose"].value,
        "density": at_rest["bulk_density"].value,
        "crept": later["angle_of_repose"].value - at_rest["angle_of_repose"].value,
        "to_rest": ends["heap"].time - ends["fill"].time,
        "steps": ends["heap"].step,
    }


def _forget(stages: Path, name: str) -> None:
    lines = stages.read_text().splitlines(keepends=True)
    stages.write_text("".join(line for line in lines if not line.startswith(f"{name},")))


def _measured(test: Heap, out: RunOutput) -> Mapping[str, Response]:
    """Measure the heap in the snapshot that is there now."""
    return scalars(test.measure(RunOutput(out.folder, 1, ["lift"])))


def table(records: Sequence[Record]) -> str:
    """Return the comparison in Markdown."""
    titles = ["material", "law", "solver", "runs", "angle of repose ± scatter, deg"]
    titles += ["filled to rest, s", "creep in 2 s, deg", "time steps"]
    lines = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    groups = sorted({(r["material"], r["law"], r["solver"]) for r in records})
    for group in groups:
        own = [r for r in records if (r["material"], r["law"], r["solver"]) == group]
        good = [r for r in own if "why" not in r]
        if len(good) < 2:
            continue
        angle, rest, crept, steps = (
            np.array([r[key] for r in good]) for key in ("angle", "to_rest", "crept", "steps")
        )
        cells = [
            *group,
            str(len(good)) + (f" of {len(own)}" if len(good) < len(own) else ""),
            f"{angle.mean():.2f} ± {angle.std(ddof=1):.2f}",
            f"{rest.mean():.2f} ± {rest.std(ddof=1):.2f}",
            f"{crept.mean():+.2f} ± {crept.std(ddof=1):.2f}",
            f"{np.median(steps):.0f}",
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--materials", nargs="+", choices=MATERIALS, default=list(MATERIALS))
    parser.add_argument("--laws", nargs="+", choices=LAWS, default=list(LAWS))
    parser.add_argument(
        "--solvers", nargs="+", choices=DEM_PROGRAMS, default=["lammps", "liggghts"]
    )
    parser.add_argument("--table", action="store_true", help="only print what is known")
    options = parser.parse_args()
    runs = [
        Run(material, law, solver, seed)
        for seed in range(1, options.seeds + 1)
        for material in options.materials
        for law in options.laws
        for solver in options.solvers
    ]
    if not options.table:
        measure(runs, options.kept, simulate)
    print(table(list(read(options.kept, Run).values())))


if __name__ == "__main__":
    main()
