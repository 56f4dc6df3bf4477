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
    doubt_to_stop : float
        Doubt at which a search stops, as a share of the accepted one. A search looks after every
        run and stops when its answer looks good, so it looks better than it is
        (`benchmarks/verdicts.py`).
    verify_from : float
        Smallest probability of an answer at which fresh seeds are worth their runs, for a search
        that does not look at the probability itself: it can go on after them.
    resumptions : int
        How often a verification that does not confirm the answer may lead back to the search.
        Each takes runs, and the first few decide.
    fresh_seeds : int
        Number of fresh seeds at, or very near, the answer, unless the user chooses another one.
        Two could agree by chance.
    most_fresh_seeds : int
        Most further runs at an answer that a close call is worth.
    most_verification : int
        Fresh seeds in each test after which a verdict is given in any case.
    most_planned : int
        Most runs at an answer that are planned at once: as many as can be made in any case.
    near_parameters, near_responses : float
        Largest difference in any parameter, as a share of its interval, and in any expected
        response, in tolerances, of a parameter set that counts as very near the answer. Within
        them, the metamodels carry a response over with a negligible error.
    quiet, fewest_of_quiet : float, int
        Scatter of a response, in tolerances, up to which one of several tests needs only so many
        fresh seeds: two runs then agree by chance with the same error once in 10,000 times.
    contradiction : float
        Standard errors between fresh seeds and all runs that contradict each other. By chance it
        happens in 3 of 1,000 checks.
    negligible : float
        Deviation, in tolerances, that contradicts nothing: without scatter, any is significant.
    own_variance : float
        Smallest variance of the difference between fresh seeds and all runs, as a share of that
        of the fresh mean: an expectation that rests on little else than the fresh seeds cannot
        contradict them.
    useless_scatter : float
        Scatter of single runs, in tolerances, from which one run says nothing: the mean of nine
        has a standard error as large as the tolerance.
    """

    confidence: float = 0.95
    doubt_to_stop: float = 0.5
    verify_from: float = 0.05
    resumptions: int = 8
    fresh_seeds: int = 3
    most_fresh_seeds: int = 20
    most_verification: int = 24
    most_planned: int = 24
    near_parameters: float = 0.1
    near_responses: float = 0.5
    quiet: float = 0.25
    fewest_of_quiet: int = 2
    contradiction: float = 3.0
    negligible: float = 0.01
    own_variance: float = 0.1
    useless_scatter: float = 3.0


VERDICT = VerdictOptions()
