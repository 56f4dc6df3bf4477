"""Proposals and evaluations: the messages between a strategy and a campaign."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Literal, TypeAlias

from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import messages
from grainfit.evaluation.names import ALL_RUNS, name_of_test, names_of_tests, response_name
from grainfit.evaluation.response import Curve, Response
from grainfit.one_line import OneLine
from grainfit.relative_names import is_relative

Stage = Literal["design", "optimisation", "verification"]


@dataclass(frozen=True)
class Proposal(OneLine):
    """A parameter set to simulate once, in every test or in some of them.

    Parameters
    ----------
    parameters : mapping of str to float
        Values of the free parameters.
    seed : int
        Insertion seed.
    stage : {"design", "optimisation", "verification"}
        Stage of the calibration.
    tests : tuple of str, optional
        Names of the tests; None for every test, without relatives.
    """

    parameters: Mapping[str, float]
    seed: int
    stage: Stage
    tests: tuple[str, ...] | None = None

    def asks_for(self, test: str) -> bool:
        """Return True if the parameter set is to be simulated in a test, or in a relative."""
        return not is_relative(test) if self.tests is None else test in self.tests


@dataclass(frozen=True)
class Evaluation(OneLine):
    """Outcome of a proposal.

    Parameters
    ----------
    proposal : Proposal
        The parameter set and its seed.
    responses : mapping of str to Response
        Responses of all tests whose run succeeded.
    failures : mapping of str to str
        Reason by name of the test whose run failed.
    reused : int
        Number of runs that were already known, or that another process made.
    runs : mapping of str to str
        Identity of the run by name of the test; with several seeds per evaluation, the further
        runs follow under their `run_name`.
    seconds : float
        Sum of the wall times of the runs, s.
    simulated_seconds : float
        Sum of the wall times of the other runs, s.
    failed_by_machine : bool
        Whether all failures were caused by the machine, not by the simulation: they say nothing
        about the parameters, and the point can be tried again.
    test_seconds : mapping of str to float
        Wall time of the run by name of the test, s; with several seeds, the mean of its runs.
    curves : mapping of str to Curve
        Responses that are curves, of all tests whose run succeeded.
    failed_runs : mapping of str to str
        Reason by name of the run that failed. With several seeds per evaluation, the others may
        have given the responses: then the test is not among the ``failures``.
    made_at : mapping of str to mapping of str to float
        Parameters of the record that the runs of a test have read, by name of the test, where they
        are not those of the proposal.
    """

    proposal: Proposal
    responses: Mapping[str, Response]
    failures: Mapping[str, str] = field(default_factory=dict)
    reused: int = 0
    runs: Mapping[str, str] = field(default_factory=dict)
    seconds: float = 0.0
    simulated_seconds: float = 0.0
    failed_by_machine: bool = False
    test_seconds: Mapping[str, float] = field(default_factory=dict)
    curves: Mapping[str, Curve] = field(default_factory=dict)
    failed_runs: Mapping[str, str] = field(default_factory=dict)
    made_at: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    @property
    def response_names(self) -> set[str]:
        """Names of all responses, curves included."""
        return {*self.responses, *self.curves}

    def failed_in(self, test: str) -> bool:
        """Return True if the run of a test failed, or a run whose test is not known."""
        return self.why_failed(test) is not None

    def why_failed(self, test: str) -> str | None:
        """Return why the run of a test failed, or a run whose test is not known; None if neither.

        The only test of a calibration without several may be called ``""``.
        """
        if not test:
            return next(iter(self.failures.values()), None)
        return self.failures.get(test, None if self.runs else self.failures.get(ALL_RUNS))

    def without(self, tests: Collection[str]) -> Evaluation:
        """Return the evaluation without the runs of some tests, of a calibration with several."""
        prefixes = tuple(response_name(test, "", 2) for test in tests)
        asked = self.proposal.tests or names_of_tests(self.runs)
        left = tuple(test for test in asked if test not in tests)
        return replace(
            self,
            proposal=replace(self.proposal, tests=left),
            responses={n: r for n, r in self.responses.items() if not n.startswith(prefixes)},
            curves={n: c for n, c in self.curves.items() if not n.startswith(prefixes)},
            failures={n: why for n, why in self.failures.items() if n not in tests},
            runs={n: run for n, run in self.runs.items() if name_of_test(n) not in tests},
            test_seconds={n: s for n, s in self.test_seconds.items() if n not in tests},
            failed_runs={
                n: why for n, why in self.failed_runs.items() if name_of_test(n) not in tests
            },
            made_at={n: place for n, place in self.made_at.items() if n not in tests},
        )

    def scaled(self, ratios: Mapping[str, float]) -> Evaluation:
        """Return the evaluation with responses, by name, that are so many times as large."""
        if not ratios:
            return self
        responses = {
            name: Response(
                one.value * ratios.get(name, 1.0), one.standard_error * ratios.get(name, 1.0)
            )
            for name, one in self.responses.items()
        }
        return replace(self, responses=responses)

    def placed(self) -> list[Evaluation]:
        """Return the evaluation where its runs were made: in parts, where these are apart."""
        proposal, tests = self.proposal, names_of_tests(self.runs)
        parts = []
        for test, place in self.made_at.items():
            part = self.without([name for name in tests if name != test]) if tests[1:] else self
            there = replace(part.proposal, parameters={**proposal.parameters, **place})
            parts.append(replace(part, proposal=there, made_at={}))
        if not set(tests).issubset(self.made_at):
            parts.append(self.without(list(self.made_at)))
        return parts if self.made_at else [self]

    @classmethod
    def of(cls, proposal: Proposal, outcome: Outcome) -> Evaluation:
        """Create the evaluation of a proposal from plain responses, or from a failure.

        Parameters
        ----------
        proposal : Proposal
            The parameter set and its seed.
        outcome : mapping of str to float, Response or Curve, RunFailedError, or Evaluation
            Responses by name, the failure, or an evaluation, which is returned unchanged.

        Raises
        ------
        InputError
            The outcome is none of these, belongs to another proposal, or is not finite.
        """
        if isinstance(outcome, Evaluation):
            if outcome.proposal != proposal:
                raise InputError(messages.OTHER_PROPOSAL.fault("outcome"))
            return outcome
        if isinstance(outcome, RunFailedError):
            by_machine = outcome.kind == "machine"
            return cls(proposal, {}, {ALL_RUNS: outcome.reason}, failed_by_machine=by_machine)
        if not isinstance(outcome, Mapping):
            raise InputError(messages.NO_OUTCOME.fault("outcome", given=outcome))
        curves = {name: found for name, found in outcome.items() if isinstance(found, Curve)}
        numbers = {n: _response(n, found) for n, found in outcome.items() if n not in curves}
        return cls(proposal, numbers, curves=curves)


def _response(name: str, value: object) -> Response:
    response = value if isinstance(value, Response) else None
    number = response.value if response else value
    if not isinstance(number, Real) or isinstance(number, bool) or not math.isfinite(number):
        raise InputError(messages.NO_RESPONSE.fault(name, given=number))
    return response or Response(float(number))


#: Outcome of a run: responses by name, the failure, or an evaluation.
Outcome: TypeAlias = Mapping[str, "float | Response | Curve"] | RunFailedError | Evaluation
