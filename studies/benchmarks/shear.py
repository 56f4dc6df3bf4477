"""Plane shear of spheres without rolling friction, over sliding friction and inertial number.

References
----------
Chialvo, Sun & Sundaresan (2012), Phys. Rev. E 85:021305: yield stress ratio and critical solid
fraction of sheared spheres, and how the ratio rises with the inertial number. The paper's table
could not be read; two of its rows, for frictions of 0.1 and 0.5, stand in a case of the solver
twoPhaseEulerPimpleFoamPU (github.com/gudaxia/twoPhaseEulerPimpleFoamPU,
``testCases/jetBedPU/constant/kineticTheoryProperties``), and the rise in the model ``ChialvoEtAl``
of pfmFOAM with its case ``SingleSpoutvanBuijtenen`` (github.com/ParticulateFlow/pfmFOAM-public).
Clark, Thompson, Shattuck, Ouellette & O'Hern (2018), arXiv:1706.09465, abstract: smooth spheres
yield at a shear stress of 0.11 times the normal stress.
Agnolin & Roux (2007), arXiv:0705.3194, abstract: smooth spheres pack to 0.639. Peyneau & Roux
(2008), Phys. Rev. E 78:011307, abstract: slow shear leaves them at that solid fraction.
Jop, Forterre & Pouliquen (2006), Nature 441:727: glass beads; figures as in cases of pfmFOAM.
"""

from __future__ import annotations

import math
import resource
import tempfile
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, stdev
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import curve_fit
from scipy.spatial import cKDTree

from grainfit.arrays import Array
from grainfit.bulk_tests.shear import Shear
from grainfit.bulk_tests.stiffness import IN_SHEAR
from grainfit.contact_models.hertz_mindlin.model import particle_moduli
from grainfit.errors import RunFailedError
from grainfit.measurement.particles import Particles
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.scene import Scene
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.simulated_scenes import material

DIAMETER, STRESS, RESTITUTION = 0.010, 500.0, 0.79
#: Young's modulus, Pa, and the share of the Rayleigh time step that is safe with it.
MODULUS, TIME_STEP = 1e7, 0.33
FRICTIONS = (0.0, 0.1, 0.3, 0.5, 1.0)
#: Inertial numbers at all frictions, and, once on LAMMPS, at those whose whole curve is wanted.
SLOW, CURVE, CURVED = (0.01, 0.02, 0.05), (0.005, 0.01, 0.02, 0.05, 0.1), (0.0, 0.5)
#: Published values by sliding friction, where they could be read: shear stress over pressure, solid
#: fraction.
PUBLISHED = {0.0: (0.11, 0.639), 0.1: (0.268, 0.613), 0.5: (0.382, 0.587)}
#: Layers at the plates whose contacts are not counted, diameters.
MARGIN = 1.5
#: Share of the density that overlaps add.
OVERLAP = IN_SHEAR.excess(MODULUS / STRESS)
SEEDS: Mapping[str, int] = {"lammps": 2, "liggghts": 1}


class Sheared(NamedTuple):
    """A sheared bed on a solver."""

    solver: str
    friction: float
    inertial_number: float
    seed: int


def all_sheared(solvers: Sequence[str]) -> list[Sheared]:
    """Return all beds, those of the first seed first; YADE, which takes long, is left out."""
    return [
        Sheared(solver, friction, number, seed)
        for seed in range(1, max(SEEDS.values()) + 1)
        for solver in solvers
        if seed <= SEEDS.get(solver, 0)
        for friction in FRICTIONS
        for number in _numbers(solver, friction, seed)
    ]


def _numbers(solver: str, friction: float, seed: int) -> Sequence[float]:
    if seed > 1:
        return SLOW
    if friction in CURVED and solver == "lammps":
        return CURVE
    # A power needs one more.
    return SLOW if friction else (CURVE[0], *SLOW)


def simulate(run: Sheared) -> dict[str, Any]:
    """Simulate; return angle, solid fraction, pressure over normal stress, processor time, s."""
    values = {**material(RESTITUTION, run.friction), "particle.youngs_modulus": MODULUS}
    test = Shear(
        diameter=DIAMETER,
        normal_stress=STRESS,
        inertial_number=run.inertial_number,
        time_step_fraction=TIME_STEP,
    )
    scene = test.scene(values, run.seed)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        try:
            out = DEM_PROGRAMS[run.solver](test, values).simulate(scene, Workspace(Path(folder)))
            found = measured(out, test, scene, values)
        except RunFailedError as error:
            found = {"why": str(error)}
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return found | {"seconds": round(seconds, 2)}


