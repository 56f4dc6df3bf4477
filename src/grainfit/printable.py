"""Text that programs and files gave, made safe to show."""

from __future__ import annotations


def plain(text: str) -> str:
    r"""Return a text as one line that does nothing to a terminal: what is not printed is escaped.

    Examples
    --------
    >>> plain("red: \x1b[31m")
    'red: \\x1b[31m'
    """
    shown = text.replace("\t", "    ")
    if shown.isprintable():
        return shown
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in shown
    )


def plain_lines(text: str) -> list[str]:
    """Return the lines of a text, each as `plain` makes it."""
    return [plain(line) for line in text.splitlines()]
