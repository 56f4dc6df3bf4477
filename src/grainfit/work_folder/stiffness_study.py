"""Stiffness of the particles: simulate a material again with stiffer ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from grainfit.analysis.modulus_plan import ModulusPlan, simulate_moduli
from grainfit.analysis.modulus_study import ModulusStudy, modulus_study
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.calibration_file.build import CalibrationSetup, load_calibration
from grainfit.campaign.batch import ExpectedWork
from grainfit.campaign.work_folder import default_workdir
from grainfit.errors import InputError
from grainfit.work_folder import messages
from grainfit.work_folder.saved_calibration import SavedCalibration, read_answer
from grainfit.work_folder.solvers_of_runs import solvers_of

FACTORS = (1.0, 4.0, 16.0)


def stiffness_study(
    source: str | Path | CalibrationSetup,
    *,
    factors: Sequence[float] = FACTORS,
    seeds: int = 3,
    settings: Sequence[str] = (),
    workdir: str | Path | None = None,
    workers: int | None = None,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> ModulusStudy:
    """Simulate the responses of a material at several Young's moduli of the particles.

    Soft particles allow a large time step, but overlap, which raises bulk densities. The study
    finds the smallest modulus at which every response stays within its tolerance of that of the
    stiffest particles.

    Parameters
    ----------
    source : path or CalibrationSetup
        Work folder of a calibration, whose answer is simulated; or a calibration file.
    factors : sequence of float
        Moduli to simulate, over that of the calibration.
    seeds : int
        Runs of each modulus.
    settings : sequence of str
        ``NAME=VALUE`` for a calibration file; free parameters that are not set take the middle of
        their interval.
    workdir : path, optional
        Where runs are kept; by default the work folder, for a file its name with ``.grainfit``,
        here. After Ctrl-C, another call continues.
    workers : int, optional
        Runs at a time; by default those of the calibration.
    on_start : callable, optional
        Called with the expected work before the first run.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.

    Returns
    -------
    ModulusStudy
        `print` shows it as a table.

    Raises
    ------
    InputError
        The source has no answer or no Young's modulus, or an option is impossible.
    SolverNotFoundError
        A program is not found.
    RunFailedError
        No modulus has all responses.
    StoreError
        The folder cannot be used.

    Examples
    --------
    >>> import grainfit as gf
    >>> study = gf.stiffness_study("beads.grainfit", factors=[1, 10])  # doctest: +SKIP
    >>> study.smallest_sufficient  # doctest: +SKIP
    """
    if not isinstance(source, CalibrationSetup) and Path(source).is_dir():
        given, folder = _of_answer(Path(source), settings), Path(source)
    else:
        setup = source if isinstance(source, CalibrationSetup) else load_calibration(source)
        given, folder = _of_file(setup, settings), default_workdir(setup.file.path)
    plan = ModulusPlan(**{**given, "factors": tuple(factors), "seeds": seeds})
    if workers is not None:
        plan = replace(plan, workers=workers)
    if not plan.problem.targets:
        raise InputError(messages.CURVES_ONLY.fault("targets"))
    evaluations = simulate_moduli(plan, Path(workdir or folder), on_start, on_progress)
    return modulus_study(plan, evaluations)


def _of_file(setup: CalibrationSetup, settings: Sequence[str]) -> dict[str, Any]:
    values = setup.values(settings)
    modulus = _modulus({**setup.file.fixed, **values}, str(setup.file.path))
    return {
        "solvers": setup.solvers,
        "problem": setup.problem,
        "parameters": {**values, MODULUS: modulus},
        "workers": setup.workers,
        "timeouts": setup.timeouts,
    }


def _of_answer(folder: Path, settings: Sequence[str]) -> dict[str, Any]:
    if settings:
        raise InputError(messages.SET_BESIDE_ANSWER.fault("set"))
    saved = SavedCalibration.open(folder)
    answer = read_answer(saved).parameters
    modulus = _modulus({**saved.fixed, **answer}, str(folder))
    return {
        "solvers": solvers_of(saved, messages.GIVE_FILE_AND_ANSWER()),
        "problem": saved.problem,
        "parameters": {**answer, MODULUS: modulus},
        "workers": saved.workers,
    }


def _modulus(values: Mapping[str, float], source: str) -> float:
    given = [name for name in values if name.endswith(".normal_stiffness") and values[name]]
    if given:
        raise InputError([messages.GIVEN_STIFFNESS.fault(name) for name in given], source)
    if MODULUS in values:
        return values[MODULUS]
    raise InputError(
        messages.NO_MODULUS.fault(MODULUS),
        source,
    )