def measured(
    out: RunOutput, test: Shear, scene: Scene, values: Mapping[str, float]
) -> dict[str, Any]:
    """Return angle with its error, degrees, solid fraction, and pressure over normal stress."""
    responses = test.measure(out)
    angle = responses["internal_friction_angle"]
    length, depth, _ = scene.box.high
    beds = [out.snapshot(stage.snapshot) for stage in scene.stages if stage.snapshot]
    pressures = [mean_pressure(bed, (length, depth), values) for bed in beds]
    return {
        "angle": angle.value,
        "error": angle.standard_error,
        "solid_fraction": responses["shear_density"].value / values["particle.density"],
        "pressure": float(np.mean(pressures)) / STRESS,
    }


def mean_pressure(
    bed: Particles, periods: tuple[float, float], values: Mapping[str, float]
) -> float:
    """Return the mean of the three normal stresses in the middle of a bed, Pa.

    Tangential forces are perpendicular to the line of centres and add nothing to it.

    Parameters
    ----------
    bed : Particles
        Loose particles.
    periods : tuple of float
        Along and across the shear, m.
    values : mapping of str to float
        Material parameters.
    """
    period, places = np.array(periods), bed.positions.copy()
    places[:, :2] %= period
    places[:, 2] -= places[:, 2].min()
    low, high = MARGIN * DIAMETER, places[:, 2].max() - MARGIN * DIAMETER
    tree = cKDTree(places, boxsize=[*periods, 1e3])
    pairs = tree.query_pairs(DIAMETER, output_type="ndarray")
    between = places[pairs[:, 0]] - places[pairs[:, 1]]
    between[:, :2] -= period * np.round(between[:, :2] / period)
    distances = np.linalg.norm(between, axis=1)
    ends = np.sort(places[pairs, 2], axis=1)
    # A line of centres that is almost level is inside or outside as a whole.
    ends += np.array([-1e-6, 1e-6]) * DIAMETER
    inside = np.clip(ends, low, high)
    shares = np.diff(inside, axis=1)[:, 0] / np.diff(ends, axis=1)[:, 0]
    young: float = particle_moduli(values, "particle").young
    forces = 4 / 3 * young * math.sqrt(DIAMETER / 4) * (DIAMETER - distances) ** 1.5
    virial = float((forces * distances * shares).sum())
    return float(virial / (3 * period.prod() * (high - low)))


@dataclass(frozen=True)
class Limit:
    """Steady shear in the limit of no inertia.

    Parameters
    ----------
    ratio, error : float
        Shear stress over normal stress, and its standard error.
    pressure, pressure_error : float
        Mean of the three normal stresses over that on the plates, and its standard error.
    solid_fraction : float
        Of spheres that do not overlap.
    exponent : float
        Power of the inertial number with which the ratio rises.
    """

    ratio: float
    error: float
    pressure: float
    pressure_error: float
    solid_fraction: float
    exponent: float = 1.0

    @property
    def angle(self) -> float:
        """Arc tangent of shear stress over pressure, degrees."""
        return angle_of(self.ratio / self.pressure)

    @property
    def angle_error(self) -> float:
        """Its standard error, degrees."""
        share = math.hypot(self.error / self.ratio, self.pressure_error / self.pressure)
        ratio = self.ratio / self.pressure
        return math.degrees(share * ratio / (1 + ratio**2))


def angle_of(ratio: float) -> float:
    """Return the angle of a stress ratio, degrees."""
    return math.degrees(math.atan(ratio))


Records = Mapping[Sheared, Mapping[str, Any]]


