"""Predict tests that took no part in a calibration, for its work folder or any other material."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from grainfit.analysis.analysis import analyse_parameters
from grainfit.calibration.holdout import (
    Holdout,
    Material,
    predict_holdout,
    require_holdouts,
    require_not_fitted,
)
from grainfit.calibration.holdout_runs import HoldoutProgress
from grainfit.calibration.holdouts_after import options_of_holdout
from grainfit.calibration.registrations import HoldoutFile
from grainfit.calibration_file.build import CalibrationSetup, build_holdouts, load_calibration
from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.cluster.executor import cluster_executor
from grainfit.campaign.open_campaign import held_store
from grainfit.campaign.work_folder import RESULT_NAME, default_workdir, simulations_folder
from grainfit.errors import InputError, StoreError
from grainfit.files import writing
from grainfit.formatting import number, value_with_unit
from grainfit.metamodels.checked_arrays import BEYOND_CUBE
from grainfit.options.kinds import suggest
from grainfit.result import HoldoutResult
from grainfit.solvers.base import Solver
from grainfit.tables import Summary
from grainfit.validation import plain, whole_number_faults
from grainfit.work_folder import messages
from grainfit.work_folder.given_material import (
    answer_for,
    in_place_of_fixed,
    material_of_file,
)
from grainfit.work_folder.saved_calibration import SavedCalibration, read_answer


@dataclass(frozen=True)
class Predictions(Summary):
    """Predictions of tests that took no part in a calibration.

    Parameters
    ----------
    material : str
        Work folder or file of the material.
    holdouts : tuple of HoldoutResult
        One for each test.
    remarks : tuple of str
        In what the material is not the answer of the calibration, or the file not its own.
    """

    material: str
    holdouts: tuple[HoldoutResult, ...]
    remarks: tuple[str, ...] = ()

    def __getitem__(self, test: str) -> HoldoutResult:
        """Return the prediction of a test."""
        return next(one for one in self.holdouts if one.test == test)

    def __repr__(self) -> str:
        tests = ", ".join(one.test for one in self.holdouts)
        return f"<Predictions of {tests:.40} by {self.material!r:.50}>"

    def summary(self) -> tuple[str, ...]:
        """Return the sentences that `print` and a notebook show."""
        sentences = (sentence for one in self.holdouts for sentence in one.sentences())
        return (*sentences, *self.remarks)

    def to_dict(self) -> dict[str, Any]:
        """Return the predictions as plain data."""
        holdouts = [asdict(one) for one in self.holdouts]
        return {"material": self.material, "holdouts": holdouts, "remarks": self.remarks}


def predict(
    source: str | Path | CalibrationSetup,
    *,
    answer_of: str | Path | SavedCalibration | None = None,
    tests: Sequence[str] = (),
    settings: Sequence[str] = (),
    workdir: str | Path | None = None,
    workers: int | None = None,
    on_progress: Callable[[str, int, int], None] = lambda *_: None,
) -> Predictions:
    """Predict tests that took no part in a calibration, and compare them with measured values.

    Parameters
    ----------
    source : path or CalibrationSetup
        Calibration file with the tests: its ``[[holdout]]``, which need no measured values.
    answer_of : path or SavedCalibration, optional
        The material: a calibration or its work folder, by default that of the file; or a material
        card (JSON) or a TOML file with values of the parameters.
    tests : sequence of str
        Names of tests of the file, ``[[test]]`` included; by default every hold-out.
    settings : sequence of str
        ``NAME=VALUE``, for parameters that are to have another value, or have none yet.
    workdir : path, optional
        Where runs are kept; by default the work folder of the calibration, if it is that of the
        file, or else the file's name with ``.simulated``. After Ctrl-C, another call continues.
    workers : int, optional
        Runs at a time; by default those of the file.
    on_progress : callable, optional
        Called with the name of the test and the numbers of finished and of all runs.

    Returns
    -------
    Predictions
        `print` shows them. Those of the file of a calibration at its answer are written into its
        result.

    Raises
    ------
    InputError
        The file has faults, there is no such test, or it was fitted; or the material is missing or
        leaves a free parameter open.
    SolverNotFoundError
        A program is not found.
    StoreError
        A folder cannot be used.

    Examples
    --------
    >>> import grainfit as gf
    >>> found = gf.predict("beads.toml")  # doctest: +SKIP
    >>> found["drum"].responses["dynamic_angle"].verdict  # doctest: +SKIP
    'predicts'
    """
    setup = source if isinstance(source, CalibrationSetup) else load_calibration(source)
    workers = setup.workers if workers is None else plain(workers)
    InputError.raise_for(whole_number_faults({"workers": workers}))
    given = answer_of or default_workdir(setup.file.path)
    place = given.folder if isinstance(given, SavedCalibration) else Path(given)
    is_saved = answer_of is None or place.is_dir()
    saved = SavedCalibration.of(given) if is_saved else None
    holdouts = _chosen(setup, tests)
    if saved is None:
        material = material_of_file(setup, place, settings)
        asked = _Asked(material, tuple(setup.outside(settings)))
    else:
        asked = _asked_of_calibration(setup, saved, settings)
        fitted = {one.test: one.definition.model_hash for one in saved.records.values()}
        require_not_fitted(saved.problem, fitted, holdouts)
    material = asked.material
    require_holdouts(material.problem, {}, holdouts)
    usual = place if asked.is_of_file else simulations_folder(setup.file.path)
    folder = Path(workdir or usual).absolute()
    is_elsewhere = saved is not None and folder == saved.folder.absolute() and not asked.is_of_file
    # The folder of a calibration may have a hold-out of that name of its own.
    prefix = f"{setup.file.path.name}: " if is_elsewhere else ""
    with ExitStack() as stack:
        executor = None
        if setup.cluster is not None:
            executor = stack.enter_context(cluster_executor(setup.cluster, folder))
        store = stack.enter_context(held_store(folder))
        making = CampaignOptions(workers, executor=executor)
        file = HoldoutFile(folder)
        finished = sum(state == "finished" for state in store.states().values())
        text = setup.provenance.text
        known = {
            one.name: file.register(prefix + one.name, one.measured, text, finished)
            for one in holdouts
        }

        def make(holdout: Holdout, solver: Solver) -> Campaign:
            limited = options_of_holdout(holdout, material.problem, making)
            return Campaign({holdout.name: solver}, store, folder, limited)

        def show(holdout: Holdout) -> Callable[[HoldoutProgress], None]:
            return lambda now: on_progress(holdout.name, now.done, now.of)

        found = []
        for one in holdouts:
            found.append(predict_holdout(one, material, file, make, show(one), known[one.name]))
            if saved is not None and asked.is_kept and folder == saved.folder.absolute():
                _keep(saved, found)
    return Predictions(str(place), tuple(found), asked.remarks)


@dataclass(frozen=True)
class _Asked:
    """A material, and what of it is another than the answer of a calibration.

    Parameters
    ----------
    material : Material
        The material.
    remarks : tuple of str
        What is another.
    is_kept : bool
        Whether predictions belong to the result of the calibration.
    is_of_file : bool
        Whether it is that of the calibration of the file itself.
    """

    material: Material
    remarks: tuple[str, ...]
    is_kept: bool = False
    is_of_file: bool = False


def _asked_of_calibration(
    setup: CalibrationSetup, saved: SavedCalibration, settings: Sequence[str]
) -> _Asked:
    """Return the material of a calibration, for the tests of a file."""
    file, answer = setup.file.path.name, answer_for(setup, saved, settings)
    material = _material(setup, saved, answer, settings)
    others, is_own = _others(setup, answer, material), saved.source == file
    foreign = [] if is_own else [messages.OF_ANOTHER_FILE(file=file, folder=str(saved.folder))]
    fixed = in_place_of_fixed(setup, answer, settings)
    remarks = (*setup.outside(settings), *fixed, *others, *foreign)
    return _Asked(material, remarks, is_own and not others, is_own)


def _chosen(setup: CalibrationSetup, names: Sequence[str]) -> list[Holdout]:
    """Return the tests of a file with some names; its hold-outs without any."""
    if not names:
        if not setup.holdouts:
            raise InputError(messages.NO_HOLDOUT.fault(""))
        return list(setup.holdouts)
    known = {one.name: one for one in setup.holdouts}
    fitted = {test.name: test for test in setup.file.tests}
    for name in names:
        if name not in known and name not in fitted:
            remedy = suggest(name, [*known, *fitted], "There are")
            raise InputError(messages.NO_SUCH_TEST.fault("test", given=name, remedy=remedy))
    others = build_holdouts(setup.file, [fitted[name] for name in names if name in fitted])
    known |= {one.name: one for one in others}
    return [known[name] for name in dict.fromkeys(names)]


def _material(
    setup: CalibrationSetup,
    saved: SavedCalibration,
    answer: Mapping[str, float],
    settings: Sequence[str],
) -> Material:
    """Return the answer of a calibration, and the parameter sets that agree with its tests."""
    values = setup.values(settings, answer)
    InputError.raise_for(
        messages.FAR_FROM_RUNS.fault(
            parameter.name,
            value=value_with_unit(values[parameter.name], parameter.unit),
            low=number(parameter.minimum),
            high=value_with_unit(parameter.maximum, parameter.unit),
        )
        for parameter in saved.problem.parameters
        if abs(parameter.to_unit(values[parameter.name]) - 0.5) > 0.5 + BEYOND_CUBE
    )
    found = analyse_parameters(saved.problem, saved.known, seed=saved.seed, answer=answer)
    if found.posterior is None:
        why = saved.why_nothing_agrees or " ".join(found.notes)
        folder = str(saved.folder)
        raise InputError(messages.NO_POSTERIOR.fault("", folder=folder, why=why))
    sample = found.posterior.points.copy()
    for axis, parameter in enumerate(saved.problem.parameters):
        if values[parameter.name] != answer[parameter.name]:
            sample[:, axis] = parameter.to_unit(values[parameter.name])
    return Material(saved.problem, values, sample, saved.seed, saved.identity)


def _others(setup: CalibrationSetup, answer: Mapping[str, float], material: Material) -> list[str]:
    """Return the parameters that are set to another value than the answer has, in sentences."""
    return [
        messages.ANOTHER_MATERIAL(
            name=name,
            value=value_with_unit(material.answer[name], setup.quantity(name).unit or ""),
            answer=value_with_unit(value, setup.quantity(name).unit or ""),
        )
        for name, value in answer.items()
        if material.answer[name] != value
    ]


def _keep(saved: SavedCalibration, found: Sequence[HoldoutResult]) -> None:
    """Write predictions into the result of their calibration."""
    result, path = read_answer(saved), saved.folder / RESULT_NAME
    names = {one.test for one in found}
    others = [one for one in result.holdouts if one.test not in names]
    with writing(path, StoreError):
        replace(result, holdouts=(*others, *found)).to_json(path)
