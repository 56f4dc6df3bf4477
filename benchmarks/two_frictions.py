"""Two frictions told apart: which bulk tests settle sliding and rolling friction.

Random materials are "measured" (the mean of eight seeds at the true parameters, with the error of a
laboratory) and calibrated with a particle density that is known to 0.5 %: it is free within two
standard uncertainties. The 95 % intervals of both frictions are compared with the truth. Finished
calibrations are kept in the file ``--kept``, runs of unfinished ones in the folder beside it, so
that the command can be stopped and started again. With ``--wanted``, the search goes on until the
half-widths are as wanted, if it can; these calibrations are kept apart from those without it.
Calibrations with the same tests share their runs, see `random_materials`.

    python benchmarks/two_frictions.py --kept two_frictions.jsonl [--materials 20]
        [--tests heap+draw_down ...] [--wanted 25%] [--processes 2] [--table] [--bound]

``--bound`` simulates nothing: it prints the half-widths that the slopes of the atlas allow for
the same materials, with the errors of the laboratory and of the mean of five runs of each test, and
with those of the laboratory alone, as if runs cost nothing.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Mapping

import numpy as np

from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.response_info import ResponseInfo
from grainfit.formatting import percent
from grainfit.problem import Parameter
from grainfit.student import NORMAL_QUANTILE
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES
from grainfit.which_test.candidate import RUNS
from grainfit.which_test.knowledge import Knowledge
from grainfit.which_test.slopes import Cloud
from grainfit.which_test.told_by_atlas import told_responses
from random_materials import (
    DENSITY,
    DIAMETER,
    MEASURED_SEEDS,
    Measured,
    Study,
    Unknown,
    absolute_uncertainty,
    command,
    run,
)

SLIDING, ROLLING = "particle_particle.sliding_friction", "particle_particle.rolling_friction"
#: The true values lie well inside the intervals.
UNKNOWN = {
    SLIDING: Unknown(true=(0.1, 0.8), interval=(0.05, 1.0)),
    ROLLING: Unknown(true=(0.05, 0.6), interval=(0.02, 0.8)),
}
LABORATORY: Mapping[str, float | str] = {
    "bulk_density": "0.5 %",
    "angle_of_repose": 0.5,
    "shear_angle": 0.7,
    "mass_flow": "2 %",
    "discharged_share": 0.01,
    "loading_modulus": "3 %",
    "unloading_modulus": "3 %",
    "lateral_stress_ratio": 0.01,
}
#: From a floor like the walls, some of each pile with little sliding friction slides off.
FLOORS = {
    "heap": ROUGH_PLATE,
    "draw_down": {"floor_sliding_friction": 0.5, "floor_rolling_friction": 0.5},
}
#: Factor of the box about a material over which its slopes are taken.
_AROUND = 1.5
#: Values to which absolute uncertainties are compared in the bound, in the same units.
TYPICAL: Mapping[str, float] = {
    "angle_of_repose": 25.0,
    "shear_angle": 29.0,
    "discharged_share": 0.73,
    "lateral_stress_ratio": 0.39,
}


def study(*tests: str, stiffness: float = 1750.0, **stresses: tuple[str, float]) -> Study:
    """Return the materials with some tests; by default as stiff as the paper's."""
    free = (SLIDING, ROLLING, DENSITY)
    return Study(
        tests={
            name: bulk_tests()[name](diameter=DIAMETER, **FLOORS.get(name, {})) for name in tests
        },
        # On walls as smooth as the paper's, draw-downs do not come to rest.
        fixed={name: value for name, value in ROUGH_SPHERES.items() if name not in free},
        stiffness=stiffness,
        unknown=UNKNOWN,
        measured={DENSITY: Measured(true=(1500.0, 3000.0), uncertainty=0.005)},
        laboratory=LABORATORY,
        stresses=stresses,
    )


#: The stress of a compression is twice the weight of the bed, and Young's modulus 1000 times it.
STUDIES = {
    "heap": study("heap"),
    "heap+draw_down": study("heap", "draw_down"),
    "heap+compression": study("heap", "compression", stiffness=1e4, compression=("stress", 10.0)),
}


# What can be known at all -------------------------------------------------------------------


def bound(materials: int) -> Iterator[str]:
    """Yield the median half-widths that the slopes of the atlas allow as a table in Markdown."""
    yield "| tests | five runs of each test: sliding, rolling | without scatter: sliding, rolling |"
    yield "|---|---|---|"
    for name, each in STUDIES.items():
        cells = [name.replace("+", " + ").replace("_", "-")]
        for runs in (RUNS, math.inf):
            left = [_after(each, number, runs) for number in range(1, materials + 1)]
            widths = [
                NORMAL_QUANTILE * statistics.median(k.deviation(key) for k in left)
                for key in UNKNOWN
            ]
            cells.append(", ".join(percent(width) for width in widths))
        yield f"| {' | '.join(cells)} |"


def _after(each: Study, number: int, runs: float) -> Knowledge:
    """Return what the tests leave of a material, linear and with normal errors."""
    truth, known, _ = each.draw(number)
    spreads = [
        (it.interval[1] - it.interval[0]) / math.sqrt(12) / truth[key]
        for key, it in UNKNOWN.items()
    ]
    spreads += [it.uncertainty for it in each.measured.values()]
    before = Knowledge((*UNKNOWN, *each.measured), np.diag(spreads) ** 2)
    scaled = each.at_scale_of(known)
    measured = list(_measured(scaled, {**scaled.fixed, **truth, **known}, runs))
    return before.after([slopes for slopes, _ in measured], np.diag([v for _, v in measured]))


def _measured(
    each: Study, material: Mapping[str, float], runs: float
) -> Iterator[tuple[Mapping[str, float], float]]:
    """Yield slopes and relative variance of each measured response."""
    names = (*UNKNOWN, *each.measured)
    around = [
        Parameter(name, material[name] / _AROUND, material[name] * _AROUND, "log") for name in names
    ]
    cloud = Cloud.even(around)
    fixed = {name: value for name, value in material.items() if name not in names}
    for test, solver in each.solvers(fixed).items():
        for one in told_responses(test, solver, cloud, _accuracy):
            relative = one.accuracy.of(one.value) / one.value
            yield one.slopes, relative**2 + one.scatter**2 * (1 / MEASURED_SEEDS + 1 / runs)


def _accuracy(name: str, _info: ResponseInfo) -> Accuracy | None:
    if name not in LABORATORY:
        return None
    return Accuracy(absolute_uncertainty(LABORATORY[name], TYPICAL.get(name, 1.0)))


def main() -> None:
    """Calibrate, and print the table."""
    parser = command(STUDIES, materials=20, about=__doc__.splitlines()[0])
    parser.add_argument("--bound", action="store_true", help="print what can be known at all")
    given = parser.parse_args()
    if given.bound:
        print("\n".join(bound(given.materials)))
    else:
        run(STUDIES, parser)


if __name__ == "__main__":
    main()
