"""Smaller apparatus that are simulated instead of the laboratory's: twins, and their ratios."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from grainfit.problem import Problem, Target
from grainfit.result import ResponseResult, Result
from grainfit.student import NORMAL_QUANTILE
from grainfit.verdict.reasons import FullSizeMade, FullSizePending, RealTest, Reason
from grainfit.verdict.rule import probability_within, status_by, verdict_by


@dataclass(frozen=True)
class SizeRatio:
    """Response of the laboratory's apparatus over that of its twin.

    Parameters
    ----------
    value : float
        The ratio.
    standard_error : float
        Standard error of the laboratory's response that follows from it, in its unit.
    """

    value: float
    standard_error: float = 0.0


@dataclass(frozen=True)
class Twins:
    """Twins of the laboratory's apparatus.

    Parameters
    ----------
    ratios : mapping of str to SizeRatio
        By name of the target; targets of tests that are simulated as they are have none.
    tests : tuple of RealTest
        The tests that have a twin.
    are_measured : bool
        Whether a series of sizes gave the ratios.
    first_search : str
        Identity of the calibration with the first ratios; empty for that one.
    """

    ratios: Mapping[str, SizeRatio]
    tests: tuple[RealTest, ...]
    are_measured: bool = False
    first_search: str = ""

    def problem(self, problem: Problem) -> Problem:
        """Return the problem whose evaluations are multiplied by the ratios.

        The errors of the ratios are a part of the uncertainties of the targets, and until the
        ratios are measured of the tolerances, too: a search need not be finer than they are.
        """
        targets = [self._target(one) for one in problem.targets]
        ratios = {name: ratio.value for name, ratio in self.ratios.items()}
        return replace(problem, targets=targets, ratios=ratios)

    def _target(self, target: Target) -> Target:
        ratio = self.ratios.get(target.name)
        if ratio is None:
            return target
        error = ratio.standard_error
        uncertainty = math.hypot(target.standard_uncertainty, error)
        tolerance = target.tolerance if self.are_measured else math.hypot(target.tolerance, error)
        return replace(target, uncertainty=uncertainty, tolerance=tolerance)

    def predicted(self, result: Result, confidence: float) -> Result:
        """Return a result of twins as a prediction for the laboratory's apparatus.

        Parameters
        ----------
        result : Result
            Of the problem with the ratios.
        confidence : float
            Demanded probability that every target is met.
        """
        responses = {
            name: _expected(
                found,
                found.predicted,
                math.hypot(found.standard_error, self.ratios[name].standard_error),
                confidence,
            )
            if name in self.ratios
            else found
            for name, found in result.responses.items()
        }
        pending = FullSizePending(self.tests, self.are_measured)
        misses = tuple(
            replace(one, ratio_error=self.ratios[one.target].standard_error)
            if one.target in self.ratios
            else one
            for one in result.out_of_reach
        )
        result = replace(result, out_of_reach=misses)
        return _with(result, responses, (*result.reasons, pending))

    def at_full_size(
        self, result: Result, confidence: float, made: Iterable[FullSizeMade]
    ) -> Result:
        """Return a prediction with what a run at full size gave, and the verdict.

        What agrees with the prediction is weighed by its error; else the run counts alone.

        Parameters
        ----------
        result : Result
            A prediction.
        confidence : float
            Demanded probability that every target is met.
        made : iterable of FullSizeMade
            By target, the run at this answer.
        """
        responses, made = dict(result.responses), tuple(made)
        for one in made:
            expected, error = combined(one)
            found = _expected(responses[one.target], expected, error, confidence)
            responses[one.target] = found
        kept = tuple(one for one in result.reasons if not isinstance(one, FullSizePending))
        every = math.prod(found.probability or 0.0 for found in responses.values())
        is_off = any(found.is_off for found in responses.values())
        status = status_by(every, confidence, is_off=is_off)
        return _with(replace(result, status=status), responses, (*made, *kept))


def combined(made: FullSizeMade) -> tuple[float, float]:
    """Return the response that is expected at full size, and its standard error."""
    own, other = made.half_width / NORMAL_QUANTILE, made.predicted_half_width / NORMAL_QUANTILE
    if not made.agrees or other <= 0:
        return made.found, own
    share = other**2 / (own**2 + other**2)
    return share * made.found + (1 - share) * made.predicted, own * math.sqrt(share)


def _expected(
    found: ResponseResult, expected: float, error: float, confidence: float
) -> ResponseResult:
    probability = probability_within(expected, error, found.target, found.tolerance)
    deviation = None
    if found.deviation_percent is not None:
        deviation = 100 * (expected - found.target) / abs(found.target)
    found = replace(found, predicted=expected, standard_error=error)
    return replace(
        found,
        deviation_percent=deviation,
        probability=probability,
        verdict=verdict_by(probability, confidence, is_off=found.is_off),
        # Fresh seeds of a twin verify nothing of the laboratory's apparatus.
        verified_mean=None,
        verified_standard_error=None,
        verified_interval=None,
        verified_values=(),
        verified_seeds=(),
        jams_not_excluded=None,
    )


def _with(
    result: Result, responses: Mapping[str, ResponseResult], reasons: tuple[Reason, ...]
) -> Result:
    known = [found.probability for found in responses.values() if found.probability is not None]
    every = math.prod(known) if known and result.probability_all_met is not None else None
    return replace(result, responses=responses, reasons=reasons, probability_all_met=every)
