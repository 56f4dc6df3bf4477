"""Messages to users about functions of theirs in Python files."""

from __future__ import annotations

from grainfit.messages import Message

NO_REFERENCE = Message(
    "{reference!r} does not name a function in a file.",
    'Write the file and the function in it: "model.py:simulate".',
)
NO_SUCH_FUNCTION = Message("has no function {function!r}.", "{remedy}")
NESTED_TOO_DEEPLY = Message("is nested too deeply for Python.", "Simplify it.")
TOO_LARGE_TO_READ = Message(
    "cannot be read: {reason}.", "Move its data to a file that the function reads."
)
CANNOT_BE_READ = Message("cannot be read: {reason}.", "Give the path of a Python file.")
NOT_PYTHON = Message("is not valid Python: {reason}.")
