"""Findings of the study: the rows of its tables, and whether its goals are met."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from grainfit.calibration.verification import mean_with_interval
from grainfit.verdict.evidence import Verified
from studies.rackl2016 import recovery
from studies.rackl2016.clock import Cost
from studies.rackl2016.plan import METHODS, all_tasks, task_name, truth_of
from studies.rackl2016.setting import (
    ANGLE,
    BULK_DENSITY,
    CASES,
    DENSITY,
    MEASURED,
    MODULUS,
    RESPONSES,
    ROLLING_FRICTION,
    SEEDS,
    TOLERANCES,
    WIDTHS,
    Case,
)
from studies.rackl2016.tasks import Record, Results

#: What the study is to show: see `goals`.
FEWER_RUNS, LESS_WALL_TIME = 2.5, 2.5
MOST_RUNS, MOST_RUNS_TO_UNREACHABLE = 16, 8
LARGEST_DEVIATION = {BULK_DENSITY: 0.5, ANGLE: 2.0}
COVERAGE = (0.85, 1.0)
OURS, STAGED = "sequential", "staged"
PEERS = ("octave-1", "octave-0")
_NORMAL_95 = 1.96


@dataclass(frozen=True)
class Deviation:
    """Deviation of an expected response from its target, %, and half of its 95 % interval."""

    percent: float
    half_width: float


@dataclass(frozen=True)
class Row:
    """One calibration of table 2 by one method."""

    case: Case
    method: str
    record: Record
    truth: Record | None
    cost: Cost

    @property
    def runs(self) -> int:
        """DEM runs of the search, without any verification."""
        return int(self.record["design_runs"] + self.record["optimisation_runs"])

    @property
    def runs_with_verification(self) -> int:
        """All DEM runs."""
        return self.runs + int(self.record["verification_runs"])

    @property
    def search_seconds(self) -> float:
        """Wall time of the search, without any verification, s."""
        return self.cost.wall_seconds - float(self.record["verification_seconds"])

    def at_last_run(self, response: str) -> float | None:
        """Deviation of the last run, %: what the paper reports; None where that run failed."""
        last = self.record["last_run"]
        return percent_off(response, last[response]) if last and response in last else None

    def expected(self, response: str) -> Deviation | None:
        """Deviation of the expected response; None when the fresh seeds have not been run."""
        return None if self.truth is None else deviation(self.truth, response)

    def meets_targets(self, *, if_in_doubt: bool = False) -> bool:
        """Whether its expected responses, or all that they may be, are within the tolerances."""
        found = {name: self.expected(name) for name in RESPONSES}
        return all(
            off is not None
            and abs(off.percent) - if_in_doubt * off.half_width
            <= 100 * TOLERANCES[name] / MEASURED[name]
            for name, off in found.items()
        )


@dataclass(frozen=True)
class Goal:
    """What the study is to show, and whether it does; None when it has not been run."""

    words: str
    found: str
    met: bool | None


@dataclass(frozen=True)
class Recovered:
    """One case of the recovery study."""

    number: int
    true: dict[str, float]
    record: Record
    fresh: Record

    def parameter_error(self, name: str) -> float:
        """Deviation of a recovered parameter from the true one, %."""
        return 100 * (float(self.record["parameters"][name]) / self.true[name] - 1)

    def truth(self, response: str) -> Verified:
        """Expected response at the recovered parameters, by fresh seeds."""
        return mean_with_interval(self.fresh["values"][response])

    def response_error(self, response: str) -> float:
        """Deviation of that from the "measured" value, %."""
        measured = float(self.record["responses"][response]["target"])
        return 100 * (self.truth(response).mean / measured - 1)

    def stated(self, response: str, verified: bool) -> tuple[float, float] | None:
        """What was stated of a response: value and half of its 95 % interval."""
        found = self.record["responses"][response]
        if not verified:
            return found["predicted"], _NORMAL_95 * found["standard_error"]
        if found["verified_interval"] is None:
            return None
        return found["verified_mean"], found["verified_interval"]

    def is_covered(self, response: str, verified: bool) -> bool | None:
        """Whether the stated interval has the truth, which is itself known to an interval only.

        None where none is stated: a verification that cannot decide is not begun.
        """
        stated, truth = self.stated(response, verified), self.truth(response)
        if stated is None:
            return None
        return abs(stated[0] - truth.mean) <= math.hypot(stated[1], truth.half_width)


def percent_off(response: str, value: float) -> float:
    """Deviation from the paper's target, %."""
    return 100 * (value / MEASURED[response] - 1)


