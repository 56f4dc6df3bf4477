"""Text for people: durations, and what programs and files gave made safe to show."""

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


def duration(seconds: float) -> str:
    """Return a duration in hours, minutes and seconds.

    Examples
    --------
    >>> duration(3720)
    '1 h 02 min'
    """
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


def counted(count: int, noun: str) -> str:
    """Return how many there are of something.

    Examples
    --------
    >>> counted(1, "run"), counted(3, "run")
    ('1 run', '3 runs')
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
