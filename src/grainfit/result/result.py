"""Result of a calibration: what was found, the verdict with its reasons, and what it took."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Any

from grainfit.errors import StoreError
from grainfit.files import LARGEST_RESULT, read_within, write_atomically
from grainfit.formatting import counted, number, plain_ends, plain_interval, plain_probability
from grainfit.one_line import OneLine
from grainfit.plain_data import parse_json, read_plain
from grainfit.result import messages as of_file
from grainfit.result.holdout import HoldoutResult, runs_of_holdouts
from grainfit.result.older_versions import in_current_names
from grainfit.result.parts import (
    CurveResult,
    MetamodelQuality,
    ParameterInterval,
    ResponseResult,
    RunCounts,
    RunSummary,
    YieldLocusResult,
)
from grainfit.tables import Summary, TextTable
from grainfit.verdict import messages
from grainfit.verdict.out_of_reach import OutOfReach
from grainfit.verdict.reasons import KINDS, Deterministic, NoRecordThere, Reason
from grainfit.verdict.rule import Status


@dataclass(frozen=True)
class Result(Summary, OneLine):
    """Result of a calibration.

    Parameters
    ----------
    status : str
        ``calibrated``: with the demanded probability (0.95 by default), every expected response is
        within its tolerance by all runs, and fresh seeds at the answer do not contradict it.
        ``out_of_tolerance``: with that probability, some expected response is not, at the best
        parameter set found, and one is beyond its tolerance. ``unreachable``: the same for every
        parameter set within the intervals.
        ``undecided``: the runs establish neither. ``predicted``: every target is met by smaller
        apparatus alone. ``interrupted``: it was stopped before its end.
    parameters : mapping of str to float
        The calibrated values, SI. Empty when interrupted before there was an answer.
    responses : mapping of str to ResponseResult
        By name of the target.
    runs : RunCounts
        Numbers of DEM runs.
    rayleigh_time_step : float, optional
        Rayleigh time step of the calibrated material, s.
    rayleigh_time_step_before : float, optional
        Rayleigh time step in the middle of the intervals, s.
    rayleigh_time_step_limits : pair of float, optional
        Smallest and largest Rayleigh time step within the intervals, s.
    wall_seconds : float
        Duration of this start, s.
    utilisation : float
        Share of the workers' time spent on simulations, in this start, from 0 to 1.
    probability_all_met : float, optional
        Probability, by the metamodels of all runs including the verification, that all expected
        responses are within their tolerances.
    name, identity, strategy, seed, version : str, str, str, int, str
        Name of the calibration, and all that is needed to repeat it.
    units : mapping of str to str
        Units of the parameters.
    out_of_reach : sequence of OutOfReach
        Targets that cannot be met within the intervals.
    metamodels : mapping of str to MetamodelQuality
        Quality of the metamodels, by name of the target.
    reasons : sequence of Reason
        Reasons for the verdict, with their numbers. A file of version 0.2.0 or older has them in
        words alone, among the other notices.
    other_notices : sequence of str
        Notices that are neither reasons for the verdict nor of what is out of reach, such as those
        of the search.
    history : sequence of RunSummary
        Every parameter set that was simulated, in order.
    intervals : mapping of str to ParameterInterval
        95 % intervals of the parameters, given all runs. Empty when these are too few, when no
        parameter set agrees with the measurements, or in a file of an older version.
    curves : mapping of str to CurveResult
        By name of the measured curve.
    yield_loci : sequence of YieldLocusResult
        One for each material that was sheared at two or more normal stresses.
    holdouts : sequence of HoldoutResult
        Predictions of tests that took no part in the fit.
    """

    status: Status
    parameters: Mapping[str, float]
    responses: Mapping[str, ResponseResult]
    runs: RunCounts
    rayleigh_time_step: float | None
    rayleigh_time_step_before: float | None
    rayleigh_time_step_limits: tuple[float, float] | None
    wall_seconds: float
    utilisation: float
    probability_all_met: float | None
    name: str
    identity: str
    strategy: str
    seed: int
    version: str
    units: Mapping[str, str] = field(default_factory=dict)
    out_of_reach: tuple[OutOfReach, ...] = ()
    metamodels: Mapping[str, MetamodelQuality] = field(default_factory=dict)
    reasons: tuple[Reason, ...] = ()
    other_notices: tuple[str, ...] = ()
    history: tuple[RunSummary, ...] = ()
    intervals: Mapping[str, ParameterInterval] = field(default_factory=dict)
    curves: Mapping[str, CurveResult] = field(default_factory=dict)
    yield_loci: tuple[YieldLocusResult, ...] = ()
    holdouts: tuple[HoldoutResult, ...] = ()

    @property
    def headline(self) -> str:
        """Name and status in words."""
        words = messages.STATUS_WORDS[self.status]
        return f"{self.name}: {words}" if self.name else words

    @property
    def notices(self) -> tuple[str, ...]:
        """Notices for the user: the reasons and what is out of reach in words, and the others."""
        return (*map(str, self.reasons), *map(str, self.out_of_reach), *self.other_notices)

    @property
    def sureness(self) -> str:
        """How probable it is that every target is met; "" where that is not known.

        Rows of a table at other parameters tell no probability.
        """
        read_elsewhere = any(isinstance(reason, NoRecordThere) for reason in self.reasons)
        if self.probability_all_met is None or read_elsewhere:
            return ""
        return messages.ALL_MET(probability=plain_probability(self.probability_all_met))

    def parameter_table(self) -> TextTable:
        """Return the calibrated values with their intervals, and how well they are determined."""
        rows = (self._parameter_cells(name, value) for name, value in self.parameters.items())
        header = ("parameter", "value", "95 % interval", "")
        biases = "; ".join(f"{name}: {i.bias}" for name, i in self.intervals.items() if i.bias)
        caption = f"Biased: {biases}" if biases else ""
        return TextTable(header, tuple(rows), caption if self.intervals else self._why_no_intervals)

    def _parameter_cells(self, name: str, value: float) -> tuple[str, ...]:
        shown, found = _with_unit(value, self.units.get(name, "")), self.intervals.get(name)
        if found is None:
            return (name, shown, "-", "")
        return (name, shown, plain_ends(found.low, found.high), found.determination)

    @property
    def _why_no_intervals(self) -> str:
        if self.status == "unreachable":
            return "No intervals: no parameter set agrees with the measurements."
        return "No intervals: there are too few runs, or an older version wrote the result."

    def response_table(self) -> TextTable:
        """Return each response: target, expected value, deviation and verdict."""
        rows = (_response_cells(name, found) for name, found in self.responses.items())
        caption = "± tolerance of the target, 95 % confidence of the expected response"
        return TextTable(("response", "target", "expected", "deviation", ""), tuple(rows), caption)

    def curve_table(self) -> TextTable:
        """Return each curve: measured points, components, deviation and verdict."""
        rows = (
            (
                name,
                f"{counted(len(found.measured), 'point')}",
                counted(found.components, "component"),
                f"{found.deviation:.2f} σ",
                found.verdict,
            )
            for name, found in self.curves.items()
        )
        caption = (
            "root mean square deviation of the expected curve, in standard uncertainties σ of the "
            "measured points"
        )
        return TextTable(("curve", "measured", "simulated", "deviation", ""), tuple(rows), caption)

    def tables(self) -> list[TextTable]:
        """Return the tables of parameters, responses and curves, without empty ones."""
        tables = [self.parameter_table()]
        if self.responses or not self.curves:
            tables.append(self.response_table())
        return [*tables, self.curve_table()] if self.curves else tables

    def fresh_seeds(self) -> str:
        """Return what the runs at the answer gave in a sentence; "" without any."""
        return " ".join(filter(None, [self._means_of_fresh_seeds(), self.single_runs()]))

    def single_runs(self) -> str:
        """Return what the one run at the answer of deterministic models gave; "" without any."""
        if not any(isinstance(reason, Deterministic) for reason in self.reasons):
            return ""
        found = [
            f"{name} {number(found.verified_values[0], 4)} {found.unit}".rstrip()
            for name, found in self.responses.items()
            if len(found.verified_values) == 1
        ]
        return f"Run at the answer: {', '.join(found)}." if found else ""

    def _means_of_fresh_seeds(self) -> str:
        means = [
            f"{name} {plain_interval(found.verified_mean, found.verified_interval)} "
            f"{found.unit}".rstrip()
            for name, found in self.responses.items()
            if found.verified_mean is not None and found.verified_interval is not None
        ]
        means += [f"{name} {found.fresh}" for name, found in self.curves.items() if found.fresh]
        if not means:
            return ""
        single = bool(self.single_runs())
        counts = [len(found.verified_values) for found in self.responses.values()]
        counts += [found.verified_runs for found in self.curves.values()]
        counts = [count for count in counts if not (single and count == 1)]
        fewest, most = min(counts), max(counts)
        seeds = counted(most, "fresh seed") if most else "fresh seeds"
        if fewest < most:
            # Each of several tests is verified by itself.
            seeds = f"{fewest} to {seeds}"
        return f"Mean of {seeds} at the answer: {', '.join(means)}."

    def summary(self) -> tuple[str | TextTable, ...]:
        """Return the sentences and tables that `print` and a notebook show."""
        parts: list[str | TextTable] = [self.headline, *self.notices]
        if self.parameters:
            parts += self.tables()
            parts += map(str, self.yield_loci)
        if check := self.fresh_seeds():
            parts.append(check)
        if self.sureness:
            parts.append(self.sureness)
        parts += map(str, self.holdouts)
        return (*parts, self.runs_in_words)

    @property
    def runs_in_words(self) -> str:
        """Numbers of the runs of the calibration and, apart from them, of its hold-outs."""
        own = f"DEM runs: {self.runs}."
        return " ".join(filter(None, [own, runs_of_holdouts(self.holdouts)]))

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data; ``notices`` begin with the reasons in words."""
        data = asdict(replace(self, reasons=()))
        data["reasons"] = [reason.to_json() for reason in self.reasons]
        del data["other_notices"]
        return data | {"notices": self.notices}

    def to_json(self, path: str | Path) -> None:
        """Write the result to a JSON file atomically."""
        write_atomically(
            Path(path),
            json.dumps(self.to_dict(), indent=2, ensure_ascii=False, allow_nan=False) + "\n",
        )

    @classmethod
    def from_json(cls, path: str | Path) -> Result:
        """Read a result that `to_json` wrote.

        Raises
        ------
        StoreError
            There is no such file, or its content is not a result: it was edited, or written by
            another version of grainfit.

        Examples
        --------
        >>> Result.from_json("beads.grainfit/result.json")  # doctest: +SKIP
        """
        try:
            return _read(read_within(Path(path), LARGEST_RESULT))
        except OSError as error:
            reason = error.strerror
            raise StoreError(of_file.UNREADABLE(path=str(path), reason=reason)) from error
        except (ValueError, RecursionError) as error:
            raise StoreError(damaged_result(path, str(error))) from error


