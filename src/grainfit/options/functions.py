"""Read options that name a function in a Python file, ``"file.py:function"``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grainfit.errors import InputError
from grainfit.files import is_file
from grainfit.options import messages
from grainfit.options.kinds import Kind, Schema, Text
from grainfit.options.paths import note_not_there
from grainfit.options.places import Place, show
from grainfit.options.python_file import PythonFile


@dataclass(frozen=True)
class Function(Kind):
    """A Python function, ``"file.py:function"``, which is searched for but not executed.

    Parameters
    ----------
    arguments : tuple of str
        Names of all arguments that it can take; empty if that does not matter.
    """

    arguments: tuple[str, ...] = ()

    def read(self, value: Any, place: Place) -> str | None:
        """Read a reference to a function, and make the path of its file absolute."""
        text = Text().read(value, place)
        if text is None:
            return None
        found = find_function(text, place.findings.folder, place)
        return found if found is None or self._takes_known(found, text, place) else None

    def _takes_known(self, found: str, text: str, place: Place) -> bool:
        """Note arguments of a function that it cannot be given; return whether there are none."""
        unknown = PythonFile(found).unknown_arguments(self.arguments) if self.arguments else []
        if unknown:
            place.fault(
                messages.TAKES_OTHER_ARGUMENTS,
                given=show(text),
                unknown=", ".join(unknown),
                arguments=", ".join(self.arguments),
            )
        return not unknown

    def schema(self) -> Schema:
        """Return the JSON Schema of a reference."""
        return {"type": "string", "pattern": r"\.py:\w+$"}


def find_function(reference: str, folder: Path, place: Place) -> str | None:
    """Return a reference to a function with an absolute path; None if it is not found.

    Parameters
    ----------
    reference : str
        ``"file.py:function"``.
    folder : Path
        Base folder of relative paths.
    place : Place
        Of the reference.
    """
    try:
        function = PythonFile(reference, folder)
        if not is_file(function.path):
            note_not_there(reference, folder, place)
            return None
        function.check()
    except InputError as error:
        for fault in error.faults:
            words = f"{fault.key} {fault.message}".lstrip()
            place.fault(
                messages.BAD_REFERENCE, reference=show(reference), reason=words, remedy=fault.remedy
            )
        return None
    return f"{function.path}:{function.function}"
