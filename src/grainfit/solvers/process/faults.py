"""Find the cause of a failed run from the exit code and the log of its program.

A run that failed because of the machine is tried again; one that failed in the simulation is not.
The exit code alone rarely shows the difference, so the messages of programs and of MPI launchers
are searched as well.
"""

from __future__ import annotations

import errno
import re
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grainfit import platforms
from grainfit.errors import FailureKind
from grainfit.messages import Message
from grainfit.solvers.process import messages

_LONGEST_LINE = 200
#: Exit code of a shell (and of similar launchers): this plus the signal.
_SIGNAL_CODES = 128
#: Exit code of Python launchers, such as the ``lmp`` that pip installs: this minus the signal. Only
#: for the usual signals: other programs end with -1 or -2 for different reasons.
_NEGATED_CODES = 256
_USUAL_ENDS = platforms.signals(
    "SIGSEGV", "SIGKILL", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL", "SIGTERM"
)
_NOT_STARTED_CODES = (126, 127)

_DISK = re.compile(
    r"no space left on device|disk quota exceeded|\b(ENOSPC|EDQUOT)\b|not enough space for",
    re.IGNORECASE,
)
_MEMORY = re.compile(
    r"std::bad_alloc|cannot allocate memory|out of memory|not enough memory|MemoryError\b"
    r"|failed to (re)?allocate|insufficient (virtual )?memory|\boom[-_ ]?kill",
    re.IGNORECASE,
)
_LICENCE = re.compile(
    r"\bno\b.{0,30}\blicen[cs]|licen[cs].*"
    r"(could not|cannot|can't|unable|fail|error|denied|expired|invalid|missing|refused|timed out"
    r"|unavailable|in use|exceeded|reached|not (found|available|valid|granted|obtained))"
    r"|(could not|cannot|can't|unable to|failed to) (check ?out|obtain|acquire|get|find).*licen[cs]"
    r"|could not check ?out|\bflex(net|lm)\b.*-\d+,\d+",
    re.IGNORECASE,
)
#: Parts of messages about licence terms, which are not errors.
_TERMS = re.compile(
    r"\b(A?L?GPL|GNU|MIT|BSD|Apache|Creative Commons|warranty|copyright|distributed|terms)\b",
    re.IGNORECASE,
)
_NOT_STARTED = re.compile(
    r"execvp error|unable to (find|launch) the specified|error while loading shared libraries"
    r"|^\S+: (line )?\d+: .*: (not found|command not found|exec format error)"
    r"|^\S+: (line )?\d+: (exec: )?\S+: (not found|cannot execute)",
    re.IGNORECASE,
)
#: Messages of an MPI that lost a rank for an unknown reason.
_RANK_LOST = re.compile(
    r"process manager error|Fatal error in \w+: Other MPI error|has lost communication with"
)
_NAMES = {
    words: number
    for words, name in {
        "Segmentation fault": "SIGSEGV",
        "Killed": "SIGKILL",
        "Aborted": "SIGABRT",
        "Bus error": "SIGBUS",
        "Floating point exception": "SIGFPE",
        "Illegal instruction": "SIGILL",
        "Terminated": "SIGTERM",
    }.items()
    for number in platforms.signals(name)
}
_NAMED = "|".join(_NAMES)
#: Open MPI and its successors; Intel MPI; MPICH's Hydra; bash, srun and other shells.
_SIGNALLED = (
    re.compile(r"exited on signal (\d+)"),
    re.compile(r"KILLED BY SIGNAL: (\d+)"),
    re.compile(r"EXIT STRING: .*\(signal (\d+)\)"),
    re.compile(rf"line \d+: +\d+ ({_NAMED})\b"),
    re.compile(rf"^srun: error: .*: ({_NAMED})\b"),
    re.compile(rf"^({_NAMED})( \(core dumped\))?$"),
)
#: Signals sent from outside, by the system or a user; all others come from the program itself.
_OUTSIDE = frozenset(
    platforms.signals("SIGKILL", "SIGTERM", "SIGHUP", "SIGINT", "SIGXCPU", "SIGXFSZ", "SIGUSR1")
)


