"""Simulate the same material at several Young's moduli."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

from grainfit.analysis import messages
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.campaign.batch import ExpectedWork, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.reuse import needed_responses
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import Fault, InputError
from grainfit.evaluation import Evaluation, Proposal
from grainfit.problem import Problem
from grainfit.solvers.base import Solver
from grainfit.validation import number_list_faults, plain_tuple, set_plain, whole_number_faults


@dataclass(frozen=True)
class ModulusPlan:
    """Input of `simulate_moduli`.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    problem : Problem
        Its targets are the responses to compare, with their tolerances.
    parameters : mapping of str to float
        Values of the free parameters, with Young's modulus of the particles.
    factors : sequence of float
        Moduli to simulate, over that of ``parameters``.
    seeds : int
        Runs of each modulus: insertion seeds 1, 2, ...
    workers : int
        Runs at a time.
    timeouts : mapping of str to float
        Longest wall time of a run by name of the test, s; raised for the stiffest particles.

    Raises
    ------
    InputError
        A factor is not above zero, there are fewer than two of them, or a number is below one.
    """

    solvers: Mapping[str, Solver]
    problem: Problem
    parameters: Mapping[str, float]
    factors: Sequence[float]
    seeds: int = 3
    workers: int = 1
    timeouts: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        set_plain(self, "seeds", "workers")
        faults = whole_number_faults({"seeds": self.seeds, "workers": self.workers})
        faults += number_list_faults("factors", plain_tuple(self.factors))
        InputError.raise_for(faults)
        wrong = [f for f in self.factors if not (math.isfinite(f) and f > 0)]
        if wrong:
            faults.append(messages.NO_FACTOR.fault("factors", factor=wrong[0]))
        elif len(set(self.factors)) < 2:
            faults.append(messages.FEW_FACTORS.fault("factors", count=len(set(self.factors))))
        else:
            faults += self._impossible()
        InputError.raise_for(faults)

    def _impossible(self) -> Iterator[Fault]:
        known = MATERIAL_PARAMETERS[MODULUS]
        for factor in (min(self.factors), max(self.factors)):
            value = factor * self.parameters[MODULUS]
            if not known.lowest <= value <= known.highest:
                limits = f"{known.lowest:g} to {known.highest:g} {known.unit}"
                yield messages.MODULUS_OUTSIDE.fault(MODULUS, value=value, limits=limits)

    def at(self, factor: float) -> dict[str, float]:
        """Return the parameters with the modulus of a factor."""
        return {**self.parameters, MODULUS: factor * self.parameters[MODULUS]}

    def proposals(self) -> list[tuple[float, Proposal]]:
        """Return every parameter set to simulate with its factor, soft ones first."""
        return [
            (factor, Proposal(self.at(factor), seed, "design"))
            for factor, seed in product(sorted(set(self.factors)), range(1, self.seeds + 1))
        ]

    def all_timeouts(self) -> dict[str, float]:
        """Return time-outs that are long enough for the stiffest particles."""
        stiffest = self.at(max(self.factors))
        usual = {test: solver.default_timeout(stiffest) for test, solver in self.solvers.items()}
        return {
            test: max(seconds or 0.0, self.timeouts.get(test, 0.0))
            for test, seconds in usual.items()
            if seconds is not None or test in self.timeouts
        }


def simulate_moduli(
    plan: ModulusPlan,
    folder: Path,
    on_start: Callable[[ExpectedWork], None] | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> list[Evaluation]:
    """Simulate a material at several Young's moduli, or find the runs in the store of the folder.

    Parameters
    ----------
    plan : ModulusPlan
        Tests, parameters, moduli and seeds.
    folder : Path
        Work folder that keeps the runs; it may be that of a calibration. After Ctrl-C, another call
        continues.
    on_start : callable, optional
        Called with the expected work before the first run.
    on_progress : callable, optional
        Called with the numbers of finished and of all parameter sets.

    Raises
    ------
    InputError
        A modulus is impossible.
    SolverNotFoundError
        A program is not found.
    StoreError
        The folder cannot be used.
    """
    needed = needed_responses(plan.problem, plan.solvers)
    options = CampaignOptions(plan.workers, plan.all_timeouts(), needed=needed)
    proposals = [proposal for _, proposal in plan.proposals()]
    return simulate_batch(plan.solvers, proposals, folder, options, on_start, on_progress)
