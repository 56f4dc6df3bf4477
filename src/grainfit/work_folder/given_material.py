"""A material for the tests of a file: the answer of a calibration, a card, or values in a file."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from grainfit.calibration.holdout import Material
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.errors import Fault, InputError
from grainfit.files import LARGEST_RESULT, read_within
from grainfit.formatting import value_with_unit
from grainfit.plain_data import parse_json, read_plain
from grainfit.work_folder import messages
from grainfit.work_folder.saved_calibration import SavedCalibration, read_answer

_SETS = 1024


@dataclass(frozen=True)
class _Parameter:
    """Parameter of a material card; its interval where it has one."""

    name: str
    value: float
    interval_95: tuple[float, float] | None = None


@dataclass(frozen=True)
class _Card:
    parameters: tuple[_Parameter, ...]


def answer_for(
    setup: CalibrationSetup, saved: SavedCalibration, settings: Sequence[str]
) -> dict[str, float]:
    """Return the values of an answer, which are to be those of the parameters of a file.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration file.
    saved : SavedCalibration
        The calibration.
    settings : sequence of str
        ``NAME=VALUE``, of parameters that need no value in the answer.

    Raises
    ------
    InputError
        There is no answer yet, it has a parameter that the file does not know, or leaves a free
        one open.
    """
    answer, folder = read_answer(saved).parameters, str(saved.folder)
    known = {*setup.problem.middle, *setup.file.fixed}
    faults = [
        messages.NO_PARAMETER_OF_FILE.fault(name, folder=folder)
        for name in answer
        if name not in known
    ]
    faults += _open(setup, {*answer, *_names(settings)}, folder)
    InputError.raise_for(faults)
    return dict(answer)


def in_place_of_fixed(
    setup: CalibrationSetup, answer: Mapping[str, float], settings: Sequence[str]
) -> list[str]:
    """Return the parameters that the file fixes otherwise than the answer, in sentences."""
    fixed, given = setup.file.fixed, _names(settings)
    return [
        messages.IN_PLACE_OF_FIXED(
            name=name,
            value=value_with_unit(value, setup.quantity(name).unit or ""),
            fixed=value_with_unit(fixed[name], setup.quantity(name).unit or ""),
        )
        for name, value in answer.items()
        if name in fixed and name not in given and not isclose(fixed[name], value, rel_tol=1e-9)
    ]


def _names(settings: Sequence[str]) -> set[str]:
    return {setting.partition("=")[0].strip() for setting in settings}


def _open(setup: CalibrationSetup, known: set[str], source: str) -> list[Fault]:
    """Return the faults of free parameters that have no value."""
    return [
        messages.NO_VALUE_IN_ANSWER.fault(name, folder=source)
        for name in setup.problem.middle
        if name not in known
    ]


def material_of_file(setup: CalibrationSetup, path: Path, settings: Sequence[str]) -> Material:
    """Return the material in a file, for the tests of a calibration file.

    Parameters
    ----------
    setup : CalibrationSetup
        The calibration file: its free parameters need a value.
    path : Path
        A material card (JSON), or a TOML file with values by section and key.
    settings : sequence of str
        ``NAME=VALUE``, in place of those of the file.

    Raises
    ------
    InputError
        The file cannot be read, or leaves a free parameter open.
    """
    content = _read(path)
    given = _names(settings)
    values, intervals = (_of_toml if path.suffix == ".toml" else _of_card)(setup, content, path)
    InputError.raise_for(_open(setup, {*values, *given}, str(path)))
    values = setup.values(settings, values)
    exact = {name: (value, value) for name, value in values.items()}
    known = {name: ends for name, ends in intervals.items() if name not in given}
    ends = {name: known.get(name, exact[name]) for name in setup.problem.middle}
    corners = [{name: pair[end] for name, pair in ends.items()} for end in (0, 1)]
    problem = setup.problem.widened_to([values, *corners])
    low, high = (problem.to_unit(corner) for corner in corners)
    if np.all(low == high):
        return Material(problem, values, low[None, :], basis="values")
    spread = qmc.Sobol(problem.dimension, rng=1).random(_SETS)
    return Material(problem, values, low + spread * (high - low), basis="intervals")


_Values = tuple[dict[str, float], dict[str, tuple[float, float]]]


def _of_toml(setup: CalibrationSetup, content: Any, path: Path) -> _Values:  # noqa: ARG001
    """Return the values of parameters that a file knows, of a TOML file."""
    known = {*setup.problem.middle, *setup.file.fixed}
    assigned = {name: f"{name}={value}" for name, value in _flat(content) if name in known}
    values = setup.values(assigned.values())
    return {name: values[name] for name in assigned}, {}


def _of_card(setup: CalibrationSetup, content: Any, path: Path) -> _Values:
    """Return the values of parameters that a file knows, and their intervals, of a card."""
    try:
        card: _Card = read_plain(_Card, content)
    except ValueError as error:
        raise InputError(messages.NO_MATERIAL_CARD.fault("", path=str(path), why=error)) from error
    known = {*setup.problem.middle, *setup.file.fixed}
    parameters = [one for one in card.parameters if one.name in known]
    intervals = {one.name: one.interval_95 for one in parameters if one.interval_95}
    return {one.name: one.value for one in parameters}, intervals


def _read(path: Path) -> Any:
    try:
        data = read_within(path, LARGEST_RESULT)
        is_toml = path.suffix == ".toml"
        return tomllib.loads(data.decode("utf-8-sig")) if is_toml else parse_json(data)
    except (OSError, ValueError, RecursionError) as error:
        why = getattr(error, "strerror", None) or error
        fault = messages.MATERIAL_UNREADABLE.fault("", path=str(path), why=why)
        raise InputError(fault) from error


def _flat(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield numbers and texts by the names of parameters: dotted, own ones without a section."""
    for key, value in table.items():
        name = f"{before}.{key}" if before not in ("", "parameters") else key
        if isinstance(value, dict):
            yield from _flat(value, name)
        elif isinstance(value, int | float | str) and not isinstance(value, bool):
            yield name, value
