"""Texts of the help, which are markup."""

from __future__ import annotations

import inspect

#: Default of the options that name a work folder.
WORK_FOLDER = "the file's name with .grainfit, here"


def escaped(words: str) -> str:
    r"""Return words whose brackets are no markup.

    Examples
    --------
    >>> escaped("[strategy]")
    '\\[strategy]'
    """
    return words.replace("[", r"\[")


def shown_default(words: str) -> str:
    r"""Return a default in words, in brackets as the help shows all defaults.

    Examples
    --------
    >>> shown_default("all bulk tests")
    '\\[default: all bulk tests]'
    """
    return escaped(f"[default: {words}]")


def paragraphs(docstring: str | None) -> str:
    r"""Return a docstring with one line for each paragraph, which terminals break at their width.

    Examples
    --------
    >>> paragraphs("Say it.\n\n    A sentence that\n    goes on.")
    'Say it.\n\nA sentence that goes on.'
    """
    blocks = inspect.cleandoc(docstring or "").split("\n\n")
    return "\n\n".join(" ".join(block.split("\n")) for block in blocks)
