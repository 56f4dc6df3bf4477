"""Walls on which particles roll for longer than a test waits are noted before any run."""

from __future__ import annotations

from pathlib import Path

import pytest

import grainfit as gf
from grainfit.bulk_tests.draw_down import messages
from grainfit.calibration_file.starter import starter_file

#: Of the walls, in the file of glass beads.
GIVEN = "rolling_friction = 0.05 "
SMOOTH = "rolling_friction = 0.005"


@pytest.mark.parametrize(
    ("test", "friction", "noted"),
    [
        ("draw_down", SMOOTH, True),
        ("draw_down", GIVEN, False),
        ("draw_down", "rolling_friction = { min = 0.001, max = 0.1 }", True),
        # Its plate has a friction of its own.
        ("heap", SMOOTH, False),
    ],
)
def test_smooth_walls_are_noted_where_a_bed_rests_on_them(
    tmp_path: Path, test: str, friction: str, noted: bool
) -> None:
    text = starter_file([test])
    assert text.count(GIVEN) == 1
    path = tmp_path / "beads.toml"
    path.write_text(text.replace(GIVEN, friction), encoding="utf-8")
    notes = [note for note in gf.load(path).notes() if messages.SMOOTH_WALLS.is_in(note)]
    assert len(notes) == noted
    if noted:
        assert f"Test {test}: with particle_wall.rolling_friction = 0.00" in notes[0]
        assert "Give 0.02 or more" in notes[0]
