"""Why a drum of published simulations is steeper than ours was: one difference after the other.

The published particles of two drums (``uob-positron-imaging-centre/ACCES-GranuDrum-Calibration``,
``TrialSimulations/sim0144_*``) and the deck beside them are the reference: 29,185 spheres of 1.05
to 1.5 mm in a drum of 84 mm between end walls 20 mm apart, on LIGGGHTS with a constant torque.
"""

from __future__ import annotations

import csv
import math
import resource
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.rolling_programs import ConstantTorque
from grainfit.bulk_tests.drum import Drum
from grainfit.errors import GrainfitError
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.program import DeckSolver
from grainfit.solvers.registry import DEM_PROGRAMS
from studies.benchmarks.published import DATA

RADIUS, LENGTH = 0.042, 0.020
#: Sliding and rolling friction of the published answer, the same at walls.
SLIDING, ROLLING = 0.5613, 0.2931
#: Share of the drum that the published spheres take, over the solid fraction of a bed of `Drum`.
FILL = 0.2630 / 0.58
MATERIAL: Mapping[str, float] = {
    "particle.poissons_ratio": 0.3,
    "particle.density": 1580.0,
    "wall.poissons_ratio": 0.3,
    "wall.density": 1580.0,
    **{
        f"{pair}.{name}": value
        for pair in ("particle_particle", "particle_wall")
        for name, value in (
            ("sliding_friction", SLIDING),
            ("rolling_friction", ROLLING),
            ("rolling_damping", 0.0),
            ("restitution", 0.3),
        )
    },
}
#: Solvers, and LIGGGHTS with the torque of the published deck.
PROGRAMS: Mapping[str, type[DeckSolver]] = {**DEM_PROGRAMS, "constant_torque": ConstantTorque}


class Part(NamedTuple):
    """A drum: program, speed in rpm, modulus in Pa, fill level, wall friction, diameter in m."""

    program: str
    speed: int
    modulus: float
    fill: float
    wall: float
    caps: bool
    diameter: float


#: As it was compared first, and then one change after the other towards the published drum.
FIRST = Part("lammps", 45, 93e3, 0.35, 0.6, caps=False, diameter=0.0036)
CHANGES: Sequence[tuple[str, Mapping[str, Any]]] = (
    ("as it was compared first", {}),
    ("5 MPa instead of 0.093 MPa", {"modulus": 5e6}),
    ("as full as the published one", {"fill": FILL}),
    ("friction of the wall 0.56 instead of 0.6", {"wall": SLIDING}),
    ("end walls instead of a slice", {"caps": True}),
    ("spheres of 2.4 mm instead of 3.6 mm", {"diameter": 0.0024}),
    ("LIGGGHTS", {"program": "liggghts"}),
    ("constant torque instead of EPSD", {"program": "constant_torque"}),
    ("spheres of 1.8 mm instead of 2.4 mm", {"diameter": 0.0018}),
)


def chain() -> list[tuple[str, Part]]:
    """Return the words of each change, and the drum with it and all before it."""
    part, found = FIRST, []
    for words, change in CHANGES:
        part = part._replace(**change)
        found.append((words, part))
    return found


@cache
def published() -> dict[int, tuple[float, float]]:
    """Return the angles of the published particles, degrees, by speed in rpm.

    By the centre of mass, as of a simulated drum, and by the outline, as on a picture.
    """
    with (DATA / "granudrum" / "particles.csv").open(encoding="utf-8") as file:
        return {
            int(row["speed_rpm"]): (float(row["angle_deg"]), float(row["outline_deg"]))
            for row in csv.DictReader(file)
        }


def before(part: Part, records: Mapping[Part, Mapping[str, Any]]) -> float:
    """Return the angle of the drum before the change that led to this one, degrees."""
    parts = [one for _, one in chain()]
    return float(records[parts[parts.index(part) - 1]]["angle"])


def steps(records: Mapping[Part, Mapping[str, Any]]) -> dict[str, float]:
    """Return the steps of the angle that need a word, degrees."""
    parts = [part for _, part in chain()]
    found = {"modulus": 1, "caps": 4, "torque": 7}
    return {
        name: records[parts[number]]["angle"] - before(parts[number], records)
        for name, number in found.items()
    }


def finest(records: Mapping[Part, Mapping[str, Any]]) -> float:
    """Return the diameter of the last drum that has been simulated, m."""
    return [part for _, part in chain() if part in records][-1].diameter


def left(records: Mapping[Part, Mapping[str, Any]]) -> float:
    """Return by how much the last drum is steeper than the published one, degrees."""
    last = [part for _, part in chain() if part in records][-1]
    return float(records[last]["angle"]) - published()[last.speed][0]


#: Drums with the published rolling model at the other published speed, finer spheres last: those of
#: the published mean diameter take over an hour.
SLOW = tuple(
    chain()[7][1]._replace(speed=15, diameter=diameter) for diameter in (0.0024, 0.0018, 0.0012)
)
#: Angles within this agree, degrees.
AGREES = 1.5


def like_the_published(speed: int) -> dict[str, Part]:
    """Return the drum most like the published one at a speed, by solver.

    That of LIGGGHTS has the published rolling model, which grainfit does not offer.
    """
    parts = [part for _, part in chain()]
    return {
        "lammps": parts[5]._replace(speed=speed),
        "liggghts": parts[-1] if speed == parts[-1].speed else SLOW[-1],
    }


def all_parts(solvers: Sequence[str]) -> list[Part]:
    """Return all drums of some solvers."""
    wanted = {*solvers, *(["constant_torque"] if "liggghts" in solvers else [])}
    return [part for part in (*(part for _, part in chain()), *SLOW) if part.program in wanted]


def simulate(run: Part) -> dict[str, Any]:
    """Simulate; return the mean inclination, degrees, slip at the wall, and processor time, s."""
    material = {
        **MATERIAL,
        "particle_wall.sliding_friction": run.wall,
        "particle.youngs_modulus": run.modulus,
        "wall.youngs_modulus": run.modulus,
    }
    drum = Drum(
        diameter=run.diameter,
        drum_radius=RADIUS,
        drum_length=LENGTH,
        end_caps=run.caps,
        fill_level=run.fill,
        rotational_speed=run.speed * 2 * math.pi / 60,
        lining=False,
        discarded_turns=0.5,
        averaged_turns=0.5 if run.speed < 30 else 0.75,
        time_step_fraction=0.19,
    )
    program = PROGRAMS[run.program](drum, material)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        scene = program._scene(program.run_parameters({}), 1)
        out = program.simulate(scene, Workspace(Path(folder)))
        out.require_complete([stage.name for stage in scene.stages], "drum")
        bed = drum._bed(out)
        try:
            drum.measure(out)
        except GrainfitError as error:
            why = str(error).splitlines()[0]
        else:
            why = ""
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    inclination = float(np.mean(bed.inclinations))
    return {
        "angle": round(inclination, 3),
        "scatter": round(float(np.std(bed.inclinations)), 3),
        "slip": round(bed.slip(bed.surface(inclination)), 3),
        "count": len(bed.last),
        "refused": why,
        "seconds": round(seconds, 2),
    }