def deviation(truth: Record, response: str) -> Deviation:
    """Deviation of the mean of fresh seeds from the paper's target."""
    known = mean_with_interval(truth["values"][response])
    share = 100 / MEASURED[response]
    return Deviation(percent_off(response, known.mean), known.half_width * share)


class Findings:
    """All that is known by now.

    Parameters
    ----------
    results : Results
        Records of the tasks that have been done.
    """

    def __init__(self, results: Results) -> None:
        self._results = results
        self._tasks = {task.name: task for task in all_tasks()}

    def record(self, name: str) -> Record | None:
        """Record of a task; None when it has not been done."""
        return self._results.find(self._tasks[name])

    def cost(self, name: str) -> Cost:
        """What a task took."""
        return self._results.cost(self._tasks[name])

    def rows(self, method: str) -> list[Row]:
        """Calibrations by a method that have been done, in the order of table 2."""
        found = []
        for case in CASES:
            name = task_name(method, case)
            record = self.record(name)
            if record is not None:
                truth = self.record(truth_of(name))
                found.append(Row(case, method, record, truth, self.cost(name)))
        return found

    def whole(self, method: str, with_truth: bool = False) -> list[Row]:
        """All six calibrations by a method; none when one is missing."""
        rows = self.rows(method)
        is_whole = len(rows) == len(CASES) and not (with_truth and any(not r.truth for r in rows))
        return rows if is_whole else []

    @property
    def reachable_widths(self) -> list[float] | None:
        """Widths within which some method found a set that meets the targets."""
        rows = [row for method in METHODS for row in self.whole(method, with_truth=True)]
        if len(rows) < len(METHODS) * len(CASES):
            return None
        return [
            w
            for w in WIDTHS
            if any(r.meets_targets(if_in_doubt=True) for r in rows if r.case.width == w)
        ]

    def recovered(self) -> list[Recovered]:
        """Cases of the recovery study that have been done."""
        found = []
        for number in range(recovery.SETS):
            name = f"recovered-{number:02d}"
            record, fresh = self.record(name), self.record(truth_of(name))
            if record is not None and fresh is not None:
                found.append(Recovered(number, recovery.true_parameters(number), record, fresh))
        return found

    def coverage(self, response: str, verified: bool) -> tuple[int, int]:
        """Numbers of recovery cases whose stated interval has the truth, and that state one."""
        found = [case.is_covered(response, verified) for case in self.recovered()]
        return sum(map(bool, found)), sum(one is not None for one in found)

    def speed_up(self) -> dict[str, float] | None:
        """The modulus that computes fastest against the nominal one, both calibrated."""
        free, nominal = self.record("modulus"), self.record(task_name(OURS, CASES[2]))
        names = [truth_of("modulus"), truth_of(task_name(OURS, CASES[2]))]
        records = [self.record(name) for name in names]
        if free is None or nominal is None or None in records:
            return None
        fast, slow = (self._seconds_of_a_run(name) for name in names)
        return {
            "modulus": free["parameters"][MODULUS],
            "time_step": free["rayleigh_time_step"] / nominal["rayleigh_time_step"],
            "seconds_of_a_run": fast,
            "seconds_of_a_nominal_run": slow,
            "processor_time": slow / fast,
        }

    def _seconds_of_a_run(self, name: str) -> float:
        record = self.record(name)
        assert record is not None, "asked for what has been done only"
        return self.cost(name).processor_seconds / int(record["runs_made"])

    # Goals ------------------------------------------------------------------------------------

    def goals(self) -> list[Goal]:
        """What the study is to show."""
        goals = [
            self._within_tolerance(),
            self._on_its_bound(),
            self._unreachable(),
            self._few_runs(),
            self._accurate(),
        ]
        for peer in PEERS:
            goals += self._against(peer)
        return goals + list(self._coverage_goals())

    def _within_tolerance(self) -> Goal:
        words = (
            "all calibrations by grainfit whose targets are reachable end within tolerance, by "
            "their own verification"
        )
        rows, widths = self._ours_reachable(OURS), self.reachable_widths
        both = rows and self._ours_reachable(STAGED)
        if not both or widths is None:
            return Goal(words, "", None)
        rows = [*both, *rows]
        ended = sum(row.record["status"] == "calibrated" for row in rows)
        reachable = ", ".join(f"±{100 * width:.0f} %" for width in widths)
        truly = sum(row.meets_targets() for row in rows)
        right = sum(row.meets_targets() == (row.record["status"] == "calibrated") for row in rows)
        found = (
            f"{ended} of {len(rows)} ({reachable} reachable); by the mean of fresh seeds {truly} "
            f"are, and {right} of the verdicts are right"
        )
        return Goal(words, found, ended == len(rows))

    def _ours_reachable(self, method: str) -> list[Row]:
        widths = self.reachable_widths or []
        return [row for row in self.whole(method) if row.case.width in widths]

    def _on_its_bound(self) -> Goal:
        words = "the ±10 % interval is recognised as ending at the answer: the upper density bound"
        rows = [*self.whole(OURS), *self.whole(STAGED)]
        narrow = [row for row in rows if row.case.width == WIDTHS[0]]
        if len(narrow) < 2 * len(SEEDS):
            return Goal(words, "", None)
        seen = [row for row in narrow if names_upper_density_bound(row.record)]
        return Goal(words, f"{len(seen)} of {len(narrow)}", len(seen) == len(narrow))

    def _unreachable(self) -> Goal:
        words = (
            f"the unfavourable density interval is recognised as such within "
            f"{MOST_RUNS_TO_UNREACHABLE} runs, with the right bound and a proposal"
        )
        records = [self.record(f"unfavourable-{seed}") for seed in SEEDS]
        if None in records:
            return Goal(words, "", None)
        runs = [r["design_runs"] + r["optimisation_runs"] for r in records if r]
        proposals = [proposed_density(r) for r in records if r]
        found = ", ".join(
            f"{n} runs, proposal {p:g} kg/m³" if p else f"{n} runs, no proposal"
            for n, p in zip(runs, proposals, strict=True)
        )
        right = all(r and r["status"] == "unreachable" for r in records) and all(proposals)
        return Goal(words, found, right and max(runs) <= MOST_RUNS_TO_UNREACHABLE)

    def _few_runs(self) -> Goal:
        words = f"sequential: at most {MOST_RUNS} DEM runs each before verification"
        rows = self.whole(OURS)
        if not rows:
            return Goal(words, "", None)
        runs = [row.runs for row in rows]
        return Goal(words, f"{min(runs)} to {max(runs)}", max(runs) <= MOST_RUNS)

    def _accurate(self) -> Goal:
        words = (
            f"sequential: expected responses within {LARGEST_DEVIATION[ANGLE]:g} % (angle) and "
            f"{LARGEST_DEVIATION[BULK_DENSITY]:g} % (density) in every reachable case"
        )
        rows = self._ours_reachable(OURS)
        if not rows or any(row.truth is None for row in rows):
            return Goal(words, "", None)
        worst = {
            name: max(abs(d.percent) for row in rows if (d := row.expected(name)))
            for name in (ANGLE, BULK_DENSITY)
        }
        found = f"at most {worst[ANGLE]:.2f} % and {worst[BULK_DENSITY]:.2f} %"
        return Goal(words, found, all(worst[n] <= LARGEST_DEVIATION[n] for n in worst))

    def _against(self, peer: str) -> Iterator[Goal]:
        ours, theirs = self.whole(OURS), self.whole(peer)
        against = f"sequential against {METHODS[peer]}"

        def ratio(words: str, of: Callable[[Row], float], own: str, goal: float | None) -> Goal:
            if not ours or not theirs:
                return Goal(f"{against}: {words}", "", None)
            their, our = fmean(of(row) for row in theirs), fmean(of(row) for row in ours)
            found = f"{their / our:.2f} times ({their:.0f} against {our:.0f}{own})"
            return Goal(f"{against}: {words}", found, their / our >= (goal or 0))

        yield ratio(f"at least {FEWER_RUNS} times fewer runs of the search", _runs, "", FEWER_RUNS)
        yield ratio(
            f"at least {FEWER_RUNS} times fewer runs, verification included",
            _runs_with_verification,
            "",
            FEWER_RUNS,
        )
        wall = f"at least {LESS_WALL_TIME} times less wall time"
        yield ratio(f"{wall} of the search", _search_seconds, " s", LESS_WALL_TIME)
        included = f"{wall}, verification included"
        yield ratio(included, _wall_seconds, " s", LESS_WALL_TIME)
        yield self._closer(peer, against)

    def _closer(self, peer: str, against: str) -> Goal:
        words = f"{against}: a smaller true deviation, mean of both responses"
        ours, theirs = self.whole(OURS, with_truth=True), self.whole(peer, with_truth=True)
        if not ours or not theirs:
            return Goal(words, "", None)
        our, their = mean_deviation(ours), mean_deviation(theirs)
        return Goal(words, f"{our:.2f} % against {their:.2f} %", our < their)

    def _coverage_goals(self) -> Iterator[Goal]:
        is_whole = len(self.recovered()) == recovery.SETS
        low, high = COVERAGE
        for verified, kind in ((False, "predicted"), (True, "verified")):
            for response in RESPONSES:
                words = (
                    f"recovery: 95 % intervals of the {kind} {response.replace('_', ' ')} hold in "
                    f"{100 * low:.0f} to {100 * high:.0f} % of the cases that have one"
                )
                covered, stated = self.coverage(response, verified)
                if not is_whole or not stated:
                    yield Goal(words, "", None)
                else:
                    found = f"{covered} of {stated} ({recovery.SETS} cases)"
                    yield Goal(words, found, low <= covered / stated <= high)


