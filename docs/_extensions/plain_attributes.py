"""Docstrings of attributes and properties as sentences.

Napoleon takes the words before a first colon for a type, as in "int: Number of runs". Here a colon
is one of a sentence, and types stand in the code.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sphinx.ext import napoleon

if TYPE_CHECKING:
    from sphinx.application import Sphinx


class _Sentences(napoleon.NumpyDocstring):
    def __init__(
        self, docstring: Any, config: Any = None, app: Any = None, what: str = "", *rest: Any
    ) -> None:
        is_attribute = what in ("attribute", "data", "property")
        super().__init__(docstring, config, app, "" if is_attribute else what, *rest)


def setup(app: Sphinx) -> dict[str, bool]:
    """Replace the reader of docstrings."""
    napoleon.NumpyDocstring = _Sentences  # type: ignore[misc]
    return {"parallel_read_safe": True}
