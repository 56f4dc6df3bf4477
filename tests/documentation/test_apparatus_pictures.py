"""Pictures of the tests: up to date, on their pages, and with the names of the file."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.scenes.scene import Box
from grainfit.scenes.shapes import Block
from grainfit.scenes.triangles import triangles_of
from tools import apparatus_pictures as pictures
from tools.line_drawing import section

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize("name", [*pictures.PICTURES, "tests"])
def test_a_picture_is_that_of_the_test_as_it_is_now(name: str) -> None:
    path = pictures.path_of(name)
    is_written = pictures.picture(name) == path.read_text(encoding="utf-8")
    assert is_written, "run: python -m tools.apparatus_pictures"
    page = DOCS / ("choosing_tests.md" if name == "tests" else f"{name}_test.md")
    shown = re.findall(r"!\[[^]]*\]\(([^)]*)\)", page.read_text(encoding="utf-8"))
    assert path in [(DOCS / one).resolve() for one in shown]
    assert path.stat().st_size < 20_000


def test_every_test_has_a_picture() -> None:
    assert set(pictures.PICTURES) == set(BUILT_IN) == set(pictures._OVERVIEW)


@pytest.mark.parametrize("name", pictures.PICTURES)
def test_names_of_a_picture_are_options_and_responses(name: str) -> None:
    text = pictures.path_of(name).read_text(encoding="utf-8")
    test = BUILT_IN[name]
    options = {key.name for key in test.option_keys()}
    # Names that stand in two lines end with an underscore in the first.
    written = {
        style: re.sub(r"_ ", "_", " ".join(re.findall(rf'class="{style}"[^>]*>([^<]*)<', text)))
        for style in ("option", "found")
    }
    blue, purple = (set(re.findall(r"\b[a-z]+_[a-z_]+\b", words)) for words in written.values())
    assert blue
    assert blue <= options
    assert purple
    assert purple <= {*test.responses, *test.curves}


def test_the_section_of_a_cube_is_a_square() -> None:
    box = Box((-2.0, -2.0, -2.0), (2.0, 2.0, 2.0))
    cube = triangles_of(Block((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), box, 0.5)
    sides = section(np.asarray(cube), axis=1, at=0.1)
    lengths = np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
    assert lengths == pytest.approx([2.0] * 4)
    assert np.abs(sides).max(axis=(1, 2)) == pytest.approx([1.0] * 4)
