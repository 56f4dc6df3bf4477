"""A custom Parsl configuration, referred to as ``"file.py:name"``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grainfit.campaign import messages
from grainfit.errors import InputError
from grainfit.files import is_file
from grainfit.options.kinds import Kind, Schema, Text
from grainfit.options.paths import note_not_there
from grainfit.options.places import Place, show
from grainfit.options.python_file import PythonFile


@dataclass(frozen=True)
class ParslConfiguration(Kind):
    """A Parsl configuration, ``"file.py:name"``, which is checked but not executed."""

    def read(self, value: Any, place: Place) -> str | None:
        """Read a reference to it; in the result, the path of its file is absolute."""
        text = Text().read(value, place)
        if text is None:
            return None
        folder = place.findings.folder
        try:
            file = PythonFile(text, folder)
        except InputError:
            place.fault(messages.NO_PARSL_CONFIG, given=show(text))
            return None
        if not is_file(file.path):
            note_not_there(text, folder, place)
            return None
        try:
            file.check()
        except InputError as error:
            for fault in error.faults:
                message = fault.message.replace("has no function", "has no")
                place.fault(messages.BAD_PARSL_CONFIG, given=show(text), reason=message)
            return None
        return f"{file.path}:{file.function}"

    def schema(self) -> Schema:
        """Return the JSON Schema of a reference."""
        return {"type": "string", "pattern": r"\.py:\w+$"}
