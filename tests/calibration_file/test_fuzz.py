"""Any content of a file is either read or refused with an InputError."""

from __future__ import annotations

import copy
import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grainfit.calibration_file.content import CalibrationFile
from grainfit.calibration_file.load import load_calibration_file
from grainfit.errors import InputError

GLASS_BEADS = (
    Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml"
).read_text(encoding="utf-8")

WORDS = """
    name particle wall particle_particle particle_wall parameters test strategy diameter density
    youngs_modulus restitution min max scale unit value mass_fraction type solver ranks targets
    timeout bulk_density angle_of_repose measurements uncertainty tolerance weight folder command
    function file nearest templates responses evaluate seed max_runs views lift_speed
    cluster walltime jobs runs_per_job partition setup options parsl
    curve x y x_unit y_unit covariance systematic coordinate_unit
"""
KEYS = st.sampled_from(WORDS.split()) | st.text(max_size=8)
QUANTITIES = st.builds(
    "{} {}".format,
    st.floats() | st.integers(),
    st.sampled_from(["mm", "kg/m^3", "MPa", "%", "deg", "rad", "J", "", "degC", "m^9/m^9", "dB"])
    | st.text("kgmPadersinµ°%^*/-0123456789 ()", max_size=12),
)
SCALARS = (
    st.integers()
    | st.integers(10**400, 10**401)
    | st.floats()
    | st.booleans()
    | st.text(max_size=12)
    | st.sampled_from(["log", "heap", "command", "python", "table", "lammps", "staged", "a.py:b"])
    | QUANTITIES
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=5),
    max_leaves=12,
)


def as_toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{as_toml(k)} = {as_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(as_toml(entry) for entry in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value).lower()


def load(document: dict[str, Any], folder: Path) -> None:
    text = "\n".join(f"{as_toml(key)} = {as_toml(value)}" for key, value in document.items())
    path = folder / "calibration.toml"
    path.write_text(text, encoding="utf-8", errors="replace")
    try:
        file = load_calibration_file(path)
    except InputError as error:
        note_unreadable(error)
    else:
        assert isinstance(file, CalibrationFile)
        assert file.parameters
        assert all(test.targets for test in file.tests)


def note_unreadable(error: InputError) -> None:
    assert error.faults
    for fault in error.faults:
        assert str(fault).isprintable()
        assert len(str(fault)) < 1500


def places(value: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) of a document."""
    entries = (
        list(value.items())
        if isinstance(value, dict)
        else list(enumerate(value))
        if isinstance(value, list)
        else []
    )
    found = [(value, key) for key, _ in entries]
    for _, entry in entries:
        found += places(entry)
    return found


fuzz = settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@fuzz
@given(document=st.dictionaries(KEYS, VALUES, max_size=8))
def test_random_documents(document: dict[str, Any], tmp_path: Path) -> None:
    load(document, tmp_path)


@fuzz
@given(data=st.data())
def test_changed_documents(data: st.DataObject, tmp_path: Path) -> None:
    document = copy.deepcopy(tomllib.loads(GLASS_BEADS))
    for _ in range(data.draw(st.integers(1, 4))):
        container, key = data.draw(st.sampled_from(places(document)))
        action = data.draw(st.sampled_from(["replace", "remove", "add"]))
        if action == "remove":
            del container[key]
        elif action == "add" and isinstance(container, dict):
            container[data.draw(KEYS)] = data.draw(VALUES)
        else:
            container[key] = data.draw(VALUES)
        if not document:
            break
    load(document, tmp_path)


@fuzz
@given(start=st.integers(0, len(GLASS_BEADS)), length=st.integers(0, 40), text=st.text(max_size=20))
def test_changed_text(start: int, length: int, text: str, tmp_path: Path) -> None:
    path = tmp_path / "calibration.toml"
    changed = GLASS_BEADS[:start] + text + GLASS_BEADS[start + length :]
    path.write_text(changed, encoding="utf-8", errors="replace")
    try:
        load_calibration_file(path)
    except InputError as error:
        note_unreadable(error)


def test_the_fuzzed_documents_start_from_a_good_one(tmp_path: Path) -> None:
    document = tomllib.loads(GLASS_BEADS)
    load(document, tmp_path)
    assert load_calibration_file(tmp_path / "calibration.toml").name == "glass beads"
    document["name"] = 3
    load(document, tmp_path)
    with pytest.raises(InputError):
        load_calibration_file(tmp_path / "calibration.toml")
