"""Check Beverloo's law: discharge through slots of several widths.

    python benchmarks/beverloo.py --solver lammps --slots 5 6.5 8 --seeds 3 [--law own]

Fits ``flow = C rho_b sqrt(g) depth (W - k d)^n`` to the mass flows: the exponent n with the k
given, and, with n = 3/2, the k and C of the straight line through ``flow^(2/3)`` over W. The law
``new`` is that with which ``grainfit new`` begins.

References
----------
Beverloo, Leniger & van de Velde (1961), Chem. Eng. Sci. 15, 260-269.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.discharge import Discharge
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES
from new_law import LAWS, NEW, OWN, material_of_new

#: Particle diameter, m.
DIAMETER = 0.010


def run(
    solver: str, slot: float, seed: int, depth: float, material: Mapping[str, float]
) -> tuple[float, float]:
    """Return mass flow, kg/s, and bulk density, kg/m^3, of one run; lengths in diameters."""
    test = Discharge(
        diameter=DIAMETER, slot_width=slot * DIAMETER, depth=depth * DIAMETER, width=18 * DIAMETER
    )
    with tempfile.TemporaryDirectory() as folder:
        responses = DEM_PROGRAMS[solver](test, material).run({}, seed, Workspace(Path(folder)))
    flow, density = responses["mass_flow"].value, responses["bulk_density"].value
    print(f"slot {slot:g} d, seed {seed}: {flow:.4g} kg/s", file=sys.stderr, flush=True)
    return flow, density


def main() -> None:
    """Run the discharges and print the fits as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--solver", choices=sorted(DEM_PROGRAMS), default="lammps")
    parser.add_argument("--slots", type=float, nargs="+", default=[5.0, 6.5, 8.0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--depth", type=float, default=5.0, help="in diameters")
    parser.add_argument("--k", type=float, default=1.5, help="for the fit of the exponent")
    parser.add_argument("--law", default=OWN, choices=LAWS)
    given = parser.parse_args()
    material = material_of_new() if given.law == NEW else ROUGH_SPHERES
    found = [
        (slot, *run(given.solver, slot, seed, given.depth, material))
        for slot in given.slots
        for seed in range(1, given.seeds + 1)
    ]
    slots, flows, densities = np.array(found).T
    scale = densities.mean() * math.sqrt(9.81 * DIAMETER**3) * DIAMETER * given.depth
    natural = flows / scale
    exponent, covariance = np.polyfit(np.log(slots - given.k), np.log(natural), 1, cov="unscaled")
    rest = np.log(natural) - np.polyval(exponent, np.log(slots - given.k))
    error = math.sqrt(covariance[0, 0] * float(rest @ rest) / (len(slots) - 2))
    slope, intercept = np.polyfit(slots, natural ** (2 / 3), 1)
    print(
        json.dumps(
            {
                "flows": {
                    f"{slot:g} d": round(float(flows[slots == slot].mean()), 4)
                    for slot in given.slots
                },
                "exponent": round(float(exponent[0]), 3),
                "standard_error": round(error, 3),
                "k": round(float(-intercept / slope), 3),
                "C": round(float(slope**1.5), 3),
            },
            indent=2,
        )
    )


if __name__ == "__main__":
    main()
