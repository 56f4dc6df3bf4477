"""The Python of docs/several_tests.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "several_tests.md"


def test_the_example_of_the_page_calibrates_and_its_search_names_tests() -> None:
    names: dict[str, Any] = {"__name__": "page"}
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        exec(compile(block, f"<{PAGE.name}>", "exec", dont_inherit=True), names)
    result = names["result"]
    assert result.status == "calibrated"
    # 0.2 * 0.6**2 = 0.072
    assert result.parameters["restitution"] == pytest.approx(0.6, abs=0.02)
    # Five runs of the design for the two parameters of the heap, four for the one of the drop.
    assert [run.stage for run in result.history if "drop" in run.runs].count("design") == 4
    assert len(names["proposal"].tests) == 1
