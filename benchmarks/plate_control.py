"""Compare shear tests whose plate is controlled as usual with those of a slower control.

The dashpots of the contacts answer the speed of the plate at once. Where they are stronger than the
control, the plate swings, and shakes the bed (`grainfit.bulk_tests.shared.servo`). Rough spheres of
10 MPa at the defaults of the shear test, on LAMMPS. Finished runs are kept in the file ``--kept``
and not repeated.

    python benchmarks/plate_control.py --kept benchmarks/data/plate_control.jsonl [--seeds 4]
        [--table]

Prints the angle with both controls, and their difference with its 95 % interval.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from scipy import stats

from grainfit.bulk_tests.shared.servo import Control, contact_damping
from grainfit.bulk_tests.shear import Shear, setup
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_SPHERES
from kept_runs import mean_and, measure, read, scatter, simulate

DIAMETER, MODULUS = 0.010, 10e6
RESTITUTIONS = (0.3, 0.4, 0.5, 0.6)
CONTROLS: Mapping[str, Control] = {
    "usual": Control(overcome=math.inf, slower=1.0),
    "slower": setup.CONTROL,
}
_ANGLE = "internal_friction_angle"


class Run(NamedTuple):
    """What is varied."""

    restitution: float
    control: str
    seed: int


def _material(restitution: float) -> dict[str, float]:
    material = {**ROUGH_SPHERES, "particle.youngs_modulus": MODULUS}
    for pair in ("particle_particle", "particle_wall"):
        material |= {f"{pair}.restitution": restitution, f"{pair}.rolling_damping": 0.0}
    return material


def record_of(run: Run) -> dict[str, Any]:
    """Simulate once."""
    own = setup.CONTROL
    setup.CONTROL = CONTROLS[run.control]
    try:
        return simulate(Lammps(Shear(diameter=DIAMETER), _material(run.restitution)), run.seed)
    finally:
        setup.CONTROL = own


def share_of(restitution: float) -> float:
    """Return the estimated damping of the contacts over that of the usual control."""
    material, own = _material(restitution), Shear(diameter=DIAMETER).setup
    contacts = contact_damping(own.area, own.diameter, own.normal_stress, material)
    return contacts / own.usual_dashpot(material)


def table(records: Mapping[Run, dict[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table in Markdown."""
    names = ("restitution", "contacts over usual control", "runs")
    yield f"| {' | '.join((*names, 'angle, usual', 'failed', 'slower', 'failed', 'change'))} |"
    yield "|---" * 8 + "|"
    for restitution in RESTITUTIONS:
        own = {run: r for run, r in records.items() if run.restitution == restitution}
        seeds = sorted({run.seed for run in own})
        angles, failed = {}, {}
        for control in CONTROLS:
            found = [own.get(Run(restitution, control, seed), {}) for seed in seeds]
            angles[control] = [r["responses"][_ANGLE] for r in found if "responses" in r]
            failed[control] = sum("why" in r for r in found)
        cells = [f"{restitution:g}", f"{share_of(restitution):.2f}", str(len(seeds))]
        for control, values in angles.items():
            cells += [mean_and(scatter, values) if values else "", str(failed[control])]
        yield f"| {' | '.join((*cells, _change(*angles.values())))} |"


def _change(first: list[float], second: list[float]) -> str:
    if min(len(first), len(second)) < 2:
        return ""
    low, high = stats.ttest_ind(second, first, equal_var=False).confidence_interval(0.95)
    return f"{(low + high) / 2:+.2f}° ± {(high - low) / 2:.2f}°"


def main() -> None:
    """Make the runs that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--table", action="store_true", help="only print what is known")
    given = parser.parse_args()
    ways = product(range(1, given.seeds + 1), RESTITUTIONS, CONTROLS)
    if not given.table:
        measure([Run(e, control, seed) for seed, e, control in ways], given.kept, record_of)
    print("\n".join(table(read(given.kept, Run))))


if __name__ == "__main__":
    main()
