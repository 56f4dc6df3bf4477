"""Error types of grainfit; every message says what is wrong and what to do."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from grainfit.one_line import shortened

#: Beginning of the key of a test or a hold-out, which count from zero.
_TEST = re.compile(r"^(test|holdout)\[(\d+)\](\.|$)")


class GrainfitError(Exception):
    """Base of all errors that grainfit raises on purpose."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({shortened(str(self))})"


def error_in_words(error: BaseException) -> str:
    r"""Return an error in one line: with the name of its type, unless it is grainfit's own.

    Examples
    --------
    >>> error_in_words(ValueError("no such\nvalue")), error_in_words(ValueError())
    ('ValueError: no such value', 'ValueError, without a message')
    """
    text = " ".join(str(error).split())
    if isinstance(error, GrainfitError):
        return text
    name = type(error).__name__
    return f"{name}: {text}" if text else f"{name}, without a message"


@dataclass(frozen=True)
class Fault:
    """One fault in the user's input.

    Parameters
    ----------
    key : str
        Dotted key of the calibration file, or name of an argument.
    message : str
        Description of the fault, with the value.
    remedy : str
        Suggestion how to correct it.
    """

    key: str
    message: str
    remedy: str = ""

    def __post_init__(self) -> None:
        assert self.message.strip(), "a fault without words"

    @property
    def place(self) -> str:
        """The key for readers, who count tests from one: ``test 1, targets.angle``."""
        return _TEST.sub(
            lambda found: f"{found[1]} {int(found[2]) + 1}{', ' * bool(found[3])}", self.key
        )

    def __str__(self) -> str:
        text = f"{self.place}: {self.message}" if self.key else self.message
        return f"{text} {self.remedy}".rstrip()


class InputError(GrainfitError, ValueError):
    """The user's input cannot be used; lists every fault found, not only the first.

    Parameters
    ----------
    faults : sequence of Fault
        All faults found.
    source : str, optional
        File with the faults.
    """

    def __init__(self, faults: Sequence[Fault] | Fault, source: str = "") -> None:
        self.faults: tuple[Fault, ...] = (faults,) if isinstance(faults, Fault) else tuple(faults)
        self.source = source
        prefix = f"{source}: " if source else ""
        super().__init__("\n".join(f"{prefix}{fault}" for fault in self.faults))

    @property
    def reasons(self) -> str:
        """All faults with their keys and without remedies, as a part of a sentence."""
        return "; ".join(f"{f.place}: {f.message}" if f.key else f.message for f in self.faults)

    @classmethod
    def raise_for(cls, faults: Iterable[Fault]) -> None:
        """Raise the error if there are faults."""
        if found := [*faults]:
            raise cls(found)

    def __reduce__(self) -> tuple[type[InputError], tuple[Sequence[Fault], str]]:
        """Make it again of its faults: an exception is made of its text otherwise."""
        return type(self), (self.faults, self.source)


class SolverNotFoundError(GrainfitError):
    """A solver's program is not installed; the message says how to install it."""


class NotMeasurableError(GrainfitError):
    """A quantity cannot be measured on the output of a run (for example: there is no heap)."""


class StoreError(GrainfitError):
    """The run store cannot be used (locked by another process, newer version, damaged)."""


class StoreUnreachableError(StoreError):
    """The server of a run store does not answer, or it has cut a connection; it may come back."""


class ExecutorError(GrainfitError):
    """The executor cannot execute more runs, or not runs of this kind."""


FailureKind = Literal["machine", "timeout", "simulation", "evaluation", "cancelled"]


class RunFailedError(GrainfitError):
    """One DEM run gave no responses.

    Parameters
    ----------
    reason : str
        Reason in one line.
    log_tail : str
        The last lines of the solver's output.
    kind : {"machine", "timeout", "simulation", "evaluation", "cancelled"}
        Cause of the failure: the machine (tried again), a time-out (tried again at the next start),
        the simulation (the same run would fail again), the evaluation (the run ended but could not
        be measured), or the user, who stopped it.
    """

    def __init__(self, reason: str, log_tail: str = "", kind: FailureKind = "simulation") -> None:
        super().__init__(reason)
        self.reason = reason
        self.log_tail = log_tail
        self.kind: FailureKind = kind