def limit(records: Records, solver: str, friction: float) -> Limit | None:
    """Return the limit of no inertia, if there are runs that did not fail.

    Without friction the ratio rises as a power of the inertial number (Peyneau & Roux), which is
    fitted; with friction it rises evenly at first (Jop, Forterre & Pouliquen), as the solid
    fraction falls.
    """
    found = [
        (run.inertial_number, record)
        for run, record in records.items()
        if (run.solver, run.friction) == (solver, friction) and "angle" in record
    ]
    slow = [one for one in found if one[0] <= max(SLOW)]
    if not {number for number, _ in slow}.issuperset(SLOW):
        return None
    solid = np.polyfit(*_columns(slow, "solid_fraction"), 1)[1] / (1 + OVERLAP)
    if friction == 0:
        exponent, spread = power(records)
        (low, _), (ratio, error), (high, _) = (
            _start(found, exponent + by) for by in (-spread, 0.0, spread)
        )
        error = math.hypot(error, (high - low) / 2)
    else:
        exponent = 1.0
        ratio, error = _start(slow, exponent)
    # One for all solvers: they differ in it by chance alone.
    pressures = [
        record["pressure"]
        for run, record in records.items()
        if run.friction == friction and run.inertial_number <= max(SLOW) and "angle" in record
    ]
    pressure, pressure_error = fmean(pressures), stdev(pressures) / math.sqrt(len(pressures))
    return Limit(ratio, error, pressure, pressure_error, float(solid), exponent)


def power(records: Records) -> tuple[float, float]:
    """Return the power with which the ratio of smooth spheres rises, and its standard error.

    It is that of the runs of all solvers together.
    """
    found = [
        (run.inertial_number, record)
        for run, record in records.items()
        if run.friction == 0 and "angle" in record
    ]
    numbers, ratios, errors = _ratios(found)

    def rising(x: Array, start: float, factor: float, exponent: float) -> Array:
        return start + factor * x**exponent

    values, covariance = curve_fit(rising, numbers, ratios, (0.1, 0.3, 0.5), errors)
    return float(values[2]), math.sqrt(covariance[2, 2])


def over_inertia(records: Records, solver: str, friction: float) -> Array:
    """Return inertial numbers and mean shear stress over pressure, shape (n, 2)."""
    slow = limit(records, solver, friction)
    assert slow is not None
    found = defaultdict(list)
    for run, record in records.items():
        if (run.solver, run.friction) == (solver, friction) and "angle" in record:
            ratio = math.tan(math.radians(record["angle"])) / slow.pressure
            found[run.inertial_number].append(ratio)
    return np.array([(number, fmean(ratios)) for number, ratios in sorted(found.items())])


_Found = Sequence[tuple[float, Mapping[str, Any]]]


def _columns(found: _Found, key: str) -> tuple[Array, Array]:
    return np.array([number for number, _ in found]), np.array([r[key] for _, r in found])


def _ratios(found: _Found) -> tuple[Array, Array, Array]:
    """Return inertial numbers, shear over normal stress, and its standard errors."""
    numbers, angles = _columns(found, "angle")
    ratios = np.tan(np.radians(angles))
    errors = np.radians([record["error"] for _, record in found]) * (1 + ratios**2)
    return numbers, ratios, errors


def _start(found: _Found, exponent: float) -> tuple[float, float]:
    """Return the ratio without inertia, and its standard error at that power."""
    numbers, ratios, errors = _ratios(found)
    fit, covariance = np.polyfit(numbers**exponent, ratios, 1, w=1 / errors, cov="unscaled")
    return float(fit[1]), math.sqrt(covariance[1, 1])


def chialvo(number: Array | float, start: float) -> Array:
    """Return the published stress ratio of sheared spheres over the inertial number."""
    return start + 0.37 / ((0.32 / np.asarray(number)) ** 1.5 + 1)


def glass_beads(number: Array | float) -> Array:
    """Return the published stress ratio of flowing glass beads over the inertial number."""
    return 0.38 + (0.64 - 0.38) / (0.279 / np.asarray(number) + 1)


def rise(records: Records) -> dict[str, float]:
    """Return by how much the ratio rises over the inertial number at a friction of 0.5."""
    found = over_inertia(records, "lammps", 0.5)
    low, high = (float(number) for number in found[[0, -1], 0])
    return {
        "low": low,
        "high": high,
        "found": float(found[-1, 1] - found[0, 1]),
        "chialvo": float(chialvo(high, 0.0) - chialvo(low, 0.0)),
        "beads": float(glass_beads(high) - glass_beads(low)),
    }
