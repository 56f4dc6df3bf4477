"""What a strategy asks for and what it is told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Stage = Literal["design", "optimisation", "verification"]


@dataclass(frozen=True)
class Proposal:
    """A parameter set that a strategy wants simulated once, in every test.

    Parameters
    ----------
    parameters : mapping of str to float
        Values of the free parameters.
    seed : int
        Insertion seed.
    stage : {"design", "optimisation", "verification"}
        What it is for.
    """

    parameters: Mapping[str, float]
    seed: int
    stage: Stage


@dataclass(frozen=True)
class Evaluation:
    """What came of a proposal.

    Parameters
    ----------
    proposal : Proposal
        What was asked for.
    responses : mapping of str to Response
        Responses of all tests whose run ended well.
    failures : mapping of str to str
        Reason by name of the test whose run failed.
    reused : int
        How many of its runs were known already.
    runs : mapping of str to str
        Identity of the run by name of the test.
    seconds : float
        Sum of the wall times of the runs, s.
    simulated_seconds : float
        The same of the runs that were not known already, s.
    failed_by_machine : bool
        Whether every failure was a fault of the machine, not of the simulation: it tells nothing
        of the parameters, and the point is worth another try.
    """

    proposal: Proposal
    responses: Mapping[str, Response]
    failures: Mapping[str, str] = field(default_factory=dict)
    reused: int = 0
    runs: Mapping[str, str] = field(default_factory=dict)
    seconds: float = 0.0
    simulated_seconds: float = 0.0
    failed_by_machine: bool = False


@dataclass(frozen=True)
class Response:
    """One measured quantity of one run.

    Parameters
    ----------
    value : float
        In SI units, except angles, which are in degrees.
    standard_error : float
        Standard error of this run's value, 0 if it is not known. The metamodels estimate from the
        runs how much they scatter; what is stated tells them which runs scatter more than others
        (a short average, a small heap), where the runs bear it out.
    """

    value: float
    standard_error: float = 0.0


def response_name(test: str, name: str, tests: int) -> str:
    """Name of a test's response in a calibration with this number of tests."""
    return name if tests == 1 else f"{test}.{name}"
