"""Find tests whose model ignores the seed: their runs at the same parameters are one run.

Two runs gave the same output when all their responses, those that nobody asked for included, and
their raw output are equal to the last digit. Independent runs may do so, too, where they count or
round. So the numbers that both have must have more digits than agree by chance. Zeros and whole
numbers do not count, nor what runs with other parameters gave as well, as rounded numbers do.
"""

from __future__ import annotations

import filecmp
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grainfit.campaign.work_folder import run_folder
from grainfit.evaluation import Curve, Evaluation, Measured, name_of_test, response_name
from grainfit.solvers.base import Solver

#: Digits in common that are no chance, and those where the text of the model has no seed. One
#: number has at most 17.
_DIGITS, _DIGITS_UNREAD = 150, 10
#: So much of a file is searched for numbers, bytes.
_SEARCHED = 1_000_000
_DECIMAL = re.compile(rb"\d+\.\d+(?:[eE][-+]?\d+)?")


@dataclass(frozen=True)
class DeterministicTests:
    """Tests of a calibration whose output does not depend on the seed.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    folder : Path or None
        The work folder, which may have the raw output of the runs.
    """

    solvers: Mapping[str, Solver]
    folder: Path | None = None
    _compared: dict[tuple[str, ...], int | None] = field(default_factory=dict)

    def among(self, evaluations: Sequence[Evaluation]) -> tuple[str, ...]:
        """Return the names of these tests, as far as the evaluations tell."""
        return tuple(name for name in self.solvers if self._is_deterministic(name, evaluations))

    def _is_deterministic(self, test: str, evaluations: Iterable[Evaluation]) -> bool:
        solver = self.solvers[test]
        runs = [one for one in evaluations if _runs_of(test, one) and not one.failed_in(test)]
        if any(solver.record_of(one.proposal.parameters, one.proposal.seed) for one in runs[:1]):
            # A row that is read again tells nothing of what wrote it.
            return False
        places: dict[tuple[float, ...], list[Evaluation]] = {}
        for run in runs:
            places.setdefault(tuple(run.proposal.parameters.values()), []).append(run)
        digits = 0
        for place, (first, *others) in places.items():
            if not others:
                continue
            elsewhere = [run for key, found in places.items() if key != place for run in found]
            common = [self._common_digits(test, first, other, elsewhere) for other in others]
            if None in common:
                return False
            digits += sum(filter(None, common))
        use = solver.seed_use
        return use == "none" or digits >= (_DIGITS_UNREAD if use == "unread" else _DIGITS)

    def _common_digits(
        self, test: str, first: Evaluation, other: Evaluation, elsewhere: Sequence[Evaluation]
    ) -> int | None:
        """Return the digits that the outputs of two runs have in common; None if they differ."""
        if first.proposal.seed == other.proposal.seed:
            return 0
        found = self._responses(test, first)
        if found != self._responses(test, other):
            return None
        compared = (*_runs_of(test, first), *_runs_of(test, other))
        if compared not in self._compared:
            self._compared[compared] = self._digits_of_raw_output(
                test, first, other, next(iter(elsewhere), None)
            )
        in_files = self._compared[compared]
        if in_files is None:
            return None
        same = set().union(*(_numbers(self._responses(test, run)) for run in elsewhere))
        return _digits(_numbers(found) - same) + in_files

    def _digits_of_raw_output(
        self, test: str, first: Evaluation, other: Evaluation, elsewhere: Evaluation | None
    ) -> int | None:
        """Return the same for the files of the runs; 0 where those of a run are not there."""
        mine, its = self._files(test, first), self._files(test, other)
        same = self._files(test, elsewhere) if elsewhere else {}
        if not mine or not its:
            return 0
        try:
            if mine.keys() != its.keys():
                return None
            if not all(filecmp.cmp(mine[name], its[name], shallow=False) for name in mine):
                return None
            return _digits(
                token
                for name, path in mine.items()
                for token in _decimals(path) - (_decimals(same[name]) if name in same else set())
            )
        except OSError:
            # Somebody removes them.
            return 0

    def _files(self, test: str, evaluation: Evaluation) -> dict[str, Path]:
        """Return the raw output of the runs of a test by its names."""
        if self.folder is None or not self.solvers[test].uses_folder:
            return {}
        folders = [run_folder(self.folder, run) for run in _runs_of(test, evaluation)]
        return {
            f"{number}/{path.relative_to(folder)}": path
            for number, folder in enumerate(folders)
            if folder.is_dir()
            for path in self.solvers[test].raw_output(folder)
        }

    def _responses(self, test: str, evaluation: Evaluation) -> dict[str, Measured]:
        prefix = response_name(test, "", len(self.solvers))
        both: dict[str, Measured] = {**evaluation.responses, **evaluation.curves}
        return {name: found for name, found in both.items() if name.startswith(prefix)}


def _runs_of(test: str, evaluation: Evaluation) -> tuple[str, ...]:
    return tuple(run for name, run in evaluation.runs.items() if name_of_test(name) == test)


def _numbers(responses: Mapping[str, Measured]) -> set[bytes]:
    """Return the numbers of responses with all their digits, without whole ones."""
    values = (number for found in responses.values() for number in _values(found))
    return {repr(abs(value)).encode() for value in values if not value.is_integer()}


def _values(found: Measured) -> Iterator[float]:
    yield from found.values if isinstance(found, Curve) else (found.value,)


def _decimals(path: Path) -> set[bytes]:
    """Return the decimal fractions in a text file."""
    with path.open("rb") as file:
        found = set(_DECIMAL.findall(file.read(_SEARCHED)))
    return {token for token in found if float(token) and not float(token).is_integer()}


def _digits(tokens: Iterable[bytes]) -> int:
    return sum(sum(48 <= byte <= 57 for byte in token) for token in set(tokens))
