"""The page itself: questions, estimate, plan, file, and the start."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grainfit.report.package_page import package_page
from grainfit.report.rendering import script_json


def start_page(start: Mapping[str, Any], nonce: str) -> str:
    """Return the page of a calibration file.

    The nonce is a secret that marks its scripts and styles: the browser uses no others.
    """
    return package_page("grainfit.start_page", start=script_json(start), nonce=nonce)