@dataclass(frozen=True)
class Cause:
    """Cause of a failed run.

    Parameters
    ----------
    reason : str
        Reason in one line.
    kind : {"machine", "timeout", "simulation", "evaluation", "cancelled"}
        Kind of the failure; see `RunFailedError`.
    """

    reason: str
    kind: FailureKind


def cause_of_exit(program: str, code: int, log: str) -> Cause:
    """Return the cause of a nonzero exit code of a program.

    Parameters
    ----------
    program : str
        The program that was started.
    code : int
        Its exit code; negative for the number of the signal that killed it.
    log : str
        End of its output.
    """
    name = Path(program).name
    if reason := machine_fault(log):
        return Cause(f"{name}: {reason}", "machine")
    if code < 0:
        return _cause_of_signal(messages.KILLED, name, -code)
    message = _last_message(log)
    exit_code = messages.EXIT_CODE(code=code)
    if code in _NOT_STARTED_CODES:
        reason = messages.STARTED_NOTHING(program=name, reason=message or exit_code)
        return Cause(reason, "machine")
    # After the error message of one rank the others are killed: the message is the cause.
    if not message.startswith("ERROR"):
        if number := _reported_signal(code, log):
            return _cause_of_signal(messages.PROCESS_KILLED, name, number)
        for line in filter(_RANK_LOST.search, _lines(log)):
            return Cause(messages.PROCESS_LOST(program=name, line=line), "machine")
    reason = f"{exit_code}: {message}" if message else exit_code
    return Cause(messages.ENDED(program=name, reason=reason), "simulation")


def machine_fault(log: str) -> str:
    """Return the fault of the machine that a log reports; empty if there is none."""
    for line in _lines(log):
        if _DISK.search(line):
            return messages.DISK_IN_LOG(reason=line)
        if _MEMORY.search(line):
            return messages.NO_MEMORY(reason=line)
        if _LICENCE.search(line) and not _TERMS.search(line):
            return messages.NO_LICENCE(reason=line)
        if _NOT_STARTED.search(line):
            return messages.NO_PROGRAM(reason=line)
    return ""


def machine_error(error: BaseException) -> str:
    """Return the fault of the machine that a Python exception reports; empty if there is none."""
    if isinstance(error, MemoryError):
        return messages.NO_MEMORY(reason=" ".join(str(error).split()) or "MemoryError")
    if not isinstance(error, OSError):
        return ""
    if error.errno == errno.ENOSPC:
        return messages.DISK_FULL()
    if error.errno == errno.EDQUOT:
        return messages.QUOTA_USED_UP()
    if error.errno == errno.ENOMEM:
        return messages.NO_MEMORY(reason=error)
    return ""


def _cause_of_signal(killed: Message, program: str, number: int) -> Cause:
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = messages.SIGNAL(number=number)
    if number in platforms.signals("SIGKILL"):
        name = messages.OUT_OF_MEMORY(signal=name)
    reason = killed(program=program, signal=name)
    return Cause(reason, "machine" if number in _OUTSIDE else "simulation")


def _reported_signal(code: int, log: str) -> int:
    """Return the signal that ended a process according to a launcher or a shell, or 0."""
    reported = list(_signals_in(log))
    if code - _SIGNAL_CODES in set(signal.Signals):
        reported.append(code - _SIGNAL_CODES)
    if _NEGATED_CODES - code in _USUAL_ENDS:
        reported.append(_NEGATED_CODES - code)
    # A launcher kills the other ranks when one has crashed, and may report them first.
    own = [number for number in reported if number not in _OUTSIDE]
    return next(iter(own or reported), 0)


def _signals_in(log: str) -> Iterator[int]:
    for line in _lines(log):
        for pattern in _SIGNALLED:
            if found := pattern.search(line):
                text = found.group(1)
                yield int(text) if text.isdecimal() else int(_NAMES[text])


def _last_message(log: str) -> str:
    """Return the error message of the program, or its last line."""
    lines = list(_lines(log))
    return next((line for line in lines if line.startswith("ERROR")), lines[-1] if lines else "")


def _lines(log: str) -> Iterator[str]:
    for line in log.splitlines():
        if stripped := " ".join(line.split()):
            yield stripped if len(stripped) <= _LONGEST_LINE else f"{stripped[:_LONGEST_LINE]}..."
