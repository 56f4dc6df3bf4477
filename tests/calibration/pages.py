"""Run the Python of a page of the documentation."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[2] / "docs"


def names_after(page: str) -> dict[str, Any]:
    """Run all Python of a page as it stands, and return the names that it leaves."""
    names: dict[str, Any] = {"__name__": "page"}
    text = (DOCS / page).read_text(encoding="utf-8")
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(compile(block, f"<{page}>", "exec", dont_inherit=True), names)
    return names
