"""Calibration problems with a known solution and no simulation, to compare strategies.

(a) the heap test of `data/dem_study/data.csv`, (b) that of `data4.csv`, each as an emulator of the
recorded runs plus their noise, and (c) an analytic problem of six parameters and four responses.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grainfit.metamodels.kriging import Kriging
from grainfit.problem import Parameter, Problem, Target

Array = NDArray[np.float64]
#: Expected responses, shape (m, k), at parameter values, shape (m, d), in the problem's order.
Truth = Callable[[Array], Array]

DATA = Path(__file__).parent / "data" / "dem_study"
#: Scatter of the recorded replicates from seed to seed, kg/m^3 and degrees.
HEAP_NOISE = (3.7, 0.80)
HEAP_TARGETS = ("bulk_density", "angle_of_repose")
#: Relative tolerance of the bulk density and tolerance of the angle of repose, as in the examples.
BULK_DENSITY_TOLERANCE, ANGLE_TOLERANCE = 0.01, 0.5
#: Parameters of the recorded runs: column, name, recorded interval, scale.
RECORDED = {
    "density": ("particle.density", 714.0, 3486.0, "linear"),
    "mu_r": ("particle_particle.rolling_friction", 0.2278, 1.1122, "linear"),
    "mu_s": ("particle_particle.sliding_friction", 0.06, 0.30, "linear"),
    "E": ("particle.youngs_modulus", 2e5, 1e7, "log"),
}
NOMINAL = {"density": 2100.0, "mu_r": 0.67}
#: Targets are responses of a point at least this far from the bounds of the unit cube.
MARGIN = 0.1


@dataclass(frozen=True)
class Case:
    """A calibration problem, and the true expected responses of its model.

    ``noise`` has the standard deviation of every response from seed to seed, shape (k,).
    """

    problem: Problem
    truth: Truth
    noise: Array

    @property
    def targets(self) -> Array:
        """Values of the targets, shape (k,)."""
        return np.array([target.value for target in self.problem.targets])

    @property
    def tolerances(self) -> Array:
        """Their tolerances, shape (k,)."""
        return np.array([target.tolerance for target in self.problem.targets])

    def expected(self, parameters: Mapping[str, float]) -> Array:
        """True expected responses, shape (k,)."""
        row = [parameters[parameter.name] for parameter in self.problem.parameters]
        return self.truth(np.array([row]))[0]

    def simulate(self, parameters: Mapping[str, float], seed: int) -> Array:
        """Responses of one noisy run, shape (k,)."""
        scatter = np.random.default_rng(seed).standard_normal(len(self.noise))
        return np.asarray(self.expected(parameters) + self.noise * scatter)

    def misfit(self, responses: Array) -> float:
        """Sum of squared deviations in units of the tolerances, which every method minimises."""
        return float(np.sum(((responses - self.targets) / self.tolerances) ** 2))

    def deviations(self, parameters: Mapping[str, float]) -> Array:
        """True relative deviation of every expected response from its target, shape (k,)."""
        return np.abs(self.expected(parameters) / self.targets - 1)

    def tolerances_off(self, parameters: Mapping[str, float]) -> float:
        """Largest true deviation of an expected response, in units of its tolerance."""
        off = np.abs(self.expected(parameters) - self.targets) / self.tolerances
        return float(off.max())


def true_parameters(problem: Problem, seed: int) -> dict[str, float]:
    """Return the parameter set whose responses are the targets: random, not near the bounds."""
    random = np.random.default_rng([seed, 2016])
    return problem.from_unit(random.uniform(MARGIN, 1 - MARGIN, problem.dimension))


def _target_the_responses_of(case: Case, seed: int, relative: Mapping[str, float]) -> Case:
    """Return the same problem with the responses of a random parameter set as targets."""
    values = case.expected(true_parameters(case.problem, seed))
    targets = [
        Target(
            target.name,
            float(value),
            tolerance=relative[target.name] * float(value)
            if target.name in relative
            else ANGLE_TOLERANCE,
        )
        for target, value in zip(case.problem.targets, values, strict=True)
    ]
    return Case(Problem(case.problem.parameters, targets), case.truth, case.noise)


def _recorded_interval(column: str) -> Parameter:
    name, low, high, scale = RECORDED[column]
    return Parameter(name, low, high, "log" if scale == "log" else "linear")


@cache
def _emulator(file: str) -> tuple[tuple[str, ...], Truth]:
    """Return the columns of the free parameters, and Kriging of all recorded runs."""
    with (DATA / file).open() as stream:
        rows = list(csv.DictReader(stream))
    columns = tuple(column for column in RECORDED if column in rows[0])
    recorded = Problem([_recorded_interval(c) for c in columns], [Target("none", 1.0)])

    def units(values: Array) -> Array:
        names = [parameter.name for parameter in recorded.parameters]
        return np.array([recorded.to_unit(dict(zip(names, row, strict=True))) for row in values])

    points = units(np.array([[float(row[column]) for column in columns] for row in rows]))
    models = [
        Kriging.fit(points, [float(row[response]) for row in rows])
        for response in ("bulk_density", "aor")
    ]
    return columns, lambda values: np.column_stack(
        [model.predict(units(values)).mean for model in models]
    )


def heap(seed: int, width: float) -> Case:
    """Case (a): density and rolling friction, intervals of +-width around the nominal values."""
    columns, truth = _emulator("data.csv")
    parameters = [
        Parameter(RECORDED[c][0], (1 - width) * NOMINAL[c], (1 + width) * NOMINAL[c])
        for c in columns
    ]
    return _heap_case(parameters, truth, seed)


def heap_of_four(seed: int) -> Case:
    """Case (b): density, rolling and sliding friction, and Young's modulus."""
    columns, truth = _emulator("data4.csv")
    return _heap_case([_recorded_interval(column) for column in columns], truth, seed)


