"""Content of a calibration file that has been read: plain data in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

from grainfit import platforms
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.instrument import Instrument
from grainfit.calibration.options import CalibrationOptions
from grainfit.calibration_file.photographed import PhotographedTarget
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.evaluation import response_name
from grainfit.materials.sizes import ParticleSizes
from grainfit.one_line import OneLine
from grainfit.problem import CurveTarget, Parameter, Target
from grainfit.problem.correlations import Correlation
from grainfit.strategies.base import Strategy
from grainfit.strategies.sequential.strategy import Sequential


@dataclass(frozen=True)
class PlannedTarget:
    """A measurement that could be made.

    Parameters
    ----------
    value : float, optional
        Expected value, in the unit of the response.
    accuracy : Accuracy, optional
        Accuracy of the measurement; None for the usual one.
    """

    value: float | None = None
    accuracy: Accuracy | None = None


@dataclass(frozen=True)
class TestSpecification(OneLine):
    """One bulk test of a calibration file.

    Parameters
    ----------
    name : str
        Given name, or else the type.
    type : str
        One of `grainfit.solvers.registry.types_of_test`.
    options : mapping of str to object
        Other options of the test, by key; only those given, by the file or by the instrument.
    targets : tuple of Target
        Named by response.
    planned : mapping of str to PlannedTarget
        Instead of targets, responses that could be measured, in a file that is read before the
        laboratory; none means all of the test.
    correlations : tuple of (str, str, float)
        Correlations of the errors of the measured values: two responses and a coefficient.
    curves : tuple of CurveTarget
        Measured curves, named by response.
    repeats : int
        Runs with different seeds whose mean is one evaluation.
    number : int
        Position in the file, from 0; the first one of tests that are joined.
    joined : tuple of str
        Names of the tests of the file that are evaluations of this one simulation.
    instrument : Instrument, optional
        Apparatus that is given by its name, with the options alone that it decides.
    given : tuple of str, optional
        Options that the file gives beside an instrument; None without one, where it gives all.
    """

    # Keeps pytest from taking it for a class of tests.
    __test__: ClassVar[bool] = False

    name: str
    type: str
    options: Mapping[str, Any]
    targets: tuple[Target, ...]
    planned: Mapping[str, PlannedTarget] = field(default_factory=dict)
    correlations: tuple[Correlation, ...] = ()
    curves: tuple[CurveTarget, ...] = ()
    repeats: int = 1
    number: int = 0
    joined: tuple[str, ...] = ()
    instrument: Instrument | None = None
    given: tuple[str, ...] | None = None

    @property
    def of_instrument(self) -> tuple[str, ...]:
        """Options that have the values of the instrument."""
        return () if self.instrument is None else tuple(self.instrument.options)

    @property
    def responses(self) -> tuple[str, ...]:
        """Names of the responses that were measured, curves last, or that could be measured."""
        measured = [*(one.name for one in self.targets), *(one.name for one in self.curves)]
        return (*measured, *self.planned)


@dataclass(frozen=True)
class SearchOptions(CalibrationOptions, OneLine):
    """Content of ``[strategy]``; None where the file leaves the default.

    Parameters
    ----------
    max_runs, seed, workers, verification_runs, keep : optional
        As in `CalibrationOptions`.
    strategy : Strategy
        The strategy with its options.
    rayleigh_weight : float, optional
        Weight of the Rayleigh criterion in the misfit.
    softer : float, optional
        Young's modulus of the particles of a cheaper relative of every test, Pa.
    coarser, smaller : float, optional
        Times the particle diameters, and share of the number of particles, of that relative.
    twins : int, optional
        Particles of the smaller apparatus that are simulated instead of larger ones.
    """

    strategy: Strategy = field(default_factory=Sequential)
    rayleigh_weight: float | None = None
    softer: float | None = None
    coarser: float | None = None
    smaller: float | None = None
    twins: int | None = None


@dataclass(frozen=True)
class CalibrationFile(OneLine):
    """Content of a calibration file that has no faults.

    Parameters
    ----------
    name : str
        For people only; never part of a path.
    path : Path
        The file.
    sizes : ParticleSizes or None
        Particle diameters, when given.
    fixed : mapping of str to float
        Values of the parameters that are not free, by dotted name (``particle.density``) or by the
        bare name of an own parameter.
    parameters : tuple of Parameter
        The free parameters, in the order of the file.
    tests : tuple of TestSpecification
        At least one.
    strategy : SearchOptions
        Options of the search.
    cluster : ClusterOptions or None
        Cluster jobs for the runs, if the file has them.
    contact_models : tuple of str
        Contact models that replace the usual ones of their kind.
    measured_angles : mapping of str to str
        What is said of frictions that were measured as angles, by name.
    tables : tuple of str
        How the tables that the file names were understood, one line each.
    holdouts : tuple of TestSpecification
        Tests that take no part in the fit; their targets may be missing.
    photographs : tuple of PhotographedTarget
        What was measured on the photographs of each target.
    """

    name: str
    path: Path
    sizes: ParticleSizes | None
    fixed: Mapping[str, float]
    parameters: tuple[Parameter, ...]
    tests: tuple[TestSpecification, ...]
    strategy: SearchOptions
    cluster: ClusterOptions | None = None
    contact_models: tuple[str, ...] = ()
    measured_angles: Mapping[str, str] = field(default_factory=dict)
    tables: tuple[str, ...] = ()
    holdouts: tuple[TestSpecification, ...] = ()
    photographs: tuple[PhotographedTarget, ...] = ()

    @property
    def photographed(self) -> list[tuple[str, PhotographedTarget]]:
        """What was measured on photographs, by response in the problem, or by parameter."""
        names = {test.number: test.name for test in self.tests}
        several = len(self.tests)
        return [
            (
                response_name(names.get(one.test, ""), one.response, several)
                if one.key.startswith("test[")
                else one.key,
                one,
            )
            for one in self.photographs
            if not one.key.startswith("holdout[")
        ]

    @property
    def ranks(self) -> int:
        """Largest number of MPI ranks of a run."""
        return max(int(test.options.get("ranks", 1)) for test in (*self.tests, *self.holdouts))

    @property
    def timeouts(self) -> dict[str, float]:
        """Longest wall time of a run by name of the test, s, where the file gives one."""
        return {t.name: t.options["timeout"] for t in self.tests if "timeout" in t.options}

    @property
    def repeats(self) -> dict[str, int]:
        """Runs with different seeds whose mean is one evaluation, by name of the test."""
        return {test.name: test.repeats for test in self.tests}

    @property
    def runs_at_once(self) -> int:
        """Number of runs that this machine has cores for."""
        return max(1, self.cores // self.ranks)

    @property
    def cores(self) -> int:
        """Number of cores that this process may use."""
        return platforms.cores()
