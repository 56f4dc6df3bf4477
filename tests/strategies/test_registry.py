"""Strategies by name, from other packages too, and what is said of options that make no sense."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from grainfit import InputError, Parameter, Problem, Sequential, Staged, Strategy, Target
from grainfit.strategies import messages
from grainfit.strategies.budget import start_search
from grainfit.strategies.registry import (
    DEFAULT_STRATEGY,
    as_strategy,
    changed,
    make_strategy,
    strategies,
)

PROBLEM = Problem([Parameter("friction", 0.1, 0.9)], [Target("angle", 30.0)])


@pytest.mark.parametrize(
    ("name", "options", "strategy"),
    [
        ("sequential", {}, Sequential()),
        (
            "sequential",
            {"design_runs": 12, "prefer": "accuracy", "extend_intervals": True},
            Sequential(design_runs=12, prefer="accuracy", extend_intervals=True),
        ),
        ("sequential", {"confidence": 0.99}, Sequential(confidence=0.99)),
        ("sequential", {"prefer": None}, Sequential()),
        ("staged", {"design_runs": 26}, Staged(design_runs=26)),
    ],
)
def test_what_makes_sense_is_made(name: str, options: dict, strategy: Strategy) -> None:
    assert make_strategy(name, options) == strategy


@pytest.mark.parametrize(
    ("name", "options", "keys"),
    [
        ("bayesian", {}, ["strategy"]),
        ("Staged", {}, ["strategy"]),
        ("bayesian", {"prefer": "speed"}, ["strategy"]),
        ("sequential", {"prefer": "speed"}, ["prefer"]),
        ("sequential", {"extend_intervals": "yes"}, ["extend_intervals"]),
        ("sequential", {"confidence": 95, "design_runs": 7.5}, ["design_runs", "confidence"]),
        ("sequential", {"design_run": 7}, ["design_run"]),
        ("staged", {"prefer": "accuracy"}, ["prefer"]),
        ("staged", {"extend_intervals": False}, ["extend_intervals"]),
        (
            "staged",
            {"prefer": "time_step", "extend_intervals": True},
            ["prefer", "extend_intervals"],
        ),
    ],
)
def test_what_makes_no_sense_is_refused_by_its_key(
    name: str, options: dict, keys: list[str]
) -> None:
    with pytest.raises(InputError) as caught:
        make_strategy(name, options)
    assert [fault.key for fault in caught.value.faults] == keys
    assert all(fault.remedy for fault in caught.value.faults)


def test_unknown_names_are_answered_with_the_known_ones() -> None:
    with pytest.raises(InputError, match=messages.UNKNOWN_STRATEGY.pattern):
        make_strategy("bayesian", {})
    with pytest.raises(InputError, match="time_step, accuracy"):
        Sequential(prefer="speed")  # type: ignore[arg-type]
    use_it = messages.OPTION_OF_OTHERS(others='"sequential"')
    with pytest.raises(InputError, match=re.escape(use_it)):
        make_strategy("staged", {"prefer": "accuracy"})


def test_only_the_staged_strategy_takes_a_rayleigh_weight() -> None:
    Sequential().check_rayleigh_weight(0.0)
    Staged().check_rayleigh_weight(0.1)
    with pytest.raises(InputError, match=messages.FOREIGN_WEIGHT.pattern):
        Sequential().check_rayleigh_weight(0.1)


def test_a_strategy_is_given_by_name_or_as_an_object() -> None:
    assert DEFAULT_STRATEGY == "sequential"
    assert as_strategy("staged") == Staged()
    mine = Sequential(prefer="accuracy")
    assert as_strategy(mine) is mine
    for wrong in (None, 3, Sequential):
        with pytest.raises(InputError, match=messages.NO_STRATEGY.pattern):
            as_strategy(wrong)


def test_a_search_has_the_options_the_seed_and_the_budget_it_was_started_with() -> None:
    strategy = Sequential(design_runs=7, prefer="accuracy", extend_intervals=True)
    search = strategy.start(PROBLEM, 3, 20)
    assert (search.design_runs, search.seed, search.max_evaluations) == (7, 3, 20)
    assert search.strategy is strategy
    assert Staged(design_runs=9).start(PROBLEM, 3).design_runs == 9


@pytest.mark.parametrize(
    ("strategy", "definition"),
    [
        (
            Sequential(),
            {
                "design_runs": 4,
                "prefer": "time_step",
                "extend_intervals": False,
                "confidence": 0.95,
            },
        ),
        (Staged(), {"design_runs": 13, "max_evaluations": 20}),
    ],
)
def test_the_definition_is_that_of_the_first_release(strategy: Strategy, definition: dict) -> None:
    # It is part of the identity of a calibration: with another one, none could be resumed.
    assert strategy.start(PROBLEM, 1, 20).definition == definition


def test_what_is_changed_wins_and_the_rest_stays() -> None:
    strategy = Sequential(design_runs=8, prefer="accuracy")
    assert changed(strategy, None, {}) == strategy
    assert changed(strategy, None, {"prefer": "time_step"}) == Sequential(design_runs=8)
    assert changed(Sequential(design_runs=8), "staged", {}) == Staged(design_runs=8)
    with pytest.raises(InputError, match=messages.FOREIGN_OPTION.pattern):
        changed(strategy, "staged", {})


def test_a_budget_of_runs_is_shared_by_the_tests_and_keeps_room_for_the_verification() -> None:
    search = start_search(Sequential(), PROBLEM, 2, 1, 31, 3)
    assert search.max_evaluations == 31 // 2 - 3
    with pytest.raises(InputError, match=messages.BUDGET_TOO_SMALL.pattern):
        start_search(Sequential(), PROBLEM, 2, 1, 13, 3)
    assert start_search(Sequential(), PROBLEM, 2, 1, 14, 3).max_evaluations == 4


# Strategies of other packages ----------------------------------------------------------------


_MODULE = """
from dataclasses import dataclass
from typing import ClassVar

