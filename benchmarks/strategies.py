"""Compare calibration methods: distance of the answer from the truth after a number of DEM runs.

All of them calibrate the problems of `calibration_problems.py`, where every run is noisy and the
truth is known, with the same numbers of runs and the same seeds. Per problem:

* the true relative deviation of every expected response at the answer after n runs;
* the share of calibrations whose answer is truly within one and within two tolerances;
* the runs until the answer is truly within all tolerances for the first time;
* of the sequential strategy: where it stops by itself, and whether its statements there are true.

`staged` has two figures. At n runs: calibrations that were given a budget of n. Runs until within
tolerance: as the method prescribes, with a design of 13 runs per parameter, until its own end.

The limit is the deviation of the mean of n runs that are all made at the right place.

The other methods are those of `peers.py`, which lists their packages. A figure needs `plotly`, and
`kaleido` with a Chrome or Chromium for PNG.

    python benchmarks/strategies.py [--calibrations N] [--processes 2] [--json PATH] [--figure PATH]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from threadpoolctl import threadpool_limits

from calibration_problems import CASES, Case
from grainfit.evaluation import Evaluation, Proposal, Response
from grainfit.strategies.answer import Answer
from grainfit.strategies.base import Search
from grainfit.strategies.sequential.strategy import Sequential
from grainfit.strategies.staged.strategy import Staged
from peers import PEERS

Kind = TypeVar("Kind")
Parameters = dict[str, float]
#: Case, method and seed of a calibration.
Job = tuple[str, str, int]
#: Plain data: the outcome of one calibration, those of all, and statistics of them.
Record = dict[str, Any]
Figures = dict[str, Any]
Summary = dict[str, Any]

OURS, STAGED = "sequential", "staged"
METHODS = (OURS, STAGED, *PEERS)
#: Numbers of runs after which answers are compared; the last one is the budget.
CHECKPOINTS = {
    "heap, +-33 %": (8, 10, 12, 16, 20, 26, 36),
    "heap, +-66 %": (8, 10, 12, 16, 20, 26, 36),
    "heap, four parameters": (10, 12, 16, 20, 26, 36, 48),
    "analytic, six parameters": (12, 16, 26, 36, 48),
}
#: Numbers of runs after which the stated intervals are evaluated.
COVERAGE_AT = (16, 36)
#: Standard errors to each side of a 95 % interval; median and 90th percentile of |z|.
INTERVAL, MEDIAN_OF_NOISE, P90_OF_NOISE = 1.96, 0.6745, 1.645
SECONDS_BETWEEN_REPORTS = 5.0


# One calibration ----------------------------------------------------------------------------


def calibrate(name: str, method: str, seed: int) -> Record:
    """Calibrate a case with a method and evaluate the answers."""
    case, checkpoints = CASES[name](seed), CHECKPOINTS[name]
    start = time.perf_counter()
    if method == OURS:
        record = _sequential(case, checkpoints, seed)
    elif method == STAGED:
        record = _staged(case, checkpoints, seed)
    else:
        record = _scored(case, checkpoints, PEERS[method](case, checkpoints[-1], seed))
    return {"seed": seed, "seconds": _rounded(time.perf_counter() - start)} | record


def _sequential(case: Case, checkpoints: Sequence[int], seed: int) -> Record:
    """Use the whole budget; where the search would stop by itself is evaluated separately."""
    never_sure_enough = Sequential(confidence=1.0)
    search = never_sure_enough.start(case.problem, seed, checkpoints[-1])
    answers = list(_answers(case, search))
    record = _scored(case, checkpoints, [_parameters(answer) for answer in answers])
    record["covered"] = [
        None if answer is None else _covered(case, answer)
        for answer in (_after(answers, n) for n in checkpoints)
    ]
    return record | {"own_stop": _own_stop(case, seed)}


def _own_stop(case: Case, seed: int) -> Record:
    """Return statements of the sequential strategy where it stops by itself, and the truth."""
    search = Sequential().start(case.problem, seed)
    runs = sum(1 for _ in _runs(case, search))
    answer = search.answer()
    off = np.abs(case.expected(answer.parameters) - case.targets) / case.tolerances
    return {
        "runs": runs,
        "deviations": _all_rounded(case.deviations(answer.parameters)),
        "tolerances_off": _all_rounded(off),
        "covered": _covered(case, answer),
        "probability_all_met": _rounded(answer.probability_all_met),
        "out_of_reach": [miss.target for miss in answer.out_of_reach],
    }


def _staged(case: Case, checkpoints: Sequence[int], seed: int) -> Record:
    # Answers after the first one within tolerance are not needed.
    first = _first_within(
        case, map(_parameters, _answers(case, Staged().start(case.problem, seed)))
    )
    at_their_ends = [_last_answer(case, Staged().start(case.problem, seed, n)) for n in checkpoints]
    deviations = _deviations(case, [_parameters(answer) for answer in at_their_ends])
    return {"within_tolerance_after": first} | deviations


def _runs(case: Case, search: Search) -> Iterator[None]:
    """Make the runs of a strategy one at a time, until it ends."""
    while (proposal := search.ask()) is not None:
        search.tell(proposal, _evaluation(case, proposal))
        yield


def _evaluation(case: Case, proposal: Proposal) -> Evaluation:
    values = case.simulate(proposal.parameters, proposal.seed).tolist()
    names = [target.name for target in case.problem.targets]
    return Evaluation(proposal, {n: Response(v) for n, v in zip(names, values, strict=True)})


def _answers(case: Case, search: Search) -> Iterator[Answer | None]:
    """Yield the answers after 1, 2, ... runs; None while the design is under way."""
    for n, _ in enumerate(_runs(case, search), 1):
        yield search.answer() if n >= search.design_runs else None


def _last_answer(case: Case, search: Search) -> Answer:
    for _ in _runs(case, search):
        pass
    return search.answer()


def _parameters(answer: Answer | None) -> Parameters | None:
    return None if answer is None else dict(answer.parameters)


def _after(answers: Sequence[Kind], n: int) -> Kind:
    """Return the answer after n runs; the last one if there are fewer."""
    return answers[min(n, len(answers)) - 1]


def _scored(case: Case, checkpoints: Sequence[int], answers: Sequence[Parameters | None]) -> Record:
    at_checkpoints = [_after(answers, n) for n in checkpoints]
    first = {"within_tolerance_after": _first_within(case, answers)}
    return first | _deviations(case, at_checkpoints)


def _deviations(case: Case, answers: Sequence[Parameters | None]) -> Record:
    """Return true deviations, None where there is no answer."""
    return {
        "deviations": [a and _all_rounded(case.deviations(a)) for a in answers],
        "tolerances_off": [a and _rounded(case.tolerances_off(a)) for a in answers],
    }


def _first_within(case: Case, answers: Iterable[Parameters | None]) -> int | None:
    for n, answer in enumerate(answers, 1):
        if answer is not None and case.tolerances_off(answer) <= 1:
            return n
    return None


def _covered(case: Case, answer: Answer) -> list[bool]:
    """Return whether each stated 95 % interval contains the true expected response."""
    expected = case.expected(answer.parameters)
    return [
        bool(abs(true - answer.predicted[t.name]) <= INTERVAL * answer.standard_errors[t.name])
        for true, t in zip(expected, case.problem.targets, strict=True)
    ]


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def _all_rounded(values: Sequence[float] | np.ndarray) -> list[float]:
    return [_rounded(value) for value in values]


# All calibrations ---------------------------------------------------------------------------


def measure(
    cases: Sequence[str],
    methods: Sequence[str],
    calibrations: int,
    processes: int,
    kept: Path | None,
) -> Figures:
    """Calibrate every case with every method and seeds 1, 2, ...: plain data.

    Calibrations in the file ``kept`` are not repeated, and new ones are added to it at once.
    """
    seeds = range(1, calibrations + 1)
    with ProcessPoolExecutor(processes, initializer=_use_one_thread) as pool:
        taking_part = _available(pool, methods)
        # Seed by seed, so that the time left can be estimated from the share that is done.
        jobs = [(c, m, seed) for seed in seeds for c in cases for m in taking_part]
        records = _collect(pool, jobs, kept)
    return {
        name: _case_facts(name, seeds)
        | {"methods": {m: [records[name, m, seed] for seed in seeds] for m in taking_part}}
        for name in cases
    }


def _case_facts(name: str, seeds: Sequence[int]) -> Figures:
    cases = [CASES[name](seed) for seed in seeds]
    return {
        "checkpoints": list(CHECKPOINTS[name]),
        "responses": [target.name for target in cases[0].problem.targets],
        "relative_noise": [_all_rounded(case.noise / case.targets) for case in cases],
    }


def _use_one_thread() -> None:
    threadpool_limits(limits=1)


def _available(pool: ProcessPoolExecutor, methods: Sequence[str]) -> list[str]:
    """Return the methods whose packages are installed."""
    found = []
    for method, missing in zip(methods, pool.map(_why_missing, methods), strict=True):
        if missing:
            print(f"Left out: {method} ({missing}).", file=sys.stderr)
        else:
            found.append(method)
    return found


def _why_missing(method: str) -> str | None:
    if method not in PEERS:
        return None
    try:
        PEERS[method](next(iter(CASES.values()))(1), 8, 1)
    except ImportError as missing:
        return str(missing).rstrip(".")
    return None


def _collect(
    pool: ProcessPoolExecutor, jobs: Sequence[Job], kept: Path | None
) -> dict[Job, Record]:
    """Return the results of all jobs; print a line of progress regularly."""
    start = time.monotonic()
    records = _read_kept(kept)
    known = len(records)
    asked = {pool.submit(calibrate, *job): job for job in jobs if job not in records}
    pending = set(asked)
    try:
        while pending:
            done, pending = wait(pending, timeout=SECONDS_BETWEEN_REPORTS)
            new = {asked[future]: future.result() for future in done}
            _keep(new, kept)
            records |= new
            _report(len(records) - known, len(asked), time.monotonic() - start)
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    return records


def _read_kept(kept: Path | None) -> dict[Job, Record]:
    if kept is None or not kept.exists():
        return {}
    lines = [json.loads(line) for line in kept.read_text().splitlines()]
    return {
        (line["case"], line["method"], line["record"]["seed"]): line["record"] for line in lines
    }


def _keep(records: dict[Job, Record], kept: Path | None) -> None:
    if kept is None:
        return
    with kept.open("a") as file:
        for (case, method, _), record in records.items():
            file.write(json.dumps({"case": case, "method": method, "record": record}) + "\n")


def _report(done: int, jobs: int, seconds: float) -> None:
    left = f", about {seconds / done * (jobs - done) / 60:.0f} min left" if done else ""
    text = f"{done:,} of {jobs:,} calibrations after {seconds / 60:.1f} min{left}"
    print(text, file=sys.stderr, flush=True)


# Statistics ---------------------------------------------------------------------------------


def quantile(values: Sequence[float], share: float) -> float:
    """Return a quantile of values that may be infinite."""
    ordered = sorted(values)
    position = share * (len(ordered) - 1)
    low, high = ordered[math.floor(position)], ordered[math.ceil(position)]
    return high if math.isinf(high) else low + (high - low) * (position % 1)


def _median_and_p90(values: Sequence[float]) -> dict[str, float]:
    return {"median": quantile(values, 0.5), "p90": quantile(values, 0.9)}


def _or_infinite(value: float | None) -> float:
    return math.inf if value is None else value


def summarise(figures: Figures) -> Summary:
    """Return the statistics of the calibrations, by case and method."""
    return {name: _summary_of_case(of_case) for name, of_case in figures.items()}


def _summary_of_case(of_case: Figures) -> Summary:
    responses, checkpoints = of_case["responses"], of_case["checkpoints"]
    methods = of_case["methods"]
    summary = {
        "calibrations": len(of_case["relative_noise"]),
        "checkpoints": checkpoints,
        "limit": _limit(of_case),
        "methods": {
            method: _summary_of_method(records, responses, len(checkpoints))
            for method, records in methods.items()
        },
    }
    if OURS in methods:
        summary["own_stop"] = _summary_of_own_stops(methods[OURS], responses)
        summary["coverage"] = {
            str(n): _coverage(
                [record["covered"][checkpoints.index(n)] for record in methods[OURS]], responses
            )
            for n in COVERAGE_AT
        }
    return summary


def _limit(of_case: Figures) -> Summary:
    """Return deviations of the mean of n runs that are all made at the right place."""
    noise = np.median(of_case["relative_noise"], axis=0)
    root = np.sqrt(of_case["checkpoints"])
    return {
        response: {
            "median": (MEDIAN_OF_NOISE * sigma / root).tolist(),
            "p90": (P90_OF_NOISE * sigma / root).tolist(),
        }
        for response, sigma in zip(of_case["responses"], noise, strict=True)
    }


def _summary_of_method(records: list[Record], responses: list[str], checkpoints: int) -> Summary:
    off = [
        [_or_infinite(record["tolerances_off"][at]) for record in records]
        for at in range(checkpoints)
    ]
    runs = [_or_infinite(record["within_tolerance_after"]) for record in records]
    return {
        "deviations": {
            response: _deviations_of_response(records, number, checkpoints)
            for number, response in enumerate(responses)
        },
        "within_1_tolerance": [float(np.mean(np.array(at) <= 1)) for at in off],
        "within_2_tolerances": [float(np.mean(np.array(at) <= 2)) for at in off],
        "runs_to_tolerance": _median_and_p90(runs) | {"never": sum(map(math.isinf, runs))},
        "seconds": quantile([record["seconds"] for record in records], 0.5),
    }


def _deviations_of_response(records: list[Record], number: int, checkpoints: int) -> Summary:
    found = [
        _median_and_p90(
            [_or_infinite((r["deviations"][at] or {number: None})[number]) for r in records]
        )
        for at in range(checkpoints)
    ]
    return {key: [at[key] for at in found] for key in ("median", "p90")}


def _summary_of_own_stops(records: list[Record], responses: list[str]) -> Summary:
    stops = [record["own_stop"] for record in records]
    return {
        "runs": _median_and_p90([stop["runs"] for stop in stops]),
        "within_tolerance": float(np.mean([max(stop["tolerances_off"]) <= 1 for stop in stops])),
        "stated_probability": float(np.mean([stop["probability_all_met"] for stop in stops])),
        "out_of_reach": sum(bool(stop["out_of_reach"]) for stop in stops),
        "coverage": _coverage([stop["covered"] for stop in stops], responses),
    }


def _coverage(covered: list[list[bool] | None], responses: list[str]) -> dict[str, float]:
    """Return the shares of intervals that contain the truth, by response and of all."""
    known = np.array([of_one for of_one in covered if of_one is not None], dtype=float)
    by_response = dict(zip(responses, known.mean(axis=0).tolist(), strict=True))
    return by_response | {"all": float(known.mean())}


# The goals ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Goal:
    """A goal in words, whether it was met, and the measured values."""

    text: str
    met: bool
    measured: str


HEAPS = ("heap, +-33 %", "heap, +-66 %")
MANY_PARAMETERS = ("heap, four parameters", "analytic, six parameters")
#: Median and 90th percentile of the deviation, by number of runs and response.
DEVIATION_GOALS = {
    (16, "angle_of_repose"): (0.010, 0.023),
    (16, "bulk_density"): (0.0012, 0.003),
    (36, "angle_of_repose"): (0.006, 0.015),
}
#: Factors of runs saved against the staged strategy and against the best other method.
FEWER_RUNS_THAN_STAGED, FEWER_RUNS_THAN_OTHERS = 2.0, 1.5
COVERAGE_GOAL = (0.90, 0.99)


def judge(summary: Summary) -> list[Goal]:
    """Return the goals of the sequential strategy, as far as they were measured."""
    goals: list[Goal] = []
    for name, case in summary.items():
        if OURS not in case["methods"]:
            continue
        if name in HEAPS:
            goals += [*_deviation_goals(name, case), *_goals_against_peers(name, case)]
        if name in MANY_PARAMETERS:
            goals += _goals_of_runs(name, case)
        goals.append(_coverage_goal(name, case))
    return goals


def _at(case: Summary, method: str, response: str, n: int) -> tuple[float, float]:
    """Return median and 90th percentile of the deviation after n runs."""
    found = case["methods"][method]["deviations"][response]
    at = case["checkpoints"].index(n)
    return found["median"][at], found["p90"][at]


def _deviation_goals(name: str, case: Summary) -> Iterator[Goal]:
    for (n, response), (median, p90) in DEVIATION_GOALS.items():
        found = _at(case, OURS, response, n)
        yield Goal(
            f"{name}: {response} at {n} runs: median <= {percent(median)} %, "
            f"90th percentile <= {percent(p90)} %",
            found[0] <= median and found[1] <= p90,
            f"{percent(found[0])} %, {percent(found[1])} %",
        )


def _goals_against_peers(name: str, case: Summary) -> Iterator[Goal]:
    others = [method for method in case["methods"] if method != OURS]
    for n in (16, 36) if others else ():
        for response in case["limit"]:
            found = {method: _at(case, method, response, n) for method in case["methods"]}
            best = [min(others, key=lambda m, k=k, f=found: f[m][k]) for k in (0, 1)]
            yield Goal(
                f"{name}: {response} at {n} runs: nearer than all others, median and 90th "
                "percentile",
                all(found[OURS][k] < found[best[k]][k] for k in (0, 1)),
                "; ".join(
                    f"{percent(found[OURS][k])} %, best other {percent(found[best[k]][k])} % "
                    f"({best[k]})"
                    for k in (0, 1)
                ),
            )


def _goals_of_runs(name: str, case: Summary) -> Iterator[Goal]:
    needed = {method: found["runs_to_tolerance"] for method, found in case["methods"].items()}
    ours = needed.pop(OURS)
    staged = {STAGED: needed.pop(STAGED)} if STAGED in needed else {}
    for others, factor in ((staged, FEWER_RUNS_THAN_STAGED), (needed, FEWER_RUNS_THAN_OTHERS)):
        if others:
            yield _goal_of_fewer_runs(name, ours, others, factor)
    yield Goal(
        f"{name}: every calibration gets within tolerance",
        ours["never"] == 0,
        f"{ours['never']} of {case['calibrations']} do not",
    )


def _goal_of_fewer_runs(name: str, ours: Summary, others: Summary, factor: float) -> Goal:
    best = {key: min(others, key=lambda method: others[method][key]) for key in ("median", "p90")}
    whom = STAGED if STAGED in others else "the best other"
    return Goal(
        f"{name}: {factor:g} times fewer runs to tolerance than {whom}, median and 90th percentile",
        # An infinite number of own runs is not fewer than another infinite number.
        all(
            math.isfinite(ours[key]) and others[best[key]][key] >= factor * ours[key]
            for key in best
        ),
        "; ".join(
            f"{_or_never(ours[key])} against {_or_never(others[best[key]][key])} ({best[key]})"
            for key in best
        ),
    )


def _or_never(runs: float) -> str:
    return "never" if math.isinf(runs) else f"{runs:g}"


def _coverage_goal(name: str, case: Summary) -> Goal:
    low, high = COVERAGE_GOAL
    share = case["own_stop"]["coverage"]["all"]
    return Goal(
        f"{name}: coverage of the stated 95 % intervals at its own answer {low:.0%} to {high:.0%}",
        low <= share <= high,
        f"{share:.1%}",
    )


# Printing -----------------------------------------------------------------------------------


def percent(share: float) -> str:
    """Format a share in percent, with three digits."""
    return "-" if math.isinf(share) else f"{100 * share:#.3g}".rstrip(".")


def print_report(summary: Summary) -> None:
    for name, case in summary.items():
        print(f"\n## {name} (calibrations: {case['calibrations']})")
        for response in case["limit"]:
            _print_deviations(case, response)
        _print_shares(case)
        _print_runs(case)
        if "own_stop" in case:
            _print_own_stop(case)
    print("\n## Goals\n")
    for goal in judge(summary):
        print(f"{'met    ' if goal.met else 'NOT MET'}  {goal.text}: {goal.measured}")


def _print_table(head: Sequence[object], rows: dict[str, list[str]]) -> None:
    print(f"\n| | {' | '.join(map(str, head))} |")
    print("|---" * (len(head) + 1) + "|")
    for name, cells in rows.items():
        print(f"| {name} | {' | '.join(cells)} |")


def _print_deviations(case: Summary, response: str) -> None:
    def cells(found: Summary) -> list[str]:
        pairs = zip(found["median"], found["p90"], strict=True)
        return [f"{percent(median)} / {percent(p90)}" for median, p90 in pairs]

    print(f"\nDeviation of {response} after n runs, %: median / 90th percentile")
    rows = {m: cells(found["deviations"][response]) for m, found in case["methods"].items()}
    limit = {"limit: n runs at the right place": cells(case["limit"][response])}
    _print_table(case["checkpoints"], rows | limit)


def _print_shares(case: Summary) -> None:
    print("\nCalibrations within 1 / within 2 tolerances after n runs, %")
    rows = {}
    for method, found in case["methods"].items():
        pairs = zip(found["within_1_tolerance"], found["within_2_tolerances"], strict=True)
        rows[method] = [f"{100 * one:.0f} / {100 * two:.0f}" for one, two in pairs]
    _print_table(case["checkpoints"], rows)


def _print_runs(case: Summary) -> None:
    print("\nRuns until within all tolerances; staged as prescribed, to its own end")
    rows = {}
    for method, found in case["methods"].items():
        beyond = "> its end" if method == STAGED else f"> {case['checkpoints'][-1]}"
        needed = found["runs_to_tolerance"]
        shown = [
            beyond if math.isinf(needed[key]) else f"{needed[key]:g}" for key in ("median", "p90")
        ]
        rows[method] = [*shown, str(needed["never"])]
    _print_table(("median", "90th percentile", "never"), rows)


def _print_own_stop(case: Summary) -> None:
    stop, runs = case["own_stop"], case["own_stop"]["runs"]
    print(
        f"\n{OURS} by itself stops after {runs['median']:g} runs (90th percentile "
        f"{runs['p90']:g}), truly within tolerance: {stop['within_tolerance']:.0%}, stated: "
        f"{stop['stated_probability']:.0%} on average; called out of reach: {stop['out_of_reach']}."
    )
    print("\nCoverage of its stated 95 % intervals, %")
    places = {"at its own stop": stop["coverage"]} | {
        f"after {n} runs": found for n, found in case["coverage"].items()
    }
    rows = {
        place: [f"{100 * share:.0f}" for share in found.values()] for place, found in places.items()
    }
    _print_table(list(stop["coverage"]), rows)


# The command --------------------------------------------------------------------------------


def _chosen(names: Sequence[str]) -> Callable[[str], list[str]]:
    """Return a parser that finds the names that contain a text."""

    def choose(text: str) -> list[str]:
        found = [name for name in names if text.lower() in name.lower()]
        if not found:
            raise argparse.ArgumentTypeError(f"{text!r} is in none of: {'; '.join(names)}")
        return found

    return choose


def _in_order(names: Sequence[str], chosen: Sequence[Sequence[str]] | None) -> list[str]:
    return [name for name in names if chosen is None or any(name in part for part in chosen)]


def _at_least_one(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 1")
    return int(text)


def _file_to_write(text: str) -> Path:
    if not Path(text).parent.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {Path(text).parent}")
    return Path(text)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--calibrations",
        type=_at_least_one,
        default=100,
        metavar="N",
        help="calibrations of each case with each method, with targets and seeds of their own "
        "(default: 100; the peers were configured with seeds from 101 on)",
    )
    parser.add_argument(
        "--processes",
        type=_at_least_one,
        default=2,
        metavar="N",
        help="calibrations at the same time, one thread each (default: 2)",
    )
    for option, names in (("--cases", tuple(CASES)), ("--methods", METHODS)):
        parser.add_argument(
            option,
            nargs="+",
            type=_chosen(names),
            metavar="TEXT",
            help="only those with one of these texts in their name, of: "
            # To argparse, a single % begins a placeholder.
            + "; ".join(names).replace("%", "%%"),
        )
    parser.add_argument(
        "--json",
        type=_file_to_write,
        metavar="PATH",
        help="write all figures to this file, those of each calibration too",
    )
    parser.add_argument(
        "--keep",
        type=_file_to_write,
        metavar="PATH",
        help="add every finished calibration to this file, and repeat none that is in it",
    )
    parser.add_argument(
        "--from-json",
        type=Path,
        metavar="PATH",
        help="measure nothing: print and draw the figures that an earlier --json wrote",
    )
    parser.add_argument(
        "--figure",
        type=_file_to_write,
        metavar="PATH",
        help="draw deviation against number of runs: a self-contained .html file, or .png",
    )
    return parser.parse_args()


def _plain(data: Any) -> Any:
    """Replace infinities by None, because JSON has none."""
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_plain(value) for value in data]
    return None if isinstance(data, float) and math.isinf(data) else data


def _write_json(path: Path, figures: Figures, summary: Summary) -> None:
    goals = [vars(goal) for goal in judge(summary)]
    content = {"goals": goals, "summary": _plain(summary), "calibrations": figures}
    path.write_text(json.dumps(content) + "\n")


def main() -> None:
    arguments = _arguments()
    if arguments.figure:
        # A missing package is reported before the long measurement.
        try:
            import strategies_figure
        except ImportError as missing:
            raise SystemExit(f"--figure needs plotly: pip install plotly ({missing}).") from None
    if arguments.from_json:
        figures = json.loads(arguments.from_json.read_text())["calibrations"]
    else:
        figures = measure(
            _in_order(tuple(CASES), arguments.cases),
            _in_order(METHODS, arguments.methods),
            arguments.calibrations,
            arguments.processes,
            arguments.keep,
        )
    summary = summarise(figures)
    if arguments.json:
        _write_json(arguments.json, figures, summary)
    if arguments.figure:
        strategies_figure.draw(summary, arguments.figure)
    print_report(summary)


if __name__ == "__main__":
    main()
