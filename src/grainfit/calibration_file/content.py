"""What a calibration file says, once it has been read: plain data in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.materials.sizes import ParticleSizes
from grainfit.problem import Parameter, Target
from grainfit.strategies.registry import DEFAULT_STRATEGY, StrategyChoice
from grainfit.strategies.sequential.options import Preference


@dataclass(frozen=True)
class TestSpecification:
    """One bulk test of a calibration file.

    Parameters
    ----------
    name : str
        As given, or else the type.
    type : str
        One of `grainfit.solvers.registry.types_of_test`.
    options : mapping of str to object
        Everything else that the file says of the test, by key; only what is given.
    targets : tuple of Target
        Named by response.
    """

    # Keeps pytest from taking it for a class of tests.
    __test__: ClassVar[bool] = False

    name: str
    type: str
    options: Mapping[str, Any]
    targets: tuple[Target, ...]


@dataclass(frozen=True)
class StrategyOptions:
    """What a calibration file says of the search; None where it leaves the default.

    Parameters
    ----------
    name : str
        Name of the strategy.
    max_runs : int, optional
        Budget of DEM runs.
    seed : int, optional
        Seed of the design and of the runs' seeds.
    workers : int, optional
        Runs at once.
    design_runs, verification_runs : int, optional
        Runs of the design, and at the answer.
    prefer : {"time_step", "accuracy"}, optional
        Which of the parameter sets that agree is the answer.
    extend_intervals : bool, optional
        Whether bounds that are in the way are moved.
    rayleigh_weight : float, optional
        Weight of the Rayleigh criterion in the misfit.
    keep : {"all", "results"}, optional
        What stays of the folder of a finished run.
    """

    name: str = DEFAULT_STRATEGY
    max_runs: int | None = None
    seed: int | None = None
    workers: int | None = None
    design_runs: int | None = None
    verification_runs: int | None = None
    prefer: Preference | None = None
    extend_intervals: bool | None = None
    rayleigh_weight: float | None = None
    keep: Literal["all", "results"] | None = None

    def choice(self) -> StrategyChoice:
        """Return the strategy with its options."""
        return StrategyChoice(self.name, self.design_runs, self.prefer, self.extend_intervals)


@dataclass(frozen=True)
class CalibrationFile:
    """What a calibration file says, free of faults.

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
    strategy : StrategyOptions
        How to search.
    cluster : ClusterOptions or None
        Jobs of a cluster to make the runs in, when the file speaks of them.
    """

    name: str
    path: Path
    sizes: ParticleSizes | None
    fixed: Mapping[str, float]
    parameters: tuple[Parameter, ...]
    tests: tuple[TestSpecification, ...]
    strategy: StrategyOptions
    cluster: ClusterOptions | None = None
