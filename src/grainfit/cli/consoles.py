"""Consoles of the command line: lines are as wide as the terminal, and uncut elsewhere."""

from __future__ import annotations

from rich.console import Console, ConsoleDimensions
from typing_extensions import override

#: Width of output that does not go to a terminal: no line is broken, no number cut.
_UNCUT = 100_000


class UncutConsole(Console):
    """A console that breaks lines on a terminal only."""

    @property
    @override
    def size(self) -> ConsoleDimensions:
        """Dimensions of the output, in characters."""
        found = super().size
        return found if self.is_terminal else ConsoleDimensions(_UNCUT, found.height)

    @size.setter
    def size(self, new_size: tuple[int, int]) -> None:
        self._width, self._height = new_size


#: Standard output, and standard error.
out = UncutConsole()
err = UncutConsole(stderr=True)
#: The same for what --quiet leaves out: progress, paths and remarks.
out_remarks = UncutConsole()
err_remarks = UncutConsole(stderr=True)
