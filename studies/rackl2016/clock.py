"""Wall time of a task over all its starts, also of those that were killed."""

from __future__ import annotations

import json
import os
import resource
import threading
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType

from grainfit.files import write_atomically

#: How often it is written down, s: so much is lost when the process is killed.
_SECONDS_BETWEEN_NOTES = 5.0


@dataclass(frozen=True)
class Cost:
    """What something took.

    Parameters
    ----------
    wall_seconds : float
        Time that passed while it was worked on, s.
    processor_seconds : float
        Processor time of this process and of the programs that it ran, s.
    others_seconds : float
        Processor time that all else on the machine used meanwhile, s: with much of it, the wall
        time says little.
    """

    wall_seconds: float = 0.0
    processor_seconds: float = 0.0
    others_seconds: float = 0.0

    @property
    def was_disturbed(self) -> bool:
        """Whether others used more than a tenth of a core."""
        return self.others_seconds > 0.1 * self.wall_seconds


class Clock:
    """Measures wall and processor time and keeps them in a file.

    Parameters
    ----------
    path : Path
        Where the sums over all starts are kept.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._before = read_cost(path)
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._note_now_and_then, daemon=True)

    def __enter__(self) -> Clock:
        self._wall, self._own, self._all = time.monotonic(), _own_seconds(), _all_seconds()
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stopped.set()
        self._thread.join()
        self._note()

    @property
    def cost(self) -> Cost:
        """What it has taken by now."""
        own = _own_seconds() - self._own
        return Cost(
            self._before.wall_seconds + time.monotonic() - self._wall,
            self._before.processor_seconds + own,
            self._before.others_seconds + max(0.0, _all_seconds() - self._all - own),
        )

    def _note_now_and_then(self) -> None:
        while not self._stopped.wait(_SECONDS_BETWEEN_NOTES):
            self._note()

    def _note(self) -> None:
        write_atomically(self._path, json.dumps(asdict(self.cost)))


def read_cost(path: Path) -> Cost:
    """Read what a clock has kept; nothing at all when there is none."""
    if not path.exists():
        return Cost()
    return Cost(**json.loads(path.read_text(encoding="utf-8")))


def _own_seconds() -> float:
    """Processor time of this process and of its programs that have ended, s."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def _all_seconds() -> float:
    """Processor time of everything on this machine since it started, s."""
    numbers = Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0].split()[1:]
    user, nice, system = (int(number) for number in numbers[:3])
    return (user + nice + system) / os.sysconf("SC_CLK_TCK")
