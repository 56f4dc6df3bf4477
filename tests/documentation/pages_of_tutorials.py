"""Read the fenced blocks of a page that a comment marks for the tests.

``<!-- file: NAME -->`` is a file, ``<!-- run -->`` commands in a folder with these files,
``<!-- run in: FOLDER -->`` commands in a copy of a folder of the repository.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
_BLOCK = re.compile(r"<!-- ([^\n]*?) -->\n```\w*\n(.*?)```", re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A marked block: words of its mark, and its text."""

    mark: str
    text: str


def marked_blocks(page: str) -> list[Block]:
    """Return all marked blocks of a page of docs/."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return [Block(*found) for found in _BLOCK.findall(text)]
