"""Thresholds of the verdict, all in one place; only strategies let the user choose two of them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class VerdictOptions:
    """Thresholds of the verdict on an answer, each with its reason.

    Parameters
    ----------
    confidence : float
        Demanded probability that every target is met: the usual level of confidence. The default
        of the strategies, which let the user choose it.
    verify_from : float
        Smallest probability of an answer at which fresh seeds are worth their runs, for a search
        that does not look at the probability itself: it can go on after them.
    resumptions : int
        How often a verification that does not confirm the answer may lead back to the search.
        Each takes runs, and the first few decide.
    fresh_seeds : int
        Number of fresh seeds at the answer, unless the user chooses another one.
        Two could agree by chance.
    most_verification : int
        Runs in each test beyond the usual ones of the search after which a verdict is given in any
        case.
    most_planned : int
        Most runs at an answer that are planned at once: as many as can be made in any case.
    edge, beyond_edge : float
        Expected deviation, in tolerances, from which an answer lies on the edge of a tolerance, and
        beyond it: the runs that would decide it grow with the inverse square of the distance.
    known_edge : float
        Largest standard error of that deviation, in tolerances, with which more runs would hardly
        change it.
    enough_at_edge : int
        Runs after the design with which a search ends whose best is on an edge.
    quiet, fewest_of_quiet : float, int
        Scatter of a response, in tolerances, up to which one of several tests needs only so many
        fresh seeds: two runs then agree by chance with the same error once in 10,000 times.
    contradiction : float
        Standard errors between fresh seeds and the other runs that contradict each other. By
        chance it happens in 3 of 1,000 checks.
    excluded : float
        Error with which the fresh seeds alone, by the scatter of runs that differ in their seed
        only, may exclude that a target is met.
    negligible : float
        Deviation, in tolerances, that contradicts nothing: without scatter, any is significant.
    useless_scatter : float
        Scatter of single runs, in tolerances, from which one run says nothing: the mean of nine
        has a standard error as large as the tolerance.
    """

    confidence: float = 0.95
    verify_from: float = 0.05
    resumptions: int = 8
    fresh_seeds: int = 3
    most_verification: int = 24
    most_planned: int = 24
    edge: float = 0.9
    beyond_edge: float = 1.1
    known_edge: float = 0.25
    enough_at_edge: int = 15
    quiet: float = 0.25
    fewest_of_quiet: int = 2
    contradiction: float = 3.0
    excluded: float = 0.01
    negligible: float = 0.01
    useless_scatter: float = 3.0


VERDICT = VerdictOptions()


@dataclass(frozen=True)
class HoldoutOptions:
    """Thresholds and numbers of runs of a hold-out, each with its reason.

    Parameters
    ----------
    answer_seeds : int
        Runs at the answer: two could agree by chance.
    posterior_draws : int
        Runs at parameter sets drawn from the posterior. Beside the others they place the response
        over the posterior to a fraction of its spread (`benchmarks/holdouts.py`).
    prior_draws : int
        Runs spread over the intervals of the parameters, for the spread before the calibration.
    confidence : float
        Probability of the interval of a measurement: the usual level.
    narrow : float
        Largest width of that interval, over that of the interval before the calibration: a wider
        one would hold many materials.
    """

    answer_seeds: int = 3
    posterior_draws: int = 8
    prior_draws: int = 8
    confidence: float = 0.95
    narrow: float = 0.5

    @property
    def sets(self) -> int:
        """Number of simulated parameter sets, the answer once for each of its seeds."""
        return self.answer_seeds + self.posterior_draws + self.prior_draws


HOLDOUT = HoldoutOptions()
