"""The Python of docs/curves.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parents[2] / "docs" / "curves.md"


def test_the_example_of_the_page_calibrates_on_its_curve() -> None:
    names: dict[str, Any] = {"__name__": "page"}
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        exec(compile(block, f"<{PAGE.name}>", "exec", dont_inherit=True), names)
    result = names["result"]

    assert result.status == "calibrated"
    # The points were made with 2.4e5 Pa and 0.6, and rounded with errors of about 1 %.
    low, high = result.intervals["modulus"].low, result.intervals["modulus"].high
    assert low < 2.4e5 < high
    assert high - low < 4e4
