"""Registrations of hold-outs in a work folder: what was to be predicted, before it was known.

``holdouts.json`` has an entry for every version of the targets of a hold-out, the first one first,
and the parameter sets at which hold-outs are simulated, so that a later start makes the same runs.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from grainfit.calibration import messages
from grainfit.errors import StoreError
from grainfit.files import LARGEST_RESULT, read_within, write_atomically, writing
from grainfit.plain_data import parse_json, read_plain
from grainfit.problem import CurveTarget, Target
from grainfit.result import Registration

HOLDOUTS_NAME = "holdouts.json"


@dataclass(frozen=True)
class Registered:
    """Targets of a hold-out at one time.

    Parameters
    ----------
    test, date : str
        Name of the hold-out, and when, ISO 8601 in UTC.
    runs : int
        Finished runs of the work folder.
    targets_hash, file_hash : str
        SHA-256 of the targets, see `hash_of_targets`, and of the calibration file.
    """

    test: str
    date: str
    runs: int
    targets_hash: str
    file_hash: str


@dataclass(frozen=True)
class Draws:
    """Parameter sets at which hold-outs are simulated.

    Parameters
    ----------
    key : str
        Of what they were drawn for: a calibration and its answer.
    posterior, prior : tuple of mapping of str to float
        Parameter sets that agree with the fitted tests, and some over the intervals.
    """

    key: str
    posterior: tuple[Mapping[str, float], ...]
    prior: tuple[Mapping[str, float], ...]


@dataclass(frozen=True)
class _Content:
    registrations: tuple[Registered, ...] = ()
    draws: tuple[Draws, ...] = ()


@dataclass
class HoldoutFile:
    """Registrations and draws of hold-outs, kept in a work folder.

    Parameters
    ----------
    folder : Path, optional
        The work folder, which this process holds; without one, nothing is kept.

    Raises
    ------
    StoreError
        The file is damaged or cannot be read.
    """

    folder: Path | None = None
    _content: _Content = field(default_factory=_Content, repr=False)

    def __post_init__(self) -> None:
        path = self._path
        if path is None or not path.exists():
            return
        try:
            self._content = read_plain(_Content, parse_json(read_within(path, LARGEST_RESULT)))
        except OSError as error:
            why = error.strerror
            raise StoreError(messages.HOLDOUTS_UNREADABLE(path=str(path), why=why)) from error
        except (ValueError, RecursionError) as error:
            raise StoreError(messages.HOLDOUTS_DAMAGED(path=str(path), why=error)) from error

    def register(
        self, test: str, targets: Sequence[Target | CurveTarget], file_text: str, runs: int
    ) -> Registration | None:
        """Register the targets of a hold-out, unless they are the last ones registered.

        Parameters
        ----------
        test : str
            Name of the hold-out.
        targets : sequence of Target or CurveTarget
            Its targets; without any, nothing is registered.
        file_text : str
            Text of the calibration file; empty without one.
        runs : int
            Finished runs of the work folder.

        Raises
        ------
        StoreError
            The work folder cannot be written to.
        """
        if not targets:
            return None
        digest = hash_of_targets(targets)
        known = [*self._of(test)]
        if not known or known[-1].targets_hash != digest:
            date = datetime.now(UTC).isoformat(timespec="seconds")
            text_hash = hashlib.sha256(file_text.encode()).hexdigest() if file_text else ""
            entry = Registered(test, date, runs, digest, text_hash)
            known.append(entry)
            self._write(_Content((*self._content.registrations, entry), self._content.draws))
        first, last = known[0], known[-1]
        # Targets that were put back are the registered ones.
        changed = last.date if last.targets_hash != first.targets_hash else ""
        return Registration(first.date, first.runs, first.targets_hash, first.file_hash, changed)

    def draws(self, key: str) -> Draws | None:
        """Return the parameter sets that were drawn for a calibration and its answer, if any."""
        return next((draws for draws in self._content.draws if draws.key == key), None)

    def keep(self, draws: Draws) -> None:
        """Keep parameter sets, for later starts.

        Raises
        ------
        StoreError
            The work folder cannot be written to.
        """
        self._write(_Content(self._content.registrations, (*self._content.draws, draws)))

    def _of(self, test: str) -> Iterator[Registered]:
        return (entry for entry in self._content.registrations if entry.test == test)

    @property
    def _path(self) -> Path | None:
        return None if self.folder is None else self.folder / HOLDOUTS_NAME

    def _write(self, content: _Content) -> None:
        self._content = content
        if (path := self._path) is None:
            return
        with writing(path, StoreError):
            write_atomically(path, json.dumps(asdict(content), indent=1) + "\n")


def hash_of_targets(targets: Sequence[Target | CurveTarget]) -> str:
    """Return the SHA-256 of targets: values and uncertainties by name, as sorted JSON."""
    data: dict[str, Any] = {
        target.name: target.to_json()
        if isinstance(target, CurveTarget)
        else [target.value, target.standard_uncertainty, target.unit]
        for target in targets
    }
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()
