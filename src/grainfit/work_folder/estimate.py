"""Parameters that agree with the measurements of a calibration file by the atlas, at once."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from grainfit.atlas.estimate import Estimate, estimate_of
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.parameter_names import DENSITY as PARTICLE_DENSITY
from grainfit.bulk_tests.parameter_names import ROLLING, SLIDING
from grainfit.calibration_file.build import CalibrationSetup, load_calibration
from grainfit.calibration_file.checks.solid_fractions import impossible_bulk_density
from grainfit.calibration_file.checks.unusual_values import unusual_angles
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import InputError
from grainfit.materials.size_distributions import DIAMETER
from grainfit.options.fields import read_options
from grainfit.options.tables import Key
from grainfit.problem import Parameter, Problem, Target
from grainfit.relative_names import is_relative
from grainfit.solvers.check_context import CheckContext
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.work_folder import messages
from grainfit.work_folder.open_folder import open_folder
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.solvers_of_runs import solver_of_run

#: Bulk over particle density of poured beds: between very loose and dense.
_LOOSE, _DENSE = 0.5, 0.65
_DENSITY = "kg/m^3"
#: What is given without a file.
_GIVEN = (
    Key("--diameter", DIAMETER, "Diameter of the particles."),
    Key("--bulk-density", Heap.responses["bulk_density"].possible, "Measured bulk density."),
    Key("--angle", Heap.responses["angle_of_repose"].possible, "Measured angle of repose."),
    Key("--density", MATERIAL_PARAMETERS[PARTICLE_DENSITY].possible, "Density of the particles."),
)
#: Walls of steel, and restitutions and stiffness that are usual.
_USUAL: Mapping[str, float] = {
    "particle.youngs_modulus": 10e6,
    "particle.poissons_ratio": 0.3,
    "wall.youngs_modulus": 211e9,
    "wall.poissons_ratio": 0.3,
    "wall.density": 7700.0,
    "particle_particle.restitution": 0.5,
    "particle_particle.rolling_damping": 0.0,
    "particle_wall.sliding_friction": 0.3,
    "particle_wall.rolling_friction": 0.05,
    "particle_wall.restitution": 0.5,
    "particle_wall.rolling_damping": 0.0,
}


def estimate(source: str | Path | CalibrationSetup, *, seed: int = 1) -> Estimate:
    """Estimate the parameters that agree with the measurements, by the atlas alone.

    Nothing is simulated: the atlas has runs of the bulk tests in natural units, which tell about
    any size and density of the particles. An estimate is no calibration.

    Parameters
    ----------
    source : path or CalibrationSetup
        A calibration file.
    seed : int
        Decides the sample of the parameters.

    Returns
    -------
    Estimate
        `print` shows it.

    Raises
    ------
    InputError
        The file is wrong, or the atlas tells nothing about any target: the reasons are named.

    Examples
    --------
    >>> import grainfit as gf
    >>> print(gf.estimate("beads.toml"))  # doctest: +SKIP
    """
    setup = source if isinstance(source, CalibrationSetup) else load_calibration(source)
    found = estimate_of(setup.problem, setup.solvers, seed=seed)
    return _with_doubts(found, CheckContext(setup.problem, setup.solvers, setup.file.fixed))


def _with_doubts(found: Estimate, context: CheckContext) -> Estimate:
    """Return an estimate that names impossible measured values, as ``check`` does."""
    impossible = (text for _, text in unusual_angles(context))
    dense = (finding.text for finding in impossible_bulk_density(context))
    return replace(found, doubts=(*dense, *impossible))


def estimate_of_running(folder: Path) -> Estimate | None:
    """Estimate the parameters of a calibration by the runs that it has asked for.

    Returns
    -------
    Estimate or None
        None where the atlas tells nothing about its targets, or where a smaller apparatus than
        that of the targets is simulated.
    """
    saved = SavedCalibration.open(folder)
    with open_folder(folder) as opened:
        records = opened.records_of(opened.requests[: len(saved.problem.parameters) + 1])
    free = {parameter.name for parameter in saved.problem.parameters}
    if not records or saved.problem.ratios:
        return None
    try:
        solvers = {
            one.test: solver_of_run(one, free)
            for one in records.values()
            if not is_relative(one.test)
        }
        return estimate_of(saved.problem, solvers)
    except InputError:
        return None


def estimate_of_heap(
    diameter: str, bulk_density: str = "", angle: str = "", density: str = ""
) -> Estimate:
    """Estimate the parameters of spheres from what a lifted cylinder on a rough plate gave.

    Friction and restitution at walls, and the stiffness, are usual ones.

    Parameters
    ----------
    diameter : str
        Of the particles, such as ``"3 mm"``.
    bulk_density, angle : str
        Measured values, such as ``"540 kg/m^3"`` and ``"34 deg"``; one may be empty.
    density : str
        Of the particles; by default it is estimated from the bulk density.

    Raises
    ------
    InputError
        A quantity is wrong, nothing is measured, or neither density is known.
    """
    if not (bulk_density or angle):
        raise InputError(messages.NOTHING_MEASURED.fault("--angle"))
    if not (density or bulk_density):
        raise InputError(messages.NO_DENSITY.fault("--density"))
    given = {
        "--diameter": diameter,
        "--bulk-density": _plain(bulk_density),
        "--angle": angle,
        "--density": _plain(density),
    }
    known = read_options(_GIVEN, {key: value for key, value in given.items() if value != ""})
    bulk = known["--bulk-density"]
    measured = (("bulk_density", bulk, "1 %"), ("angle_of_repose", known["--angle"], "1 deg"))
    targets = [
        Target(name, value, uncertainty=error, unit=Heap.responses[name].unit)
        for name, value, error in measured
        if value
    ]
    free = [Parameter(SLIDING, 0.05, 1.0), Parameter(ROLLING, 0.01, 1.0)]
    material = dict(_USUAL)
    if known["--density"]:
        material[PARTICLE_DENSITY] = known["--density"]
    else:
        ends = bulk / _DENSE, bulk / _LOOSE
        free.insert(0, Parameter(PARTICLE_DENSITY, *ends, unit=_DENSITY))
    rough: dict[str, Any] = Heap.options_for({})
    test = Heap(diameter=known["--diameter"], **rough)
    problem, solvers = Problem(free, targets), {Heap.type: Lammps(test, material)}
    return _with_doubts(estimate_of(problem, solvers), CheckContext(problem, solvers, material))


def _plain(density: str) -> str | float:
    """Return a density that is given without a unit as a number."""
    with suppress(ValueError):
        return float(density)
    return density
