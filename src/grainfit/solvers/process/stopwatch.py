"""A stopwatch that does not count the time in which its own process was suspended."""

from __future__ import annotations

import time

#: Longest time between two looks that counts, s: a process that is busy looks at least so often.
LONGEST_LOOK = 5.0


class Stopwatch:
    """Seconds since the start, as far as they were watched.

    A time-out is for programs that hang. A suspended computer, or ``kill -STOP`` of everything,
    stops program and watcher alike.
    """

    def __init__(self) -> None:
        self._seconds = 0.0
        self._looked = time.monotonic()

    def look(self) -> float:
        """Return the seconds so far; look more often than every `LONGEST_LOOK` seconds."""
        now = time.monotonic()
        self._seconds += min(now - self._looked, LONGEST_LOOK)
        self._looked = now
        return self._seconds
