"""Checks before any run: each has a name, and finds what the user should know.

A check is a function of one context, which yields keys of the calibration file, each with a line of
text. It stands beside what it is about:

    @check("few-particles", "warning")
    def few_particles(context: CheckContext) -> Iterator[Found]:
        \"\"\"Classes of sizes of which a test has only a few particles.\"\"\"
        yield "particle.diameter", "..."

That of a bulk test is registered in its ``checks``, any other one in
`grainfit.calibration_file.checks.registry`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, Literal, TypeAlias, TypeVar

from grainfit.one_line import OneLine

#: A note is good to know. A warning says that runs may fail, or that results may mislead.
Severity = Literal["note", "warning"]
#: Key of the calibration file, ``""`` where none is concerned, and one line of text.
Found: TypeAlias = tuple[str, str]

_Context = TypeVar("_Context")
_AnyContext = TypeVar("_AnyContext", contravariant=True)


@dataclass(frozen=True)
class Finding:
    """A line that a check has for the user.

    Parameters
    ----------
    check : str
        Name of the check.
    severity : {"note", "warning"}
        Whether it is good to know, or whether runs may fail or mislead.
    text : str
        One line.
    key : str
        Dotted key of the calibration file, ``test[0].`` before that of the first test; ``""``
        where no key is concerned.
    """

    check: str
    severity: Severity
    text: str
    key: str = ""


@dataclass(frozen=True)
class Check(Generic[_AnyContext], OneLine):
    """A check with its name; see `check`.

    Parameters
    ----------
    name : str
        Stable name, such as ``"smooth-walls"``.
    severity : {"note", "warning"}
        That of its findings.
    about : str
        What it looks for, in one line.
    find : callable
        Yields keys and texts for a context.
    """

    name: str
    severity: Severity
    about: str
    find: Callable[[_AnyContext], Iterable[Found]]

    def __call__(self, context: _AnyContext) -> Iterator[Finding]:
        """Yield the findings of the check in a context."""
        for key, text in self.find(context):
            yield Finding(self.name, self.severity, text, key)


def check(
    name: str, severity: Severity = "note"
) -> Callable[[Callable[[_Context], Iterable[Found]]], Check[_Context]]:
    """Return a decorator that makes a function a check, described by its docstring.

    Parameters
    ----------
    name : str
        Stable name, of lower-case words joined by hyphens.
    severity : {"note", "warning"}
        That of its findings.
    """

    def made(find: Callable[[_Context], Iterable[Found]]) -> Check[_Context]:
        about = (find.__doc__ or "").strip().partition("\n")[0]
        assert about, "a check that does not say what it looks for"
        return Check(name, severity, about, find)

    return made