def _response_cells(name: str, response: ResponseResult) -> tuple[str, ...]:
    expected, half_width = response.expected
    return (
        name,
        f"{response.target:.5g} ± {response.tolerance:.3g} {response.unit}".rstrip(),
        plain_interval(expected, half_width),
        response.deviation_in_words(response.unit),
        response.verdict,
    )


def _with_unit(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".rstrip() if isfinite(value) else "-"


def damaged_result(path: str | Path, why: str) -> str:
    """Return the message for a result that can no longer be read."""
    return of_file.DAMAGED(path=str(path), reason=why)


@dataclass(frozen=True)
class _InWords:
    """What a file has in another form than the result: kinds of reasons, and all notices."""

    reasons: tuple[_Kind, ...] = ()
    notices: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Kind:
    kind: str


def _read(text: bytes) -> Result:
    data = in_current_names(parse_json(text))
    found: _InWords = read_plain(_InWords, data)
    kinds = [KINDS.get(one.kind) for one in found.reasons]
    if len(found.notices) < len(kinds):
        raise ValueError("notices: have to begin with the reasons")
    result: Result = read_plain(Result, data | {"reasons": [], "other_notices": []})
    # A reason of a kind that only a later version knows stays as a notice.
    said = [text for text, kind in zip(found.notices, kinds, strict=False) if kind is None]
    misses = [str(miss) for miss in result.out_of_reach]
    said += [text for text in found.notices[len(kinds) :] if text not in misses]
    return replace(
        result,
        reasons=tuple(
            read_plain(kind, one, f"reasons.{place}")
            for place, (kind, one) in enumerate(zip(kinds, data.get("reasons", []), strict=True))
            if kind is not None
        ),
        other_notices=tuple(said),
    )
