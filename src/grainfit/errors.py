"""The few error types a user meets; every one says what is wrong and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal


class GrainfitError(Exception):
    """Base of all errors that grainfit raises on purpose."""


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong in the user's input.

    Parameters
    ----------
    key : str
        Where it is: a dotted key of the calibration file, or the name of an argument.
    message : str
        What is wrong, with the offending value.
    remedy : str
        What the user can do about it.
    """

    key: str
    message: str
    remedy: str = ""

    def __str__(self) -> str:
        text = f"{self.key}: {self.message}" if self.key else self.message
        return f"{text} {self.remedy}".rstrip()


class InputError(GrainfitError, ValueError):
    """The user's input cannot be used; lists every fault found, not only the first.

    Parameters
    ----------
    faults : sequence of Fault
        All faults found.
    source : str, optional
        The file they were found in.
    """

    def __init__(self, faults: Sequence[Fault] | Fault, source: str = "") -> None:
        self.faults: tuple[Fault, ...] = (faults,) if isinstance(faults, Fault) else tuple(faults)
        self.source = source
        prefix = f"{source}: " if source else ""
        super().__init__("\n".join(f"{prefix}{fault}" for fault in self.faults))


class SolverNotFoundError(GrainfitError):
    """A solver's program is not installed; the message says how to install it."""


class NotMeasurableError(GrainfitError):
    """A quantity cannot be measured on what a run left behind (for example: there is no heap)."""


class StoreError(GrainfitError):
    """The run store cannot be used (locked by another process, newer version, damaged)."""


class ExecutorError(GrainfitError):
    """What was to make the runs cannot make any more, or none of this kind."""


FailureKind = Literal["machine", "timeout", "simulation", "evaluation", "cancelled"]


class RunFailedError(GrainfitError):
    """One DEM run gave no responses.

    Parameters
    ----------
    reason : str
        One line for people.
    log_tail : str
        The last lines of the solver's output.
    kind : {"machine", "timeout", "simulation", "evaluation", "cancelled"}
        Whose fault it was: the machine's (worth another try), the time-out's (worth another try at
        the next start, perhaps with a longer one), the simulation's (the same run
        would fail again), the evaluation's (the run ended but could not be measured), or nobody's
        (the user stopped it).
    """

    def __init__(self, reason: str, log_tail: str = "", kind: FailureKind = "simulation") -> None:
        super().__init__(reason)
        self.reason = reason
        self.log_tail = log_tail
        self.kind: FailureKind = kind
