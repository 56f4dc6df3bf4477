"""Compare the shear cell with plane shear, with and without cohesion, and measure its travel.

Rough spheres of 10 mm are sheared in the cell and in the shear test with all options at their
defaults, without cohesion and with surface energies (``jkr``), soft and stiff; the cell also with
shorter and longer preshears and failures (``--travel``). Finished runs are kept in the file
``--kept`` and not repeated, so that the command can be stopped and started again.

    python benchmarks/shear_cell.py --kept benchmarks/data/shear_cell.jsonl [--seeds 6]
        [--solvers lammps liggghts yade] [--energies 0 0.25 0.5] [--moduli 3.6e5 1e7] [--tests]
        [--travel] [--table]

Prints the mean of each response with its standard error from seed to seed, the difference of the
steady state from the shear test in standard errors, and the processor time of a run.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grainfit.bulk_tests.registry import bulk_tests
from grainfit.formatting import number
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES
from kept_runs import measure, read, scatter, simulate

ENERGY, MODULUS = "particle_particle.surface_energy", "particle.youngs_modulus"
#: Share of the Rayleigh time step that is safe with a modulus, Pa.
FRACTIONS = {3.6e5: 0.12, 1e7: 0.33}
#: Preshear and failure strain: the defaults, and others of which each is varied alone.
STRAINS = (0.5, 0.25)
OTHERS = ((0.25, 0.25), (0.7, 0.25), (0.5, 0.5))
RESPONSES = (
    "phi_sf",
    "bulk_density",
    "cohesion",
    "phi_lin",
    "phi_e",
    "major_consolidation_stress",
    "unconfined_strength",
)
#: The same quantity of the shear test.
STEADY = {"phi_sf": "internal_friction_angle", "bulk_density": "shear_density"}


class Run(NamedTuple):
    """What is varied: test, solver, surface energy in J/m^2, modulus in Pa, strains, seed."""

    test: str
    solver: str
    energy: float
    modulus: float
    preshear: float
    failure: float
    seed: int


def record_of(run: Run) -> dict[str, Any]:
    """Simulate once."""
    options: dict[str, float] = {"time_step_fraction": FRACTIONS[run.modulus]}
    if run.test == "shear_cell":
        options |= {"preshear_strain": run.preshear, "failure_strain": run.failure}
    test = bulk_tests()[run.test](diameter=0.010, **options)
    damping = {f"particle_{partner}.rolling_damping": 0.0 for partner in ("particle", "wall")}
    cohesion = {ENERGY: run.energy} if run.energy else {}
    material = {**ROUGH_SPHERES, MODULUS: run.modulus, **damping, **cohesion}
    program = DEM_PROGRAMS[run.solver](test, material)
    return {"particles": test.number_of_particles} | simulate(program, run.seed)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of a table in Markdown: one for each solver, material and procedure."""
    heads = ["solver", "γ, J/m²", "E, MPa", "strains", "runs", *RESPONSES, "1/ffc", "CPU s a run"]
    yield f"| {' | '.join(heads)} |"
    yield "|---" * len(heads) + "|"
    cases = dict.fromkeys(run[:6] for run in sorted(records))
    for case in (case for case in cases if case[0] == "shear_cell"):
        own = [r for run, r in records.items() if run[:6] == case]
        good = [r["responses"] for r in own if "responses" in r]
        cells = [case[1], f"{case[2]:g}", f"{case[3] / 1e6:g}", f"{case[4]:g}, {case[5]:g}"]
        cells += [f"{len(good)} of {len(own)}"]
        cells += [_mean([one[name] for one in good]) for name in RESPONSES]
        ratios = [one[RESPONSES[6]] / one[RESPONSES[5]] for one in good]
        cells += [_mean(ratios), f"{np.mean([r['seconds'] for r in own]):.1f}"]
        yield f"| {' | '.join(cells)} |"
    yield from _against_shear(records)
    yield from (f"{run}: {r['why']}" for run, r in records.items() if "why" in r)


def _against_shear(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the steady state of both tests, and their difference in standard errors."""
    yield ""
    yield "| solver | γ, J/m² | E, MPa | response | shear cell | shear | difference / error |"
    yield "|---" * 7 + "|"
    for case in dict.fromkeys(run[1:4] for run in sorted(records)):
        for name, other in STEADY.items():
            own, plane = (
                [
                    r["responses"][key]
                    for run, r in records.items()
                    if run[1:4] == case
                    and run.test == test
                    and (run.preshear, run.failure) == STRAINS
                    and "responses" in r
                ]
                for test, key in (("shear_cell", name), ("shear", other))
            )
            if min(len(own), len(plane)) < 2:
                continue
            error = math.hypot(
                *(scatter(values) / math.sqrt(len(values)) for values in (own, plane))
            )
            difference = (np.mean(own) - np.mean(plane)) / error
            cells = [
                case[0],
                f"{case[1]:g}",
                f"{case[2] / 1e6:g}",
                name,
                _mean(own),
                _mean(plane),
                f"{difference:+.1f}",
            ]
            yield f"| {' | '.join(cells)} |"


def _mean(values: list[float]) -> str:
    if len(values) < 2:
        return number(values[0], 4) if values else ""
    error = scatter(values) / math.sqrt(len(values))
    return f"{number(float(np.mean(values)), 4)} ± {number(error, 2)}"


def main() -> None:
    """Simulate what is missing, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--solvers", nargs="+", default=["lammps"])
    parser.add_argument("--energies", nargs="+", type=float, default=[0.0, 0.25, 0.5])
    parser.add_argument("--moduli", nargs="+", type=float, default=[3.6e5], choices=FRACTIONS)
    parser.add_argument("--tests", nargs="+", default=["shear_cell", "shear"])
    parser.add_argument("--travel", action="store_true", help="vary the strains as well")
    parser.add_argument("--table", action="store_true", help="print the tables alone")
    arguments = parser.parse_args()
    strains = [STRAINS, *(OTHERS if arguments.travel else ())]
    runs = [
        Run(test, solver, energy, modulus, *pair, seed)
        for seed in range(1, arguments.seeds + 1)
        for solver in arguments.solvers
        for energy in arguments.energies
        for modulus in arguments.moduli
        for test in arguments.tests
        for pair in (strains if test == "shear_cell" else [STRAINS])
    ]
    if not arguments.table:
        measure(runs, arguments.kept, record_of)
    print("\n".join(table(read(arguments.kept, Run))))


if __name__ == "__main__":
    main()
