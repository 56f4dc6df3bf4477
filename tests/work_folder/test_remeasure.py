"""Measuring a finished run again; what cannot be measured has a message."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grainfit.bulk_tests import messages as of_bulk_tests
from grainfit.bulk_tests.heap import Heap
from grainfit.campaign.store.store import RunRecord
from grainfit.errors import InputError, NotMeasurableError
from grainfit.materials.sizes import ParticleSizes
from grainfit.run_definition import RunDefinition
from grainfit.work_folder import messages
from grainfit.work_folder.remeasure import measure_path

EMPTY_DUMP = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
0
ITEM: BOX BOUNDS ff ff ff
0 1
0 1
0 1
ITEM: ATOMS id type x y z radius mass
"""


def definition() -> dict[str, Any]:
    return json.loads(json.dumps(Heap(ParticleSizes((0.010,))).definition()))  # type: ignore[no-any-return]


def write_record(folder: Path, test: Any) -> None:
    record = RunRecord("abc", "heap", "finished", RunDefinition({"test": test}, {}, 1))
    (folder / "run.json").write_text(json.dumps(record.to_json()))


def test_a_whole_definition_is_understood(tmp_path: Path) -> None:
    write_record(tmp_path, definition())
    with pytest.raises(NotMeasurableError, match=r"stages\.csv is missing: .* version 0\.1\.0"):
        measure_path(tmp_path)


@pytest.mark.parametrize("key", ["setup", "diameters", "mass_fractions", "views"])
def test_an_incomplete_definition_is_said(tmp_path: Path, key: str) -> None:
    test = definition()
    del test[key]
    write_record(tmp_path, test)
    damaged = of_bulk_tests.DAMAGED_DEFINITION.matching(type="heap", reason=f"{key!r} is missing")
    with pytest.raises(InputError, match=rf"run\.json' {damaged}"):
        measure_path(tmp_path)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("setup", 3),
        ("setup", None),
        ("diameters", ["small"]),
        ("diameters", 0.01),
        ("mass_fractions", [0.5]),
        ("views", "many"),
    ],
)
def test_an_impossible_definition_is_said(tmp_path: Path, key: str, value: Any) -> None:
    write_record(tmp_path, {**definition(), key: value})
    with pytest.raises(
        InputError, match=rf"run\.json' {of_bulk_tests.DAMAGED_DEFINITION.matching(type='heap')}"
    ):
        measure_path(tmp_path)


def test_a_run_of_an_own_model_is_said(tmp_path: Path) -> None:
    write_record(tmp_path, None)
    with pytest.raises(InputError, match=messages.RUN_OF_OWN_MODEL.pattern):
        measure_path(tmp_path)


def test_a_dump_without_particles_is_said(tmp_path: Path) -> None:
    dump = tmp_path / "heap.dump"
    dump.write_text(EMPTY_DUMP)
    with pytest.raises(NotMeasurableError, match=r"heap\.dump: .* no particles"):
        measure_path(dump)


def test_a_dump_of_a_heap_is_measured(tmp_path: Path) -> None:
    slope, (x, y, z) = 0.5, np.mgrid[-20:21, -20:21, 0:12] + 0.5
    inside = z < 8 - slope * np.hypot(x, y)
    centres = 0.01 * np.column_stack([axis[inside] for axis in (x, y, z)])
    rows = "".join(f"{i} {a} {b} {c} 0.005 0.001\n" for i, (a, b, c) in enumerate(centres, 1))
    text = EMPTY_DUMP.replace("ATOMS\n0", f"ATOMS\n{len(centres)}").replace("id type", "id")
    dump = tmp_path / "any name.txt"
    dump.write_text(text + rows)
    found = measure_path(dump)

    assert list(found) == ["angle_of_repose", "base_radius", "heap_height"]
    assert found["angle_of_repose"].value == pytest.approx(26.6, abs=1.5)
    assert found["base_radius"].value == pytest.approx(0.14, abs=0.01)
    assert found["heap_height"].value == pytest.approx(0.075, abs=0.005)