from grainfit import Sequential, Strategy
from grainfit.options.fields import option
from grainfit.options.kinds import Whole


@dataclass(frozen=True)
class Patient(Sequential):
    name: ClassVar[str] = "patient"
    naps: int = option(Whole(0, 9), "Naps between runs.", default=1, example="2")


class Unfinished(Strategy):
    pass
"""


def _package(folder: Path, entry_points: str) -> None:
    (folder / "patience.py").write_text(_MODULE)
    about = folder / "patience-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: patience\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[grainfit.strategies]\n{entry_points}\n")


def _python(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(folder), *sys.path])
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": path, "COLUMNS": "200"},
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_a_strategy_of_another_package_is_in_file_schema_and_help(tmp_path: Path) -> None:
    _package(tmp_path, "patient = patience:Patient")
    code = """
from grainfit.calibration_file.schema import calibration_file_schema
from grainfit.cli.app import app
from grainfit.strategies.registry import make_strategy
keys = calibration_file_schema()["properties"]["strategy"]["properties"]
print(keys["name"]["enum"], keys["naps"])
print(make_strategy("patient", {"naps": 3}))
app(["run", "--help"])
"""
    done = _python(tmp_path, code)
    assert done.returncode == 0, done.stderr
    assert "['sequential', 'staged', 'patient'] {'description': 'Naps between runs." in done.stdout
    assert "Patient(naps=3)" in done.stdout
    assert "--naps" in done.stdout


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ("broken = patience:Impatient", "Impatient"),
        ("broken = patience:Patient", messages.OTHER_NAME(name="patient")),
        ("broken = patience:Unfinished", "is incomplete: name is missing, start is missing"),
        ("broken = patience:option", messages.NO_SUBCLASS()),
        ("staged = patience:Patient", messages.NAME_TAKEN()),
    ],
)
def test_one_that_cannot_be_used_is_left_out_with_a_warning(
    tmp_path: Path, entry: str, why: str
) -> None:
    _package(tmp_path, entry)
    code = "from grainfit.strategies.registry import strategies; print(list(strategies()))"
    done = _python(tmp_path, code)
    assert done.stdout == "['sequential', 'staged']\n"
    assert messages.LEFT_OUT.is_in(done.stderr)
    assert why in done.stderr


def test_the_built_in_names_are_those_of_their_classes() -> None:
    assert dict(strategies()) == {"sequential": Sequential, "staged": Staged}
