"""Find which fresh seeds are evidence where runs read records, such as the rows of a table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from grainfit.campaign.repeats import seeds_of
from grainfit.evaluation import Evaluation, Proposal, response_name
from grainfit.formatting import unit_for_people, with_unit
from grainfit.problem import Problem
from grainfit.solvers.base import Solver, SourceRecord
from grainfit.verdict.reasons import NoRecordThere


@dataclass(frozen=True)
class RecordsRead:
    """Records that the runs of a calibration read, by test.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    repeats : mapping of str to int
        Runs with different seeds whose mean is one evaluation, by name of the test.
    """

    solvers: Mapping[str, Solver]
    repeats: Mapping[str, int]

    def stale(
        self, search: Iterable[Evaluation], verification: Iterable[Evaluation]
    ) -> dict[int, set[str]]:
        """Return the responses that verify nothing, by the seed of their proposal.

        Their run has read a record that an earlier run has read, or that belongs elsewhere. Equal
        responses are no sign of it: independent runs may give zero, or quantised values.
        """
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
        return {name for name in evaluation.responses if name.startswith(prefix)}


def _in_words(record: SourceRecord, units: Mapping[str, str]) -> str:
    shown = {
        name: with_unit(f"{value:.6g}", unit_for_people(units.get(name, "")))
        for name, value in record.parameters.items()
    }
    return ", ".join(f"{name} = {value}" for name, value in shown.items())
