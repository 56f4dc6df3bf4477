"""Calibrations of all kinds in work folders, for tests of reports.

All come from `grainfit.calibrate` or from its `CalibrationLoop`, with a Python function that
scatters as real runs do; the same seeds give the same runs.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

import grainfit as gf
from grainfit.calibration.calibrate import Simulate
from grainfit.calibration.loop import CalibrationLoop, LoopOptions
from grainfit.calibration.provenance import Provenance
from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import RESULT_NAME
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.evaluation import Proposal, Stage
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.strategies.answer import Answer
from grainfit.strategies.batches import Batches, BatchSearch
from grainfit.strategies.seeds import insertion_seed

Points = NDArray[np.float64]

_INTERVALS: Mapping[str, tuple[float, float]] = {
    "density": (1400.0, 2800.0),
    "youngs_modulus": (1e5, 1e8),
    "poissons_ratio": (0.15, 0.4),
    "sliding_friction": (0.1, 0.9),
    "rolling_friction": (0.05, 0.75),
    "restitution": (0.2, 0.9),
    "rolling_damping": (0.0, 0.5),
}
_GLASS = {
    "particle.density": 2500.0,
    "particle.youngs_modulus": 3.6e5,
    "particle.poissons_ratio": 0.22,
}
_HEAP = (
    gf.Target("bulk_density", 1500.0, uncertainty=15.0, unit="kg/m^3"),
    gf.Target("angle_of_repose", 22.0, uncertainty=0.5, unit="deg"),
)
_TWO = ("particle.density", "particle_particle.rolling_friction")
_FIVE = (
    "particle.youngs_modulus",
    "particle.density",
    "particle_particle.sliding_friction",
    "particle_particle.rolling_friction",
    "particle_wall.sliding_friction",
)
#: Texts that a page would execute or show as something else if they were not escaped.
NASTY_CALIBRATION = "Müllers \"Perlen\" & 'Kugeln' </script><script>window.executed = 1</script>"
NASTY_PARAMETERS = (
    "<script>alert(1)</script>",
    "\"quotes\" & 'apostrophes'",
    "=1+1",
    "{{ 7*7 }} Größe &lt;",
)
NASTY_RESPONSES = (
    '</script><img src=x onerror="window.executed = 1">',
    "<b>x</b> Schüttwinkel &lt;",
    "javascript:window.executed=1",
)
NASTY_UNIT = "<i>kg</i>"
NASTY_REASON = '<b>x</b></script><img src=x onerror="window.executed = 1"> "\' {{ 7*7 }} &lt;'
NASTY_FILE = '<b>file</b>".toml'
NASTY_TEXT = "name = '</script><script>window.executed = 1</script> <!-- {{ 7*7 }} &lt;'\n"


class Model:
    """A smooth model that meets its targets at one parameter set, with the scatter of real runs.

    Every response depends on all parameters, mostly on one of them.

    Parameters
    ----------
    problem : Problem
        Its parameters and its targets.
    excess : float
        Relative excess of all responses over the targets at that parameter set.
    scatter : float
        Standard deviation of all responses from seed to seed, in tolerances.
    """

    def __init__(self, problem: gf.Problem, excess: float = 0.0, scatter: float = 0.4) -> None:
        self.problem = problem
        self.excess = excess
        self.scatter = scatter
        self.truth = np.linspace(0.4, 0.65, problem.dimension)

    def __call__(self, parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        random = np.random.default_rng(seed)
        off = self.problem.to_unit(parameters) - self.truth
        responses = {}
        for number, target in enumerate(self.problem.targets):
            distance = (np.arange(self.problem.dimension) - number) % self.problem.dimension
            change = float(off @ (1.0 + distance) ** -2.0)
            expected = target.value * (1 + self.excess + 0.35 * change + 0.1 * change**2)
            scatter = self.scatter * target.tolerance * random.standard_normal()
            responses[target.name] = expected + scatter
        return responses


def problem(names: Sequence[str], targets: Sequence[gf.Target] = _HEAP) -> gf.Problem:
    """Return a problem of the material parameters of these names, with its Rayleigh time step."""
    return gf.Problem([_parameter(name) for name in names], targets, _rayleigh(names))


def _parameter(name: str) -> gf.Parameter:
    key = name.rpartition(".")[2]
    low, high = _INTERVALS[key]
    scale = "log" if key == "youngs_modulus" else "linear"
    return gf.Parameter(name, low, high, scale, MATERIAL_PARAMETERS[name].unit)


def _rayleigh(names: Sequence[str]) -> gf.RayleighTimeStep:
    fixed = {name: value for name, value in _GLASS.items() if name not in names}
    return gf.RayleighTimeStep(0.005, fixed)


def one_parameter(folder: Path) -> None:
    """Calibrate one parameter with one response, without a time step."""
    wanted = gf.Problem([_parameter("particle_particle.rolling_friction")], _HEAP[1:])
    gf.calibrate(wanted, Model(wanted), workdir=folder, name="one parameter")


def two_parameters(folder: Path) -> None:
    """Calibrate two parameters with two responses, as from a file."""
    wanted = problem(_TWO)
    provenance = Provenance(
        "beads.toml", 'name = "glass beads"\n', {"particle_wall.sliding_friction": 0.3}
    )
    gf.calibrate(
        wanted, Model(wanted), workdir=folder, name="glass beads", workers=2, provenance=provenance
    )


def five_parameters(folder: Path) -> None:
    """Calibrate five parameters with two tests of three responses; one test fails at times."""
    six = [
        gf.Target("heap.bulk_density", 1500.0, uncertainty=15.0, unit="kg/m^3"),
        gf.Target("heap.angle_of_repose", 22.0, uncertainty=0.5, unit="deg"),
        gf.Target("heap.discharge_time", 6.2, tolerance=0.3, unit="s"),
        gf.Target("drum.dynamic_angle", 34.0, tolerance=0.8, unit="deg"),
        gf.Target("drum.torque", 0.012, tolerance=0.0005, unit="N m"),
        gf.Target("drum.power", 0.25, weight=0.5, unit="W"),
    ]
    wanted = problem(_FIVE, six)
    model = Model(wanted)
    tests = {
        "heap": PythonCallable(_part_of(model, "heap"), identity="heap"),
        "drum": PythonCallable(_part_of(model, "drum"), identity="drum"),
    }
    _staged(wanted, tests, folder, "five parameters", design_runs=18, max_runs=64)


def _part_of(model: Model, test: str) -> Callable[[dict[str, float], int], dict[str, float]]:
    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        if test == "drum" and parameters["particle_wall.sliding_friction"] > 0.85:
            raise gf.RunFailedError("the drum was overfilled")
        found = model(parameters, seed)
        return {n.removeprefix(f"{test}."): v for n, v in found.items() if n.startswith(test)}

    return simulate


def fourteen_parameters(folder: Path) -> None:
    """Calibrate all parameters that dry spheres and their wall need."""
    needed = (name for name, known in MATERIAL_PARAMETERS.items() if known.default is None)
    wanted = problem(tuple(needed))
    _staged(wanted, Model(wanted), folder, "fourteen parameters", design_runs=20, max_runs=42)


def _staged(
    wanted: gf.Problem, simulate: Simulate, folder: Path, name: str, design_runs: int, max_runs: int
) -> None:
    strategy = gf.Staged(design_runs=design_runs)
    gf.calibrate(wanted, simulate, strategy=strategy, workdir=folder, name=name, max_runs=max_runs)


def no_run_finished(folder: Path) -> None:
    """Stop a calibration by Ctrl-C during the first run."""
    _ended_at(folder, 1)


def interrupted(folder: Path) -> None:
    """Stop a calibration by Ctrl-C after enough runs for metamodels."""
    _ended_at(folder, 12)


def _ended_at(folder: Path, last: int) -> None:
    wanted = problem(_TWO)
    model, made = Model(wanted), 0

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal made
        made += 1
        if made == last:
            raise KeyboardInterrupt
        return model(parameters, seed)

    gf.calibrate(wanted, simulate, workdir=folder, name="interrupted")


def all_failed(folder: Path) -> None:
    """Let a calibration end because no run gave a response."""

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        raise gf.RunFailedError("no licence")

    with suppress(gf.RunFailedError):
        gf.calibrate(problem(_TWO), simulate, workdir=folder, name="all failed")


def only_failures_yet(folder: Path) -> None:
    """Stop a calibration by Ctrl-C after two runs that failed."""
    made = 0

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal made
        made += 1
        if made == 3:
            raise KeyboardInterrupt
        raise gf.RunFailedError("particles were lost")

    gf.calibrate(problem(_TWO), simulate, workdir=folder, name="only failures yet")


def unreachable(folder: Path) -> None:
    """Calibrate with targets that the intervals do not allow."""
    wanted = problem(_TWO)
    gf.calibrate(wanted, Model(wanted, excess=0.8), workdir=folder, name="unreachable")


def undecided(folder: Path) -> None:
    """Calibrate with responses that scatter too much for so few runs."""
    wanted = problem(_TWO)
    noisy = Model(wanted, scatter=4.0)
    gf.calibrate(wanted, noisy, workdir=folder, name="undecided", max_runs=20)


def nasty_names(folder: Path) -> None:
    """Calibrate with names, units and reasons that must be escaped."""
    wanted = gf.Problem(
        [gf.Parameter(name, 1.0, 2.0, unit=NASTY_UNIT) for name in NASTY_PARAMETERS],
        [gf.Target(name, 10.0, tolerance=0.4, unit=NASTY_UNIT) for name in NASTY_RESPONSES],
    )
    model = Model(wanted)

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        if parameters[NASTY_PARAMETERS[0]] > 1.8:
            raise gf.RunFailedError(NASTY_REASON, NASTY_REASON)
        return model(parameters, seed)

    provenance = Provenance(NASTY_FILE, NASTY_TEXT)
    gf.calibrate(
        wanted, simulate, workdir=folder, name=NASTY_CALIBRATION, provenance=provenance, max_runs=40
    )


@contextmanager
def _running_half_way(folder: Path) -> Iterator[None]:
    """Calibrate until the end of the block, with nine runs finished and one under way."""
    wanted = problem(_TWO)
    model, made = Model(wanted), 0
    under_way, end = threading.Event(), threading.Event()

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        nonlocal made
        made += 1
        if made > 9:
            under_way.set()
            end.wait()
            raise KeyboardInterrupt
        return model(parameters, seed)

    def calibrate() -> None:
        gf.calibrate(wanted, simulate, workdir=folder, name="running half-way")

    thread = threading.Thread(target=calibrate)
    thread.start()
    try:
        assert under_way.wait(60)
        yield
    finally:
        end.set()
        thread.join()


class _Decided(BatchSearch):
    """A search with given proposals and a given answer: many runs without many metamodels."""

    def __init__(
        self, problem: gf.Problem, batches: Mapping[Stage, Points], answer: Points
    ) -> None:
        super().__init__(gf.Sequential(), problem, seed=1)
        self._given = batches
        self._answer = answer

    @property
    def design_runs(self) -> int:
        return len(self._given["design"])

    @property
    def expected_left(self) -> int:
        return 0

    @property
    def notices(self) -> Sequence[str]:
        return ()

    @property
    def definition(self) -> dict[str, Any]:
        return {"design_runs": self.design_runs}

    def batches(self) -> Batches:
        for stage, points in self._given.items():
            yield [
                Proposal(
                    self.problem.from_unit(at), insertion_seed(self.seed, stage, number), stage
                )
                for number, at in enumerate(points)
            ]

    def answer(self, parameters: Mapping[str, float] | None = None) -> Answer:
        targets = self.problem.targets
        return Answer(
            parameters=self.problem.from_unit(self._answer),
            predicted={target.name: target.value for target in targets},
            standard_errors={target.name: 0.1 * target.tolerance for target in targets},
            probability_all_met=0.99,
            probabilities={target.name: 0.995 for target in targets},
        )

    def resume_after_verification(self, affordable: int | None = None) -> bool:
        return False


def many_runs(folder: Path, runs: int = 500) -> None:
    """Calibrate five parameters with so many runs: design, search near the answer, verification."""
    wanted = problem(_FIVE)
    model = Model(wanted)
    scatter = np.random.default_rng(1).normal(0, 0.05, (runs // 10, wanted.dimension))
    verification = 5
    left = runs - len(scatter) - verification
    batches: dict[Stage, Points] = {
        "design": qmc.LatinHypercube(wanted.dimension, rng=1).random(left),
        "optimisation": np.clip(model.truth + scatter, 0, 1),
    }
    solvers = {"simulate": PythonCallable(model)}
    options = LoopOptions("many runs", 1, None, verification)
    with hold(folder), closing(RunStore.in_folder(folder)) as store:
        strategy = _Decided(wanted, batches, model.truth)
        with closing(Campaign(solvers, store, folder, CampaignOptions())) as campaign:
            result = CalibrationLoop(wanted, strategy, campaign, store, options).run()
        result.to_json(folder / RESULT_NAME)


_MAKERS: Mapping[str, Callable[[Path], None]] = {
    maker.__name__: maker
    for maker in (
        one_parameter,
        two_parameters,
        five_parameters,
        fourteen_parameters,
        no_run_finished,
        interrupted,
        all_failed,
        only_failures_yet,
        unreachable,
        undecided,
        nasty_names,
        many_runs,
    )
}
#: Names of all calibrations.
CAMPAIGNS = (*_MAKERS, "running_half_way")


@contextmanager
def campaign(name: str, folder: Path) -> Iterator[Path]:
    """Make a calibration in a folder; the running one runs until the end of the block."""
    if name == "running_half_way":
        with _running_half_way(folder):
            yield folder
    else:
        _MAKERS[name](folder)
        yield folder
