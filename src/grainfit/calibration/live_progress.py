"""Show the progress of a calibration: a bar in a terminal or notebook, lines in a log file."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Mapping

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar
from rich.table import Column
from rich.text import Text

from grainfit.calibration import messages
from grainfit.calibration.progress import Progress
from grainfit.evaluation import Evaluation
from grainfit.formatting import assigned, duration, plain

#: Interval of the lines of progress without a terminal, s.
_LINE_SECONDS = 15.0
_BAR_WIDTH = 16
#: As many characters of an identity as `grainfit runs list` shows.
_IDENTITY = 7


class LiveProgress:
    """Progress display: a bar with text in a terminal or a notebook, plain lines elsewhere.

    Parameters
    ----------
    console : Console, optional
        Output; by default standard error, or the notebook.
    every_run : bool
        Print a line for every evaluation that has ended.
    units : mapping of str to str, optional
        Units of parameters and responses, for these lines.
    """

    def __init__(
        self,
        console: Console | None = None,
        *,
        every_run: bool = False,
        units: Mapping[str, str] | None = None,
    ) -> None:
        self._units = units or {}
        self._console = console or Console(stderr=True)
        self._is_live = _can_draw(self._console)
        self._bar = Bar(
            BarColumn(_BAR_WIDTH, table_column=Column(min_width=_BAR_WIDTH)),
            TextColumn("{task.description}", markup=False, table_column=Column(overflow="fold")),
            console=self._console,
            refresh_per_second=4,
            transient=True,
        )
        self._task = self._bar.add_task("", total=None)
        self._last_line = ("", float("-inf"))
        self._notices = 0
        #: Evaluations that have been printed; None to print none.
        self._printed = 0 if every_run else None
        self._names_warm_start = True
        self._started = time.monotonic()

    def __enter__(self) -> LiveProgress:
        if self._is_live:
            self._bar.start()
        return self

    def __exit__(self, *_raised: object) -> None:
        if self._is_live:
            self._bar.stop()

    def update(self, progress: Progress) -> None:
        """Show the current state of the calibration."""
        if self._names_warm_start and progress.warm_start_runs:
            self._print(_warm_start(progress.warm_start_runs))
            self._names_warm_start = False
        for notice in progress.notices[self._notices :]:
            self._print(notice, "yellow")
        self._notices = len(progress.notices)
        if self._printed is not None:
            for evaluation in progress.evaluations[self._printed :]:
                self._print(_words_on_run(evaluation, self._units))
            self._printed = len(progress.evaluations)
        line = self._describe(progress)
        if self._is_live:
            total = progress.done + progress.to_come.about
            self._bar.update(self._task, description=line, completed=progress.done, total=total)
            return
        stage, shown = self._last_line
        now = time.monotonic()
        if stage != progress.stage or now - shown > _LINE_SECONDS:
            self._print(line)
            self._last_line = (progress.stage, now)

    def say(self, words: str) -> None:
        """Print a sentence above the bar."""
        self._print(words)

    def _print(self, words: str, style: str = "") -> None:
        """Print text without markup and without control characters of the terminal."""
        shown = "\n".join(plain(line) for line in words.split("\n"))
        self._console.print(Text(shown, style=style), soft_wrap=True)

    def _describe(self, progress: Progress) -> str:
        parts = [
            f"{progress.stage}: {progress.done} done",
            f"{progress.running} running",
            *([f"{progress.waiting} waiting"] if progress.waiting else []),
            f"{progress.failed} failed",
            f"{progress.to_come} to come",
        ]
        if progress.best_deviation is not None:
            parts.append(f"best run within {progress.best_deviation:.1%}")
        if progress.best_expected_deviation is not None:
            parts.append(f"answer expected within {progress.best_expected_deviation:.1%}")
        parts.append(f"{duration(time.monotonic() - self._started)} elapsed")
        if progress.seconds_left_range is not None:
            parts.append(f"{_span(*map(duration, progress.seconds_left_range))} left")
        return ", ".join(parts)


def _span(low: str, high: str) -> str:
    return f"about {high}" if low == high else f"{low} to {high}"


def _can_draw(console: Console) -> bool:
    """Return True if a bar can be drawn; in a notebook rich needs ipywidgets for it."""
    if console.is_jupyter:
        return importlib.util.find_spec("ipywidgets") is not None
    return console.is_interactive


def _words_on_run(evaluation: Evaluation, units: Mapping[str, str]) -> str:
    """Return parameters, responses and failures of an evaluation in one line."""
    proposal = evaluation.proposal
    asked = ", ".join(assigned(proposal.parameters, units, 5))
    values = {name: given.value for name, given in evaluation.responses.items()}
    found = [*assigned(values, units, 5)]
    found += [f"{name}: a curve of {len(c.values)} points" for name, c in evaluation.curves.items()]
    found += [f"{test} failed: {why}" for test, why in evaluation.failures.items()]
    took = duration(evaluation.simulated_seconds) if evaluation.simulated_seconds else "known"
    identities = " ".join(run[:_IDENTITY] for run in evaluation.runs.values())
    return f"{proposal.stage} run {identities}: {asked} -> {', '.join(found)} ({took})"


def _warm_start(origins: Mapping[str, int]) -> str:
    places = (f"{origin or 'this work folder'} ({n})" for origin, n in origins.items())
    return messages.WARM_START(runs=sum(origins.values()), places=", ".join(places))
