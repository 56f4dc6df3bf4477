"""Search in three steps: Latin hypercube, fit on Kriging metamodels, the same fit on the DEM.

The method of Rackl, Görnig, Hanley & Günthner (ECCOMAS 2016) with one difference: a DEM response is
noisy, so a single run never decides. Every run of step 3 is added to the metamodels, and their
*expected* responses from all runs accept steps, give derivatives and choose the answer. Without
noise this is the method of the paper.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from grainfit.arrays import Array
from grainfit.errors import RunFailedError
from grainfit.evaluation import Evaluation, Proposal, Stage
from grainfit.metamodels.designs import maximin_latin_hypercube
from grainfit.metamodels.metamodels import Metamodels
from grainfit.problem import Problem
from grainfit.strategies import messages
from grainfit.strategies.answer import Answer, make_answer
from grainfit.strategies.batches import Batches, BatchSearch
from grainfit.strategies.budget import design_size
from grainfit.strategies.feasibility import FeasibilityModel
from grainfit.strategies.out_of_reach import out_of_reach
from grainfit.strategies.run_costs import RunCosts
from grainfit.strategies.seeds import insertion_seed
from grainfit.strategies.staged.least_squares import (
    damped_step,
    difference_jacobian,
    difference_points,
    fit_on_metamodels,
)
from grainfit.strategies.staged.options import StagedOptions
from grainfit.strategies.staged.residuals import expected_misfit, expected_misfit_at, residuals_at
from grainfit.verdict.options import VERDICT
from grainfit.verdict.out_of_reach import OutOfReach

#: Runs of the design per free parameter; the paper's study has 26 for two.
DESIGN_RUNS_PER_PARAMETER = 13
#: Most runs of step 3 per free parameter; the paper's study needs 9 to 15 for two.
OPTIMISATION_RUNS_PER_PARAMETER = 10
#: Step 3 ends when a step is shorter than this share of every interval.
SMALL_STEP = 0.01


class StagedSearch(BatchSearch):
    """Search in the three steps of the method.

    Parameters
    ----------
    strategy : StagedOptions
        Size of the design.
    problem : Problem
        Free parameters and targets.
    seed : int
        Decides the design and all insertion seeds.
    max_evaluations : int, optional
        Largest number of proposals.

    Raises
    ------
    InputError
        The design is too small to fit metamodels, or larger than the budget.
    """

    def __init__(
        self,
        strategy: StagedOptions,
        problem: Problem,
        seed: int,
        max_evaluations: int | None = None,
    ) -> None:
        super().__init__(strategy, problem, seed, max_evaluations)
        usual = DESIGN_RUNS_PER_PARAMETER * problem.dimension
        self._design_runs = design_size(
            problem.dimension, strategy.design_runs, usual, max_evaluations
        )
        left = OPTIMISATION_RUNS_PER_PARAMETER * problem.dimension
        if max_evaluations is not None:
            left = max(0, max_evaluations - self._design_runs)
        self._left = left
        self._proposed = 0
        self._resumptions = 0
        self._out_of_reach: tuple[OutOfReach, ...] = ()
        self._fitted: tuple[int, Metamodels] | None = None

    @property
    def definition(self) -> dict[str, Any]:
        """Size of the design, and the budget, which limits the runs of step 3."""
        return {"design_runs": self._design_runs, "max_evaluations": self.max_evaluations}

    @property
    def design_runs(self) -> int:
        """Size of the Latin hypercube."""
        return self._design_runs

    @property
    def limit(self) -> int:
        """The budget, or design and step 3."""
        return self.max_evaluations or self._design_runs + (
            OPTIMISATION_RUNS_PER_PARAMETER * self.problem.dimension
        )

    @property
    def expected_left(self) -> int:
        """Runs of the current batch, and during the design those of a usual step 3."""
        return self._expected_proposals * len(self.problem.scopes)

    @property
    def _expected_proposals(self) -> int:
        if not self._begun:
            return self._design_runs + self.problem.dimension + 2
        open_now = len(self._batch) - len(self._told)
        in_design = bool(self._batch) and self._batch[0].stage == "design"
        return open_now + (min(self._left, self.problem.dimension + 2) if in_design else 0)

    def batches(self) -> Batches:
        """Propose the design, fit on the metamodels, then on the DEM."""
        design = maximin_latin_hypercube(self._design_runs, self.problem.dimension, self.seed)
        yield self._proposals(design, "design")
        yield from self._optimise()

    def resume_after_verification(self, affordable: int | None = None) -> bool:
        """Fit again with the verification runs added, if the budget allows a step."""
        if affordable is not None:
            self._left = min(self._left, affordable)
        possible = (
            not self._out_of_reach
            and self._left > self.problem.dimension
            and self._resumptions < VERDICT.resumptions
        )
        if possible:
            self._resumptions += 1
            self.follow(self._optimise())
        return possible

    def answer(self, parameters: Mapping[str, float] | None = None) -> Answer:
        """Return the simulated parameter set with the smallest expected misfit."""
        metamodels = self._metamodels()
        if parameters is not None:
            return make_answer(metamodels, parameters, self._out_of_reach, costs=self._costs)
        candidates = [dict(e.proposal.parameters) for e in self._successful()]
        if not candidates:
            raise RunFailedError(messages.NO_ANSWER())
        means, variances = metamodels.predict([self.problem.to_unit(p) for p in candidates])
        misfits = [
            expected_misfit(metamodels.problem, *known)
            for known in zip(candidates, means, variances, strict=True)
        ]
        best = candidates[int(np.argmin(misfits))]
        return make_answer(metamodels, best, self._out_of_reach, costs=self._costs)

    @property
    def _costs(self) -> RunCosts:
        return RunCosts(self.problem, self.known)

    def _optimise(self) -> Batches:
        """Carry out steps 2 and 3 with all runs known so far."""
        metamodels = self._metamodels()
        start = fit_on_metamodels(metamodels, self.seed)
        feasibility = FeasibilityModel(self.problem, self.known)
        self._out_of_reach = out_of_reach(metamodels, start, feasibility, self.seed)
        if self._out_of_reach:
            yield from self._runs_at([start])
        else:
            yield from self._fit_on_dem(metamodels, start)

    def _fit_on_dem(self, metamodels: Metamodels, start: Array) -> Batches:
        """Carry out step 3: Levenberg-Marquardt on the expected responses of real runs."""
        point, damping = start, 1e-3
        moved = difference_points(metamodels, point)
        yield from self._runs_at([point, *moved])
        while self._left > 0:
            metamodels = self._metamodels()
            if metamodels.problem.is_met_by(metamodels.predict(point)[0][0]):
                return
            jacobian = difference_jacobian(metamodels, point, moved)
            step = damped_step(jacobian, residuals_at(metamodels, point), damping, point)
            if np.abs(step).max() < SMALL_STEP:
                return
            trial = point + step
            yield from self._runs_at([trial])
            metamodels = self._metamodels()
            if expected_misfit_at(metamodels, trial) < expected_misfit_at(metamodels, point):
                point, damping = trial, damping / 10
                moved = difference_points(metamodels, point)
                if not metamodels.problem.is_met_by(metamodels.predict(point)[0][0]):
                    yield from self._runs_at(list(moved), reserve=1)
            else:
                damping = max(damping, 1e-3) * 10

    def _runs_at(self, points: Iterable[Array], reserve: int = 0) -> Batches:
        """Run at points as far as the budget allows, and leave a part of it unused."""
        affordable = list(points)[: max(0, self._left - reserve)]
        self._left -= len(affordable)
        if affordable:
            yield self._proposals(affordable, "optimisation")

    def _proposals(self, points: Iterable[Array], stage: Stage) -> list[Proposal]:
        return [self._proposal(point, stage) for point in points]

    def _proposal(self, point: Array, stage: Stage) -> Proposal:
        self._proposed += 1
        return Proposal(
            self.problem.from_unit(point), insertion_seed(self.seed, stage, self._proposed), stage
        )

    def _metamodels(self) -> Metamodels:
        known = self.known
        if self._fitted is None or self._fitted[0] != len(known):
            self._fitted = (len(known), Metamodels.fit(self.problem, known))
        return self._fitted[1]

    def _successful(self) -> Iterator[Evaluation]:
        names = set(self.problem.responses)
        return (e for e in self.known if names <= e.response_names)
