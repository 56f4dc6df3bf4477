"""The eight elementary impacts of Chung & Ooi (2011) on three solvers.

References
----------
Chung & Ooi (2011), Granular Matter 13:643-656. The tables in ``data/chung_ooi`` are figures of the
paper that the developers of Kratos Multiphysics digitised; the experiment of the fourth impact is
that of Kharaz, Gorham & Salman (2001), Powder Technology 120:281-291.
"""

from __future__ import annotations

import resource
import shlex
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grainfit.bulk_tests.heap import Heap
from grainfit.contact_models.contact import particle_mass
from grainfit.contact_models.hertz_mindlin.model import (
    hertz_stiffness,
    impact_overlap,
    impact_time,
    particle_moduli,
)
from grainfit.contact_models.registry import contact_law
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.testing.impact_contract import (
    ALUMINIUM_ALLOY,
    ALUMINIUM_OXIDE,
    CAST_IRON,
    GLASS,
    LIMESTONE,
    MAGNESIUM_ALLOY,
    POLYETHYLENE,
    SECOND_ALUMINIUM_ALLOY,
    STEEL,
    impact_material,
)
from grainfit.testing.single_contacts import (
    ContactCase,
    LammpsContacts,
    LiggghtsContacts,
    Motion,
    SingleContacts,
    Sphere,
    YadeContacts,
)
from studies.benchmarks.published import curve

SOLVERS = ("lammps", "liggghts", "yade")
COPPER = (120e9, 0.35, 8900.0)
#: Bodies of each impact: Young's modulus, Pa; Poisson's ratio; density, kg/m^3.
BODIES: Mapping[int, Mapping[str, tuple[float, float, float]]] = {
    1: {"glass": GLASS, "limestone": LIMESTONE},
    2: {"aluminium alloy": ALUMINIUM_ALLOY, "magnesium alloy": MAGNESIUM_ALLOY},
    3: {"aluminium oxide": ALUMINIUM_OXIDE, "cast iron": CAST_IRON},
    4: {"oxide": ALUMINIUM_OXIDE, "alloy": SECOND_ALUMINIUM_ALLOY},
    5: {"steel": STEEL, "polyethylene": POLYETHYLENE},
    6: {"al_alloy": SECOND_ALUMINIUM_ALLOY},
    7: {"aluminium alloy": SECOND_ALUMINIUM_ALLOY, "copper": COPPER},
    8: {"al_alloy": SECOND_ALUMINIUM_ALLOY},
}
RESTITUTIONS = (0.2, 0.4, 0.6, 0.8, 1.0)
#: Friction and restitution of the fourth to the eighth impact.
FRICTION = {4: 0.092, 5: 0.3, 6: 0.4, 7: 0.4, 8: 0.4}
RESTITUTION = {1: 1.0, 2: 1.0, 4: 0.98, 5: 1.0, 6: 0.5, 7: 0.5, 8: 0.5}
#: Spins of the seventh impact, 1/s.
SPINS = (0.175, 0.5, 2.0, 8.0, 22.0)
#: Radii, m, and normal velocities, m/s.
RADIUS = {1: 0.010, 2: 0.100, 3: 0.0025, 4: 0.0025, 5: 1e-5, 6: 0.1, 7: 0.1, 8: 0.1}
LARGE = 0.5
SPEED = {1: 10.0, 2: 0.2, 3: 3.9, 4: 3.9, 5: 5.0, 6: 0.2, 7: 0.2, 8: 0.2}
_APART = 1.0001
_FRAMES = 400
Found = dict[str, list[float]]


class Run(NamedTuple):
    """An impact, or several that do not meet, in one run of a solver."""

    solver: str
    test: int
    body: str
    restitution: float


class _YadeOfDecks(YadeContacts):
    """YADE with the floor of the decks of bulk tests."""

    has_floor_of_decks = True


def all_runs(solvers: Sequence[str]) -> list[Run]:
    """Return the runs of all eight impacts."""
    return [
        Run(solver, test, body, restitution)
        for solver in solvers
        for test, bodies in BODIES.items()
        for body in bodies
        for restitution in (RESTITUTIONS if test == 3 else (RESTITUTION[test],))
    ]