def _heap_case(parameters: list[Parameter], truth: Truth, seed: int) -> Case:
    targets = [Target(name, 1.0) for name in HEAP_TARGETS]
    case = Case(Problem(parameters, targets), truth, np.array(HEAP_NOISE))
    return _target_the_responses_of(case, seed, {"bulk_density": BULK_DENSITY_TOLERANCE})


def heap_and_rebound(seed: int) -> Case:
    """Case (b) with a third response, of density and Young's modulus alone, that hardly scatters.

    No such test is recorded: a smooth function with the trends of a drop test takes its place.
    """
    columns, recorded = _emulator("data4.csv")
    parameters = [_recorded_interval(column) for column in columns]
    names = [parameter.name for parameter in parameters]
    density, modulus = names.index("particle.density"), names.index("particle.youngs_modulus")

    def truth(values: Array) -> Array:
        rebound = 40 + 12 * np.log10(values[:, modulus] / 1e6) + values[:, density] / 400
        return np.column_stack([recorded(values), rebound])

    targets = [Target(name, 1.0) for name in (*HEAP_TARGETS, "rebound")]
    case = Case(Problem(parameters, targets), truth, np.array([*HEAP_NOISE, 0.1]))
    relative = {"bulk_density": BULK_DENSITY_TOLERANCE, "rebound": ANALYTIC_TOLERANCE}
    return _target_the_responses_of(case, seed, relative)


ANALYTIC_NOISE = 0.02
ANALYTIC_TOLERANCE = 0.02
ANALYTIC_PARAMETERS = (
    Parameter("particle.density", 1000.0, 3000.0),
    Parameter("particle_particle.sliding_friction", 0.1, 0.9),
    Parameter("particle_particle.rolling_friction", 0.02, 0.5),
    Parameter("particle_wall.sliding_friction", 0.1, 0.7),
    Parameter("particle_particle.restitution", 0.2, 0.9),
    Parameter("particle.youngs_modulus", 1e6, 1e8, "log"),
)


def _analytic_responses(values: Array) -> Array:
    """Smooth functions with the trends of real tests: saturating in friction, interacting."""
    density, sliding, rolling, wall, restitution, modulus = values.T
    softness = np.log10(1e8 / modulus)
    packing = (
        0.62
        - 0.07 * (1 - np.exp(-3 * sliding))
        - 0.04 * np.tanh(4 * rolling)
        + 0.012 * softness
        - 0.02 * restitution
    )
    bulk = density * packing
    grip = sliding / (sliding + 0.35)
    angle = 11 + 28 * grip * (0.45 + 0.55 * np.tanh(5 * rolling)) - 2.5 * restitution
    discharge = bulk * (1.4 - 0.45 * np.tanh(2 * sliding) - 0.5 * rolling - 0.25 * wall) / 1000
    drum = 14 + 26 * grip * (0.7 + 0.5 * rolling) + 9 * np.tanh(2 * wall) + 3 * restitution**2
    return np.column_stack([bulk, angle, discharge, drum])


def analytic(seed: int) -> Case:
    """Case (c): six parameters, four responses, 2 % noise."""
    names = ("bulk_density", "angle_of_repose", "discharge_rate", "drum_angle")
    problem = Problem(ANALYTIC_PARAMETERS, [Target(name, 1.0) for name in names])
    case = Case(problem, _analytic_responses, np.zeros(len(names)))
    case = _target_the_responses_of(case, seed, dict.fromkeys(names, ANALYTIC_TOLERANCE))
    return Case(case.problem, case.truth, ANALYTIC_NOISE * case.targets)


def part_of(case: Case, seed: int, share: float) -> Case:
    """A part of a problem: a random share of each interval, with targets from within it."""
    random = np.random.default_rng([seed, 1951])
    parameters = []
    for parameter in case.problem.parameters:
        low = random.uniform(0.0, 1.0 - share)
        bounds = parameter.from_unit(low), parameter.from_unit(low + share)
        parameters.append(Parameter(parameter.name, *bounds, parameter.scale))
    relative = {
        target.name: target.tolerance / target.value
        for target in case.problem.targets
        if target.tolerance != ANGLE_TOLERANCE
    }
    part = Case(Problem(parameters, case.problem.targets), case.truth, case.noise)
    return _target_the_responses_of(part, seed, relative)


#: Cases by name: seed of the targets to case.
CASES: dict[str, Callable[[int], Case]] = {
    "heap, +-33 %": lambda seed: heap(seed, 0.33),
    "heap, +-66 %": lambda seed: heap(seed, 0.66),
    "heap, four parameters": heap_of_four,
    "analytic, six parameters": analytic,
}
