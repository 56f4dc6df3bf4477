"""The page itself: a frame that a script fills with the state, as it comes in."""

from __future__ import annotations

from pathlib import Path

from grainfit.formatting import plain
from grainfit.report.package_page import package_page


def watch_page(folder: Path, nonce: str) -> str:
    """Return the page, with all that it needs but the state.

    The nonce is a secret that marks its scripts and styles: the browser uses no others.
    """
    name = plain(folder.absolute().name)
    return package_page("grainfit.watch", name=name, nonce=nonce)