def simulate(run: Run) -> dict[str, Any]:
    """Simulate; return what came out and the processor time, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        motion = _program(run.solver).simulate(case_of(run), Path(folder))
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return {"found": _MEASURES[run.test](run, motion), "seconds": round(seconds, 2)}


def _program(solver: str) -> SingleContacts:
    test = Heap(diameter="10 mm")
    if solver == "lammps":
        return LammpsContacts(shlex.split(Lammps(test, {}).executes()[0]))
    if solver == "liggghts":
        return LiggghtsContacts(shlex.split(Liggghts(test, {}).executes()[0]))
    return _YadeOfDecks(["yade", "-n", "-x", "-j1", YadeContacts.input_name])


def material_of(run: Run) -> dict[str, float]:
    """Return the material; walls do not deform."""
    body = BODIES[run.test][run.body]
    return impact_material(body, run.restitution, FRICTION.get(run.test, 0.0))


def case_of(run: Run) -> ContactCase:
    """Return the particles at the start, and what they do it in."""
    radius, speed, values = RADIUS[run.test], SPEED[run.test], material_of(run)
    spheres = _SPHERES[run.test](run)
    slowest = min(abs(s.velocity[2]) or speed for s in spheres)
    seconds = 5 * elastic(run, slowest)["contact_time"] + 10 * (_APART - 1) * radius / slowest
    is_followed = run.test in (1, 2)
    if is_followed:
        seconds = 1.5 * elastic(run, speed)["contact_time"] + 2 * (_APART - 1) * radius / speed
    reach = max(max(map(abs, s.position)) for s in spheres)
    return ContactCase(
        contact_law(values),
        values,
        spheres,
        seconds,
        frames=_FRAMES if is_followed else 1,
        time_step_fraction=0.005,
        half_box=reach + 4 * max(s.radius for s in spheres),
    )


def elastic(run: Run, speed: float) -> dict[str, float]:
    """Return contact time, s, and largest overlap, m, and force, N, of an elastic impact.

    References
    ----------
    Johnson (1985), Contact Mechanics, chapter 11.4.
    """
    values, radius = material_of(run), RADIUS[run.test]
    is_pair = run.test in (1, 7, 8)
    mass = particle_mass(values, radius)
    if is_pair:
        # An eighth impact is shorter than one of two small spheres by no more than a third.
        mass, radius, speed = mass / 2, radius / 2, 2 * speed
    moduli = particle_moduli(values, "particle" if is_pair else "wall")
    overlap = impact_overlap(speed, mass, moduli, radius)
    return {
        "contact_time": impact_time(speed, mass, moduli, radius),
        "largest_overlap": overlap,
        "largest_force": hertz_stiffness(overlap, moduli, radius) * overlap,
    }


def abscissae(test: int, body: str) -> NDArray[np.float64]:
    """Return the places of the published curves: angles, degrees, or scaled velocities."""
    if test == 4:
        names = [("test4_tangential_restitution", body)]
        if body == "oxide":
            others = ("tangential_restitution", "angular_velocity", "rebound_angle")
            names += [(f"test4_{o}", s) for o in others for s in ("oxide", "experiment")]
        return np.unique(np.concatenate([curve(*name)[:, 0] for name in names]))
    if test == 5:
        return curve("test5_recoil", body)[:, 0]
    return curve("test6_beta", body)[:, 0]


def sliding_patch(run: Run) -> NDArray[np.float64]:
    """Return the velocity of the contact patch before the sixth and the eighth impact, m/s."""
    factor = 3.5 * FRICTION[run.test] * (1 + run.restitution)
    return factor * SPEED[run.test] / abscissae(run.test, run.body)


# --- particles at the start -----------------------------------------------------------------------


def _pair(run: Run) -> list[Sphere]:
    start, speed, radius = _APART * RADIUS[run.test], SPEED[run.test], RADIUS[run.test]
    return [
        Sphere((side * start, 0.0, 5 * radius), (-side * speed, 0.0, 0.0), radius=radius)
        for side in (-1, 1)
    ]


def _on_floor(run: Run, across: Sequence[float], down: Sequence[float]) -> list[Sphere]:
    radius = RADIUS[run.test]
    return [
        Sphere(
            (0.0, 4 * radius * (number - len(down) / 2), _APART * radius),
            (x, 0.0, -z),
            radius=radius,
        )
        for number, (x, z) in enumerate(zip(across, down, strict=True))
    ]


def _normal(run: Run) -> list[Sphere]:
    return _on_floor(run, [0.0], [SPEED[run.test]])


def _oblique(run: Run) -> list[Sphere]:
    angles = np.radians(abscissae(4, run.body))
    return _on_floor(run, (3.9 * np.sin(angles)).tolist(), (3.9 * np.cos(angles)).tolist())


def _scaled(run: Run) -> list[Sphere]:
    across = abscissae(5, run.body) * FRICTION[5] * SPEED[5]
    return _on_floor(run, across.tolist(), [SPEED[5]] * len(across))


def _spinning(run: Run) -> list[Sphere]:
    """Spheres that fall straight down; their contact patches move by their spins alone."""
    radius, patches = RADIUS[6], sliding_patch(run)
    falling = _on_floor(run, [0.0] * len(patches), [SPEED[6]] * len(patches))
    return [
        Sphere(s.position, s.velocity, (0.0, -patch / radius, 0.0), radius)
        for s, patch in zip(falling, patches.tolist(), strict=True)
    ]


def _opposite_spins(run: Run) -> list[Sphere]:
    radius, found = RADIUS[7], []
    for row, spin in enumerate(SPINS):
        for sphere, side in zip(_pair(run), (1, -1), strict=True):
            x, _, z = sphere.position
            y = 5 * radius * (row - len(SPINS) / 2)
            found.append(Sphere((x, y, z), sphere.velocity, (0.0, 0.0, side * spin), radius))
    return found


def _two_sizes(run: Run) -> list[Sphere]:
    radius, found = RADIUS[8], []
    patches = sliding_patch(run).tolist()
    for row, patch in enumerate(patches):
        y, z = 2.5 * LARGE * (row - len(patches) / 2), 2 * LARGE
        spin = (0.0, 0.0, patch / radius)
        start = -(radius + LARGE) - (_APART - 1) * radius
        found.append(Sphere((start, y, z), (SPEED[8], 0.0, 0.0), spin, radius))
        found.append(Sphere((0.0, y, z), radius=LARGE))
    return found


# --- what comes out -------------------------------------------------------------------------------


def _followed(run: Run, motion: Motion) -> Found:
    axis = 0 if run.test == 1 else 2
    forces = np.abs(motion.forces[:, -1, axis])
    places, radius = motion.positions[:, :, axis], RADIUS[run.test]
    overlaps = 2 * radius - np.ptp(places, axis=1) if run.test == 1 else radius - places[:, 0]
    touching = motion.times[overlaps > 0]
    return {
        # Frames miss half an interval at either end.
        "contact_time": [float(np.ptp(touching) + motion.times[1])],
        "largest_overlap": [float(overlaps.max())],
        "largest_force": [float(forces.max())],
        "restitution": [float(abs(motion.velocities[-1, -1, axis]) / SPEED[run.test])],
    }


def _normal_restitution(run: Run, motion: Motion) -> Found:
    return {"restitution": [float(motion.velocities[-1, 0, 2] / SPEED[run.test])]}


def _patch(motion: Motion, frame: int, radius: float) -> NDArray[np.float64]:
    """Return the velocity of the contact patch on the floor, along x, m/s."""
    patch: NDArray[np.float64] = motion.velocities[frame, :, 0]
    return patch - radius * motion.spins[frame, :, 1]


def _rebound(_run: Run, motion: Motion) -> Found:
    before, after = motion.velocities[0], motion.velocities[-1]
    patch = _patch(motion, -1, RADIUS[4])
    return {
        "tangential_restitution": (after[:, 0] / before[:, 0]).tolist(),
        "angular_velocity": (-motion.spins[-1, :, 1]).tolist(),
        "rebound_angle": np.degrees(np.arctan2(patch, after[:, 2])).tolist(),
    }


def _recoil(_run: Run, motion: Motion) -> Found:
    return {"recoil": (_patch(motion, -1, RADIUS[5]) / (FRICTION[5] * SPEED[5])).tolist()}


def _beta(_run: Run, motion: Motion) -> Found:
    before, after = (_patch(motion, frame, RADIUS[6]) for frame in (0, -1))
    return {"beta": (-after / before).tolist()}


def _unchanged(_run: Run, motion: Motion) -> Found:
    spins, across = motion.spins[:, :, 2], motion.velocities[-1, :, 1]
    return {
        "spin_share": (spins[-1] / spins[0]).tolist(),
        "across_share": (across / (RADIUS[7] * np.abs(spins[0]))).tolist(),
    }


def _beta_of_pairs(_run: Run, motion: Motion) -> Found:
    across, spins = motion.velocities[:, :, 1], motion.spins[:, :, 2]
    small = across[:, ::2] + RADIUS[8] * spins[:, ::2]
    large = across[:, 1::2] - LARGE * spins[:, 1::2]
    patch = small - large
    return {"beta": (-patch[-1] / patch[0]).tolist()}


_SPHERES: Mapping[int, Callable[[Run], list[Sphere]]] = {
    1: _pair,
    2: _normal,
    3: _normal,
    4: _oblique,
    5: _scaled,
    6: _spinning,
    7: _opposite_spins,
    8: _two_sizes,
}
_MEASURES: Mapping[int, Callable[[Run, Motion], Found]] = {
    1: _followed,
    2: _followed,
    3: _normal_restitution,
    4: _rebound,
    5: _recoil,
    6: _beta,
    7: _unchanged,
    8: _beta_of_pairs,
}
