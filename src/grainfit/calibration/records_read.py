"""Find which fresh seeds are evidence: rows of a table, and outputs, count once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from grainfit.calibration import messages
from grainfit.calibration.deterministic import DeterministicTests
from grainfit.calibration.repetitions import Repetitions
from grainfit.campaign.repeats import seeds_of
from grainfit.evaluation import Evaluation, Proposal, response_name
from grainfit.formatting import counted, value_with_unit
from grainfit.problem import Problem
from grainfit.solvers.base import Solver, SourceRecord
from grainfit.verdict.reasons import NoRecordThere


@dataclass(frozen=True)
class RecordsRead:
    """Records that the runs of a calibration read, and outputs that they repeat, by test.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    repeats : mapping of str to int
        Runs with different seeds whose mean is one evaluation, by name of the test.
    folder : Path, optional
        The work folder, which may have the raw output of the runs.
    """

    solvers: Mapping[str, Solver]
    repeats: Mapping[str, int]
    folder: Path | None = None

    @cached_property
    def _tests(self) -> DeterministicTests:
        return DeterministicTests(self.solvers, self.folder)

    def repetitions(
        self, search: Sequence[Evaluation], verification: Sequence[Evaluation]
    ) -> Repetitions:
        """Return the runs with fresh seeds that are no evidence of their own.

        Equal responses are no sign of it: independent runs may give zero, or quantised values.

        Parameters
        ----------
        search, verification : sequence of Evaluation
            Runs of the search, a warm start included, and runs with fresh seeds.
        """
        deterministic = self._tests.among([*search, *verification])
        found = self._read_again(search, verification)
        seen: set[tuple[object, ...]] = set()
        for evaluation in verification:
            for test in filter(evaluation.proposal.asks_for, deterministic):
                names = self._responses(test, evaluation)
                place = (test, *evaluation.proposal.parameters.values())
                if place in seen:
                    found.setdefault(evaluation.proposal.seed, set()).update(names)
                elif names:
                    seen.add(place)
        if len(deterministic) == len(self.solvers):
            deterministic = ("", *deterministic)
        return Repetitions({seed: tuple(found[seed]) for seed in found}, deterministic)

    def _read_again(
        self, search: Sequence[Evaluation], verification: Sequence[Evaluation]
    ) -> dict[int, set[str]]:
        """Return the responses of records that were read before, or that belong elsewhere."""
        read = {
            (test, record.name)
            for evaluation in search
            for test, records in self._of(evaluation.proposal)
            for record in records
        }
        found: dict[int, set[str]] = {}
        for evaluation in verification:
            for test, records in self._of(evaluation.proposal):
                names = {(test, record.name) for record in records}
                is_new = names.isdisjoint(read) and len(names) == len(records)
                if not (is_new and all(record.is_at_parameters for record in records)):
                    found.setdefault(evaluation.proposal.seed, set()).update(
                        self._responses(test, evaluation)
                    )
                read |= names
        return found

    def read_again(self, evaluations: Sequence[Evaluation]) -> list[str]:
        """Return a sentence on each test whose runs have read fewer records than there are runs."""
        read: dict[str, list[str]] = {}
        for evaluation in evaluations:
            for test, records in self._of(evaluation.proposal):
                read.setdefault(test, []).extend(record.name for record in records)
        return [
            messages.ROWS_READ_AGAIN(
                runs=len(names),
                of_test=f" of {test}" if len(self.solvers) > 1 else "",
                rows=counted(len(set(names)), "row"),
            )
            for test, names in read.items()
            if len(set(names)) < len(names)
        ]

    def missing_at(self, parameters: Mapping[str, float], problem: Problem) -> list[NoRecordThere]:
        """Return the tests that have no record at some parameters, with the nearest one."""
        units = {parameter.name: parameter.unit for parameter in problem.parameters}
        return [
            NoRecordThere(
                test if len(self.solvers) > 1 else "", record.name, _in_words(record, units)
            )
            for test, records in self._of(Proposal(parameters, 1, "verification"))
            for record in records[:1]
            if not record.is_at_parameters
        ]

    def _of(self, proposal: Proposal) -> Iterator[tuple[str, list[SourceRecord]]]:
        """Yield the records of the runs of a proposal, for tests that read any."""
        for test, solver in self.solvers.items():
            if proposal.asks_for(test):
                seeds = seeds_of(proposal.seed, self.repeats[test])
                records = [solver.record_of(proposal.parameters, seed) for seed in seeds]
                if any(records):
                    yield test, [record for record in records if record]

    def _responses(self, test: str, evaluation: Evaluation) -> set[str]:
        """Return the responses of a test, components of curves included."""
        prefix = response_name(test, "", len(self.solvers))
        names = {*evaluation.responses, *evaluation.curves}
        return {name for name in names if name.startswith(prefix)}


def _in_words(record: SourceRecord, units: Mapping[str, str]) -> str:
    shown = {
        name: value_with_unit(value, units.get(name, ""))
        for name, value in record.parameters.items()
    }
    return ", ".join(f"{name} = {value}" for name, value in shown.items())
