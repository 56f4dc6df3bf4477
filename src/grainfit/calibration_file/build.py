"""Turn what a calibration file says into a problem and the solvers that its tests need."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from grainfit.calibration.provenance import Provenance
from grainfit.calibration.timeouts import default_timeouts
from grainfit.calibration_file.content import CalibrationFile, StrategyOptions, TestSpecification
from grainfit.campaign.cluster.executor import is_available
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import Fault, InputError
from grainfit.evaluation import response_name
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.options.kinds import Quantity, suggest
from grainfit.options.places import Findings, Place
from grainfit.problem import Problem
from grainfit.solvers.base import Solver
from grainfit.solvers.registry import types_of_test
from grainfit.solvers.type_of_test import FileEntry
from grainfit.units import is_unit

_RAYLEIGH = ("particle.density", "particle.youngs_modulus", "particle.poissons_ratio")


@dataclass(frozen=True)
class CalibrationSetup:
    """A calibration that is ready to run.

    Parameters
    ----------
    file : CalibrationFile
        What it was made of.
    problem : Problem
        Free parameters and targets; with several tests, targets are called ``test.response``.
    solvers : dict of str to Solver
        By name of the test. They take the values of the free parameters, and of fixed ones that
        are to differ from the file.
    local : bool
        Make the runs on this machine even when the file has a cluster.
    """

    file: CalibrationFile
    problem: Problem
    solvers: dict[str, Solver]
    local: bool = False

    @property
    def name(self) -> str:
        """What is calibrated, for people."""
        return self.file.name

    @property
    def strategy(self) -> StrategyOptions:
        """What the file says of the search."""
        return self.file.strategy

    @property
    def timeouts(self) -> dict[str, float]:
        """Longest wall time of a run by name of the test, s, where there is one.

        A bulk test has one even when the file gives none: a solver that hangs must not stop the
        calibration for ever.
        """
        given = {t.name: t.options["timeout"] for t in self.file.tests if "timeout" in t.options}
        return default_timeouts(self.problem, self.solvers) | given

    @property
    def cluster(self) -> ClusterOptions | None:
        """Jobs in which the runs are made; None when they are made on this machine."""
        cluster = self.file.cluster
        if cluster is None or self.local or not is_available(cluster):
            return None
        return replace(cluster, cores_per_run=cluster.cores_per_run or self._ranks)

    @property
    def workers(self) -> int:
        """Runs at a time: as many as the jobs take, as the file says, or as there are cores for."""
        if self.cluster is not None:
            return self.cluster.workers
        if self.strategy.workers is not None:
            return self.strategy.workers
        return max(1, len(os.sched_getaffinity(0)) // self._ranks)

    @property
    def _ranks(self) -> int:
        ranks: int = max(test.options.get("ranks", 1) for test in self.file.tests)
        return ranks

    @property
    def provenance(self) -> Provenance:
        """The file and its fixed parameters, for a report."""
        text = ""
        with suppress(OSError):
            text = self.file.path.read_text(encoding="utf-8", errors="replace")
        fixed = self.file.fixed
        units = {
            name: MATERIAL_PARAMETERS[name].unit for name in fixed.keys() & MATERIAL_PARAMETERS
        }
        return Provenance(self.file.path.name, text, fixed, units)

    def options(
        self,
        strategy: str | None = None,
        max_runs: int | None = None,
        seed: int | None = None,
        workers: int | None = None,
        keep: str | None = None,
    ) -> dict[str, Any]:
        """Return the arguments of `grainfit.calibrate` for the search; what is given here wins."""
        given = {
            "strategy": strategy,
            "max_runs": max_runs,
            "seed": seed,
            "workers": workers,
            "keep": keep,
        }
        in_file = {
            "strategy": self.strategy.name,
            "max_runs": self.strategy.max_runs,
            "seed": self.strategy.seed,
            "workers": self.workers,
            "design_runs": self.strategy.design_runs,
            "verification_runs": self.strategy.verification_runs,
            "prefer": self.strategy.prefer,
            "extend_intervals": self.strategy.extend_intervals,
            "keep": self.strategy.keep,
        }
        return _without_none(in_file) | _without_none(given)

    def values(self, settings: Iterable[str]) -> dict[str, float]:
        """Return values of all free parameters, and of whatever is set.

        Parameters
        ----------
        settings : iterable of str
            ``NAME=VALUE``; a value may have a unit. Free parameters that are not set take the
            middle of their interval.

        Raises
        ------
        InputError
            A setting has another form, names no parameter of the file, or is no possible value.
        """
        findings = Findings(self.file.path.parent)
        values = self.problem.from_unit([0.5] * self.problem.dimension)
        for setting in settings:
            name, _, text = setting.partition("=")
            place = Place(findings, tuple(name.strip().split(".")))
            values |= self._set(name.strip(), text.strip(), place)
        if findings.faults:
            raise InputError(findings.faults)
        return values

    def _set(self, name: str, text: str, place: Place) -> dict[str, float]:
        known = [parameter.name for parameter in self.file.parameters] + list(self.file.fixed)
        if name not in known:
            place.fault("is not a parameter of the file.", suggest(name, known, "It has"))
        elif not text:
            place.fault("is given no value.", f"Write {name}=VALUE.")
        elif (value := self.quantity(name).read(_number_or_text(text), place)) is not None:
            return {name: value}
        return {}

    def quantity(self, name: str) -> Quantity:
        """Return the unit and the physical limits of a parameter."""
        if name in MATERIAL_PARAMETERS:
            known = MATERIAL_PARAMETERS[name]
            return Quantity(known.unit, known.lowest, known.highest)
        units = [p.unit for p in self.file.parameters if p.name == name and is_unit(p.unit)]
        return Quantity(units[0] if units and units[0] else None)


def build_calibration(file: CalibrationFile) -> CalibrationSetup:
    """Make the problem and one solver for each test; nothing is executed.

    Parameters
    ----------
    file : CalibrationFile
        As `grainfit.calibration_file.load_calibration_file` gives it.

    Raises
    ------
    InputError
        A test cannot be simulated as the file says; all faults of all tests.
    """
    solvers: dict[str, Solver] = {}
    faults: list[Fault] = []
    for index, test in enumerate(file.tests):
        try:
            solvers[test.name] = types_of_test()[test.type].make_solver(_entry(file, test))
        except InputError as error:
            faults += _faults_of_test(index, error)
    if faults:
        raise InputError(faults, str(file.path))
    return CalibrationSetup(file, _problem(file), solvers)


def _problem(file: CalibrationFile) -> Problem:
    targets = [
        replace(target, name=response_name(test.name, target.name, len(file.tests)))
        for test in file.tests
        for target in test.targets
    ]
    return Problem(
        file.parameters,
        targets,
        _rayleigh(file),
        rayleigh_weight=file.strategy.rayleigh_weight or 0,
    )


def _rayleigh(file: CalibrationFile) -> RayleighTimeStep | None:
    known = {*file.fixed, *(parameter.name for parameter in file.parameters)}
    if file.sizes is None or not known.issuperset(_RAYLEIGH):
        return None
    fixed = {name: file.fixed[name] for name in _RAYLEIGH if name in file.fixed}
    return RayleighTimeStep(file.sizes.smallest_radius, fixed)


def _entry(file: CalibrationFile, test: TestSpecification) -> FileEntry:
    return FileEntry(
        test.options,
        tuple(target.name for target in test.targets),
        tuple(parameter.name for parameter in file.parameters),
        file.fixed,
        file.sizes,
    )


def _faults_of_test(index: int, error: InputError) -> list[Fault]:
    """Say of which test a solver speaks; it knows only its own arguments."""
    if error.source:
        return [Fault(f"test[{index}]", f"{error.source}: {fault}") for fault in error.faults]
    return [replace(fault, key=f"test[{index}].{fault.key}") for fault in error.faults]


def _without_none(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
