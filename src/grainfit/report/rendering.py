"""Render templates as HTML, and plain data as JSON that is safe in a page."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from typing import Any
from urllib.parse import quote

import numpy as np
from jinja2 import BaseLoader, ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from grainfit.formatting import counted, duration, number, plain, rounded

# A script element has no HTML escapes: characters that could end it, or begin another one, are
# written as JSON escapes.
_ESCAPES = str.maketrans({sign: f"\\u{ord(sign):04x}" for sign in "<>&"})


def fill_template(template: str, **values: Any) -> Markup:
    """Fill in a template of the report; every value is escaped unless it is `Markup`.

    Parameters
    ----------
    template : str
        File in ``templates`` or ``sections``, without ``.html.jinja``, such as ``particles/page``.
    **values
        Values of its variables.
    """
    return Markup(_of_report().get_template(f"{template}.html.jinja").render(values))


def script_json(value: Any, digits: int | None = None) -> Markup:
    """Return data as JSON for a ``<script type="application/json">``.

    Parameters
    ----------
    value : object
        Plain data and NumPy arrays. Numbers that are not finite become null.
    digits : int, optional
        Significant digits of its numbers: enough to draw them. All of them by default.
    """
    text = json.dumps(_plain_data(value, digits), allow_nan=False, separators=(",", ":"))
    return Markup(text.translate(_ESCAPES))


def _plain_data(value: Any, digits: int | None) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        if not math.isfinite(value):
            return None
        return value if digits is None else float(f"{value:.{digits}g}")
    if isinstance(value, Mapping):
        return {str(key): _plain_data(item, digits) for key, item in value.items()}
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [_plain_data(item, digits) for item in value]
    return value


@cache
def _of_report() -> Environment:
    return environment(
        ChoiceLoader(
            [PackageLoader("grainfit.report"), PackageLoader("grainfit.report", "sections")]
        )
    )


def environment(loader: BaseLoader) -> Environment:
    """Return what fills in templates of pages, with the filters of the report, and its `icon`."""
    made = Environment(
        loader=loader,
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {
        "counted": counted,
        "number": number,
        "rounded": rounded,
        "plain": plain,
        "duration": duration,
    }
    icon = (files("grainfit.report") / "icon.svg").read_text(encoding="utf-8").strip()
    made.globals["icon"] = f"data:image/svg+xml,{quote(icon)}"
    return made
