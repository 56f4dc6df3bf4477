"""The page itself: the photograph, and handles on what was found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grainfit.formatting import plain
from grainfit.report.package_page import package_page
from grainfit.report.rendering import script_json


def photo_page(start: Mapping[str, Any], nonce: str) -> str:
    """Return the page of a photograph.

    The nonce is a secret that marks its scripts and styles: the browser uses no others.
    """
    name = plain(str(start["name"]))
    return package_page("grainfit.photo_page", name=name, start=script_json(start), nonce=nonce)
