"""Notes on tests that simulate the same, and could be one test."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.same_simulation import same_simulation_notes

FILE = """\
name = "sand"
[parameters]
friction = {{ min = 0.1, max = 0.9 }}
[[test]]
name = "angle"
type = "command"
folder = "model"
command = ["sh", "drum.sh", "{{{{ friction }}}}"]
evaluate = "angle.py:measure"
targets.angle = {{ value = 20 }}
[[test]]
name = "flow"
type = "command"
folder = "{folder}"
command = ["sh", "{script}", "{{{{ friction }}}}"]
evaluate = "{evaluate}"
targets.flow = {{ value = 2 }}
"""


def notes(place: Path, **changes: str) -> list[str]:
    for name in ("model", "other"):
        (place / name).mkdir()
        for file in ("drum.sh", "fast.sh", "angle.py", "flow.py"):
            (place / name / file).write_text("def measure(folder):\n    return {}\n")
    given = {"folder": "model", "script": "drum.sh", "evaluate": "flow.py:measure"}
    (place / "sand.toml").write_text(FILE.format(**{**given, **changes}))
    return list(same_simulation_notes(load_calibration_file(place / "sand.toml").tests))


@pytest.mark.parametrize("evaluate", ["flow.py:measure", "angle.py:measure"])
def test_tests_that_differ_at_most_in_their_evaluation_are_noted(
    tmp_path: Path, evaluate: str
) -> None:
    [note] = notes(tmp_path, evaluate=evaluate)
    assert "Tests angle and flow differ at most in their evaluation" in note
    assert "let the function in evaluate return all their responses" in note


@pytest.mark.parametrize("change", [{"folder": "other"}, {"script": "fast.sh"}])
def test_tests_with_another_folder_or_command_are_not_noted(
    tmp_path: Path, change: dict[str, str]
) -> None:
    assert notes(tmp_path, **change) == []
