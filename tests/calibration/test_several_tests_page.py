"""The Python of docs/several_tests.md runs as it stands."""

from __future__ import annotations

import pytest
from pages import names_after


def test_the_example_of_the_page_calibrates_and_its_search_names_tests() -> None:
    names = names_after("several_tests.md")
    result = names["result"]
    assert result.status == "calibrated"
    # 0.2 * 0.6**2 = 0.072
    assert result.parameters["restitution"] == pytest.approx(0.6, abs=0.02)
    # Five runs of the design for the two parameters of the heap, four for the one of the drop.
    assert [run.stage for run in result.history if "drop" in run.runs].count("design") == 4
    assert len(names["proposal"].tests) == 1
