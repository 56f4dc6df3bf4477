"""Line drawings of the bulk tests in PDF pages: the part of SVG in which they are written."""

from __future__ import annotations

import re
from collections.abc import Mapping
from xml.etree import ElementTree

from reportlab.graphics.shapes import Circle, Drawing, Group, Path, String
from reportlab.lib.colors import HexColor

from grainfit.pdf import BOLD, REGULAR

_SPACE = "{http://www.w3.org/2000/svg}"
_RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")
_POINT = re.compile(r"([MLZ])(?:(-?[\d.]+) (-?[\d.]+))?")
_FONT_SIZE = 12.0
#: Points of a pixel, where there is room.
_SCALE = 0.6

Style = Mapping[str, str]


def line_drawing(svg: str, widest: float) -> Drawing:
    """Return a line drawing as a part of a page.

    Parameters
    ----------
    svg : str
        Paths of straight lines, circles and texts in groups that are shifted, with the colours and
        widths of its classes, as `tools/line_drawing.py` writes them.
    widest : float
        Largest width on the page, points.
    """
    root = ElementTree.fromstring(svg)
    styles = _styles(root.findtext(f"{_SPACE}style") or "")
    wide, high = (float(root.attrib[name]) for name in ("width", "height"))
    scale = min(_SCALE, widest / wide)
    whole = Group(transform=(scale, 0, 0, -scale, 0, scale * high))
    for element in root:
        _add(element, whole, styles)
    drawing = Drawing(scale * wide, scale * high)
    drawing.add(whole)
    return drawing


def _styles(text: str) -> dict[str, Style]:
    """Return the properties of each selector, which is ``tag``, ``.class`` or ``tag.class``."""
    found: dict[str, dict[str, str]] = {}
    for selectors, body in _RULE.findall(text):
        pairs = (one.split(":", 1) for one in body.split(";") if ":" in one)
        properties = {name.strip(): value.strip() for name, value in pairs}
        for selector in selectors.split(","):
            found.setdefault(selector.strip(), {}).update(properties)
    return dict(found)


def _add(element: ElementTree.Element, group: Group, styles: Mapping[str, Style]) -> None:
    tag = element.tag.removeprefix(_SPACE)
    classes = element.get("class", "").split()
    selectors = (tag, *(f".{one}" for one in classes), *(f"{tag}.{one}" for one in classes))
    style = {k: v for one in selectors for k, v in styles.get(one, {}).items()}
    if tag == "g":
        x, y = map(float, re.findall(r"-?[\d.]+", element.attrib["transform"]))
        inner = Group(transform=(1, 0, 0, 1, x, y))
        group.add(inner)
        for one in element:
            _add(one, inner, styles)
    elif tag == "path":
        path = Path(**_ink(style))
        for command, x_text, y_text in _POINT.findall(element.attrib["d"]):
            if command == "Z":
                path.closePath()
            else:
                (path.moveTo if command == "M" else path.lineTo)(float(x_text), float(y_text))
        group.add(path)
    elif tag == "circle":
        x, y, radius = (float(element.attrib[name]) for name in ("cx", "cy", "r"))
        group.add(Circle(x, y, radius, **_ink(style)))
    elif tag == "text":
        group.add(_words(element, style))


def _words(element: ElementTree.Element, style: Style) -> Group:
    words = String(
        0,
        0,
        element.text or "",
        fontName=BOLD if "bold" in style.get("font", "") else REGULAR,
        # DejaVu Sans is wider than the fonts of browsers.
        fontSize=0.85 * _FONT_SIZE,
        fillColor=_colour(style.get("fill", "#000000")),
        textAnchor=element.get("text-anchor", "start"),
    )
    # The page is upside down in SVG, its letters are not.
    upright = Group(transform=(1, 0, 0, -1, float(element.get("x", 0)), float(element.get("y", 0))))
    upright.add(words)
    return upright


def _ink(style: Style) -> dict[str, object]:
    dashes = style.get("stroke-dasharray")
    return {
        "fillColor": _colour(style.get("fill", "none")),
        "strokeColor": _colour(style.get("stroke", "none")),
        "strokeWidth": float(style.get("stroke-width", 1)),
        "strokeDashArray": [float(one) for one in dashes.split()] if dashes else None,
    }


def _colour(text: str) -> HexColor | None:
    if text == "none":
        return None
    digits = text.removeprefix("#")
    return HexColor(f"#{''.join(2 * one for one in digits) if len(digits) == 3 else digits}")
