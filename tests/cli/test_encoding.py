"""Terminals that lack characters, such as ± in ASCII."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from grainfit.cli import encoding

MODEL = "def simulate(parameters, seed):\n    return {'angle': 60 * parameters['friction']}\n"
FILE = """name = "Schüttgut ρ"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
function = "model.py:simulate"
targets.angle = { value = 30, tolerance = 0.6, unit = "deg" }
"""


def test_a_calibration_ends_well_on_a_terminal_that_shows_ascii(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text(MODEL)
    (tmp_path / "Sand.toml").write_text(FILE, encoding="utf-8")
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    printed = []
    for *arguments, code in (
        ("run", "Sand.toml", "--no-report", 0),
        ("result", "Sand.grainfit", 0),
        ("check", "Schüttgüter.toml", 1),
    ):
        command = [sys.executable, "-m", "grainfit", *map(str, arguments)]
        done = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, timeout=120, check=False
        )
        assert done.returncode == code, done.stderr
        assert b"Traceback" not in done.stderr
        printed.append((done.stdout + done.stderr).decode("ascii"))
    assert "30 +- 0.6" in printed[1]
    assert "Schuttguter.toml" in printed[2]


def test_plain_characters_say_the_same() -> None:
    encoding.lose_no_output()
    shown = "ρ_b = 5 ± 0.1 µm², 20 °, … ✓ 漢 \udcff".encode("ascii", "grainfit.plain")
    assert shown == b"rho_b = 5 +- 0.1 um2, 20 deg, ... ok ? ?"
