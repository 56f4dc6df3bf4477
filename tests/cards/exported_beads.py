"""A material that is calibrated quickly, and names that are up to no good."""

from __future__ import annotations

import random
from collections.abc import Mapping

import grainfit
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS

FREE = ("particle.density", "particle_particle.rolling_friction")
FIXED = {name: value for name, value in GLASS_BEADS.items() if name not in FREE}
SIZES = grainfit.ParticleSizes((0.010,))
PROBLEM = grainfit.Problem(
    [
        grainfit.Parameter("particle.density", 1400, 2800, unit="kg/m^3"),
        grainfit.Parameter("particle_particle.rolling_friction", 0.2, 1.0),
    ],
    [
        grainfit.Target("bulk_density", 1500.0, tolerance=15, unit="kg/m^3"),
        grainfit.Target("angle_of_repose", 22.0, tolerance=0.5, unit="deg"),
    ],
    grainfit.RayleighTimeStep(
        0.005, {name: FIXED[name] for name in FIXED if name.startswith("particle.")}
    ),
)
#: What would leave a comment, a quoted text, a template or a cell, if it were not kept in there.
NASTY = (
    '=1+2\nprint "INJECTED" &\r\n"""\n\'\'\'\nprint("INJECTED")\n# coding: utf-7 </script> '
    '{{ 7 * 7 }} ${x} $x Körnung "fein" \x1b[31m &'
)


class QuickHeap(Lammps):
    """The heap test with LAMMPS in all that is recorded of a run, but for the simulation."""

    uses_folder = False

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: grainfit.Workspace
    ) -> dict[str, grainfit.Response]:
        material = self.run_parameters(parameters)
        scatter = random.Random(seed)
        friction = material["particle_particle.rolling_friction"]
        return {
            "bulk_density": grainfit.Response(
                0.65 * material["particle.density"] + scatter.gauss(0, 2)
            ),
            "angle_of_repose": grainfit.Response(15 + 12 * friction + scatter.gauss(0, 0.2)),
        }
