"""Lines of decks: commands at a fixed column, headings."""

from __future__ import annotations

#: Column at which the arguments of a command begin, and width of a heading.
_INDENT, _WIDTH = 16, 99


def command(name: str, arguments: str) -> str:
    """Return a line of a deck."""
    return f"{name:<{_INDENT - 1}} {arguments}"


def heading(title: str) -> str:
    """Return a comment line that begins a part of a deck."""
    return f"\n# --- {title} ".ljust(_WIDTH, "-")


def continued(first: str, parts: list[str]) -> str:
    """Return a command over several lines."""
    return " &\n    ".join([first, *parts])