def _runs(row: Row) -> float:
    return row.runs


def _runs_with_verification(row: Row) -> float:
    return row.runs_with_verification


def _search_seconds(row: Row) -> float:
    return row.search_seconds


def _wall_seconds(row: Row) -> float:
    return row.cost.wall_seconds


def mean_deviation(rows: Iterable[Row]) -> float:
    """Mean of the absolute deviations of the expected responses, %."""
    offs = [row.expected(name) for row in rows for name in RESPONSES]
    return fmean(abs(off.percent) for off in offs if off is not None)


def names_upper_density_bound(record: Record) -> bool:
    """Whether a result says that the upper bound of the density is in the way, or is the answer."""
    bound: Sequence[dict[str, Any]] = record["out_of_reach"]
    if any(miss["parameter"] == DENSITY and miss["bound"] == "max" for miss in bound):
        return True
    words = tuple(f"{DENSITY} {verb} its bound max" for verb in ("lies on", "agrees up to"))
    return any(notice.startswith(words) for notice in record["notices"])


def proposed_density(record: Record) -> float | None:
    """Upper bound of the density that a result proposes for the bulk density's sake."""
    for miss in record["out_of_reach"]:
        if (miss["target"], miss["parameter"], miss["bound"]) == (BULK_DENSITY, DENSITY, "max"):
            suggestion: float | None = miss["suggestion"]
            return suggestion
    return None


def parameter_errors(cases: Sequence[Recovered]) -> dict[str, list[float]]:
    """Absolute deviations of the recovered parameters, %, by parameter, in ascending order."""
    return {
        name: sorted(abs(case.parameter_error(name)) for case in cases)
        for name in (DENSITY, ROLLING_FRICTION)
    }
