"""Responses that a valid run may lack, until a calibration needs them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from grainfit.campaign.store.records import RequestRecord, RunRecord
from grainfit.evaluation import Evaluation, name_of_test, names_of_tests, response_name

if TYPE_CHECKING:
    from grainfit.solvers.base import Solver


def why_absent(absent: Mapping[str, str], found: Collection[str]) -> str:
    """Return which responses a valid run is without, and why; "" if it has all.

    Parameters
    ----------
    absent : mapping of str to str
        Those that it may be without, with the reason.
    found : collection of str
        Those that it has.
    """
    by_reason: dict[str, list[str]] = {}
    for name, reason in absent.items():
        if name not in found:
            by_reason.setdefault(reason, []).append(name)
    return "; ".join(f"no {', '.join(names)}: {why}" for why, names in by_reason.items())


def absences(solvers: Mapping[str, Solver], evaluations: Iterable[Evaluation]) -> list[str]:
    """Return which responses the runs of some evaluations are without, and why.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    evaluations : iterable of Evaluation
        Those of failed runs have no responses at all, and their own reason.
    """
    lines = []
    for evaluation in evaluations:
        for test, solver in solvers.items():
            absent = {response_name(test, n, len(solvers)): r for n, r in solver.absent.items()}
            if test not in evaluation.failures and (
                why := why_absent(absent, evaluation.response_names)
            ):
                lines.append(f"Seed {evaluation.proposal.seed}: {test} has {why}.")
    return lines


def with_needed(record: RunRecord, needed: Collection[str]) -> RunRecord:
    """Return a run, as a failed one if it lacks a needed response and has the reason."""
    has_all = record.responses.keys() >= set(needed)
    if record.status != "finished" or not record.reason or has_all:
        return record
    return replace(record, status="failed", responses={}, kind="evaluation")


def failed_if_incomplete(
    records: Mapping[str, RunRecord],
    requests: Iterable[RequestRecord],
    definition: Mapping[str, Any],
) -> dict[str, RunRecord]:
    """Return runs, those that lack a response that their calibration needs as failed ones.

    Parameters
    ----------
    records : mapping of str to RunRecord
        Runs by identity.
    requests : iterable of RequestRecord
        The parameter sets of the calibration.
    definition : mapping
        Of the calibration.
    """
    found = dict(records)
    if not any(record.reason for record in records.values()):
        return found
    tests = len(names_of_tests(definition["tests"]))
    names = [one["name"] for key in ("targets", "curves") for one in definition.get(key, [])]
    for request in requests:
        for run, identity in request.runs.items():
            if identity in records:
                prefix = response_name(name_of_test(run), "", tests)
                needed = [n.removeprefix(prefix) for n in names if n.startswith(prefix)]
                found[identity] = with_needed(records[identity], needed)
    return found
