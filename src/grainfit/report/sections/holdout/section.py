"""Hold-outs: how well the calibration predicts tests that took no part in the fit."""

from __future__ import annotations

from dataclasses import dataclass

from grainfit.formatting import plain
from grainfit.plots.holdout_figures import holdout_figures, holdout_label
from grainfit.report.rendering import fill_template
from grainfit.report.section import ReportContext, Section
from grainfit.result import HoldoutCurve, HoldoutResponse, HoldoutResult, Registration

_KEY, _TITLE = "holdout", "Tests that were not fitted"
_MARKS = {"predicts": "good", "does not predict": "bad", "does not tell": "warn"}
_SIGNS = {"good": "✓", "bad": "✗", "warn": "!"}


@dataclass(frozen=True)
class HoldoutRow:
    """A predicted response in words, with its verdict and its figure."""

    heading: str
    grade: str
    mark: str
    words: str
    figure: str


@dataclass(frozen=True)
class ShownHoldout:
    """A hold-out: its responses, what else is to be said, and its registration."""

    test: str
    rows: tuple[HoldoutRow, ...]
    notes: tuple[str, ...]
    registration: Registration | None


def holdout(context: ReportContext) -> Section | None:
    """Each hold-out with its prediction; None without any."""
    result = context.reading.result
    if result is None or not result.holdouts:
        return None
    drawn = holdout_figures(result)
    keys = {place: f"{_KEY}-{number}" for number, place in enumerate(drawn)}
    shown = [_shown(one, keys) for one in result.holdouts]
    html = fill_template(f"{_KEY}/page", holdouts=shown)
    return Section(_KEY, _TITLE, html, {keys[place]: figure for place, figure in drawn.items()})


def _shown(one: HoldoutResult, keys: dict[tuple[str, str], str]) -> ShownHoldout:
    rows = tuple(
        _row(one.test, name, found, keys[one.test, name]) for name, found in one.predictions.items()
    )
    notes = tuple(map(plain, one.sentences()))[len(rows) :]
    return ShownHoldout(plain(one.test), rows, notes, one.registration)


def _row(test: str, name: str, found: HoldoutResponse | HoldoutCurve, figure: str) -> HoldoutRow:
    label = holdout_label(test, name, found)
    grade = _MARKS[found.verdict] if found.verdict else ""
    mark = f"{_SIGNS[grade]} {found.verdict}" if grade else ""
    words = plain(found.in_words(label.name))
    return HoldoutRow(plain(label.name), grade, mark, words, figure)
