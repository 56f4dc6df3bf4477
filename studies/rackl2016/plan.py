"""All tasks of the study in their order."""

from __future__ import annotations

from functools import partial

from grainfit.problem import Parameter
from studies.rackl2016 import peer, recovery
from studies.rackl2016.calibrations import (
    calibrate_with_grainfit,
    calibrate_with_peer,
    expected_responses,
)
from studies.rackl2016.setting import (
    CASES,
    DENSITY,
    DESIGN_RUNS,
    MODULUS,
    MODULUS_INTERVAL,
    MOST_SEARCH_RUNS,
    ROLLING_FRICTION,
    SEEDS,
    TOLERANCES,
    TRUTH_RUNS,
    UNFAVOURABLE_DENSITY,
    UNITS,
    VERIFICATION_RUNS,
    Case,
    around,
    paper_problem,
    problem,
)
from studies.rackl2016.tasks import Context, Record, Task

#: Weights of the Rayleigh criterion that the original tools are run with: the paper's, and none.
WEIGHTS = (1, 0)
#: Name of a method to words for people, in the order of the tables.
METHODS = {
    "staged": "grainfit, staged",
    "sequential": "grainfit, sequential",
    "octave-1": "Octave, Rayleigh weight 1",
    "octave-0": "Octave, Rayleigh weight 0",
}
#: Steps in the order in which they are done.
STEPS = ("staged", "sequential", "octave", "truth", "unfavourable", "modulus", "recovery")
_MODULUS_SEED = 3000


def task_name(method: str, case: Case) -> str:
    """Name of the task of a calibration."""
    return f"{method}-{case.label}"


def truth_of(name: str) -> str:
    """Name of the task that tells the expected responses of another one's answer."""
    return f"{name}-truth"


def all_tasks() -> list[Task]:
    """Every task of the study, each behind those that it needs."""
    calibrations = [
        *(_staged(case) for case in CASES),
        *(_sequential(case) for case in CASES),
        *(_octave(case, weight) for weight in WEIGHTS for case in CASES),
    ]
    truths = [_truth(task.name, "truth") for task in calibrations]
    return [*calibrations, *truths, *_unfavourable(), *_modulus(), *_recovery()]


def _staged(case: Case) -> Task:
    def make(context: Context) -> Record:
        return calibrate_with_grainfit(
            context,
            paper_problem(case.width),
            strategy="staged",
            seed=case.seed,
            design_runs=DESIGN_RUNS,
        )

    about = {"width": case.width, "seed": case.seed, "design": DESIGN_RUNS} | _tolerances()
    return Task(task_name("staged", case), "staged", about, make, runs=40)


def _sequential(case: Case) -> Task:
    def make(context: Context) -> Record:
        return calibrate_with_grainfit(
            context,
            paper_problem(case.width),
            strategy="sequential",
            seed=case.seed,
        )

    about = {"width": case.width, "seed": case.seed} | _tolerances()
    return Task(task_name("sequential", case), "sequential", about, make, runs=28)


def _octave(case: Case, weight: int) -> Task:
    def make(context: Context) -> Record:
        return calibrate_with_peer(
            context,
            paper_problem(case.width),
            seed=case.seed,
            weight=weight,
            design_runs=DESIGN_RUNS,
        )

    about = peer.settings_of(paper_problem(case.width), case.seed, weight, DESIGN_RUNS)
    name = task_name(f"octave-{weight}", case)
    return Task(name, "octave", about, make, runs=36, serial_runs=6)


def _truth(name: str, step: str, runs: int = TRUTH_RUNS, cost: float = 1.0) -> Task:
    def make(context: Context) -> Record:
        parameters = context.records[name]["parameters"]
        return expected_responses(context, parameters, runs, truth_of(name))

    about = {"runs": runs}
    return Task(truth_of(name), step, about, make, runs=round(cost * runs), needs=(name,))


def _unfavourable() -> list[Task]:
    low, high = UNFAVOURABLE_DENSITY

    def make(context: Context, seed: int) -> Record:
        density = Parameter(DENSITY, low, high, unit=UNITS[DENSITY])
        wanted = problem(density, around(ROLLING_FRICTION, 0.33))
        return calibrate_with_grainfit(context, wanted, strategy="sequential", seed=seed)

    return [
        Task(
            f"unfavourable-{seed}",
            "unfavourable",
            {"density": [low, high], "seed": seed} | _tolerances(),
            partial(make, seed=seed),
            runs=14,
        )
        for seed in SEEDS
    ]


def _modulus() -> list[Task]:
    """Young's modulus free as well: the largest time step that agrees with the measurements."""

    def make(context: Context) -> Record:
        modulus = Parameter(MODULUS, *MODULUS_INTERVAL, scale="log", unit=UNITS[MODULUS])
        free = [around(DENSITY, 0.33), around(ROLLING_FRICTION, 0.33), modulus]
        return calibrate_with_grainfit(
            context,
            problem(*free),
            strategy="sequential",
            seed=_MODULUS_SEED,
            verification_runs=VERIFICATION_RUNS,
        )

    about = {"interval": list(MODULUS_INTERVAL), "seed": _MODULUS_SEED} | _tolerances()
    task = Task("modulus", "modulus", about, make, runs=50)
    return [task, _truth(task.name, "modulus", cost=0.7)]


def _recovery() -> list[Task]:
    tasks = []
    for number in range(recovery.SETS):
        about = {"number": number, "measurements": recovery.MEASUREMENTS}
        measured = Task(
            f"measured-{number:02d}",
            "recovery",
            about,
            partial(recovery.measure, number=number),
            runs=recovery.MEASUREMENTS,
        )
        recovered = Task(
            f"recovered-{number:02d}",
            "recovery",
            about | {"search": MOST_SEARCH_RUNS, "verification": recovery.VERIFICATION_RUNS},
            partial(recovery.recover, number=number),
            runs=MOST_SEARCH_RUNS + recovery.VERIFICATION_RUNS,
            needs=(measured.name,),
        )
        tasks += [measured, recovered, _truth(recovered.name, "recovery", recovery.FRESH_RUNS)]
    return tasks


def _tolerances() -> dict[str, dict[str, float]]:
    return {"tolerances": dict(TOLERANCES)}
