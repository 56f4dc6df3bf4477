"""Picture of a compression test: stress over strain with the fitted slopes, and the bed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

from PIL import Image, ImageDraw

from grainfit.bulk_tests.compression.curve import FITTED, Curve, Modulus
from grainfit.bulk_tests.compression.setup import CompressionSetup
from grainfit.bulk_tests.shared.pot_view import PotView
from grainfit.formatting import number
from grainfit.measurement.sheet import INK, PAPER, QUIET_INK, font
from grainfit.measurement.sheet import OVERSAMPLING as _SCALE

_WIDTH, _HEIGHT = 1240 * _SCALE, 620 * _SCALE
_PLOT = (100 * _SCALE, 110 * _SCALE, 700 * _SCALE, 540 * _SCALE)
_POT = (800 * _SCALE, 110 * _SCALE, 1200 * _SCALE, 540 * _SCALE)
_TITLE, _TEXT = 30 * _SCALE, 17 * _SCALE
_TICK = 6 * _SCALE
_MOST_TICKS = 6

_GRID, _GREY = "#e4e7eb", "#9aa5b1"
#: Blue and vermilion are distinct in any kind of colour blindness (Okabe & Ito).
_COLOURS = {"load": "#0072b2", "unload": "#d55e00", "seat": _GREY}
_NAMES = {"load": "loading", "unload": "unloading"}

Place = Callable[[float, float], tuple[float, float]]


def draw_compression(
    path: Path,
    view: PotView,
    setup: CompressionSetup,
    curves: Mapping[str, Curve],
    moduli: Mapping[str, Modulus],
) -> None:
    """Write a PNG of stress over strain, and of the bed under the stress.

    Parameters
    ----------
    path : Path
        File to write; ends in ``.png``.
    view : PotView
        The bed under the stress.
    setup : CompressionSetup
        Geometry and stresses.
    curves : mapping of str to Curve
        Of the stages ``"seat"``, ``"load"`` and ``"unload"``.
    moduli : mapping of str to Modulus
        ``"loading_modulus"`` and ``"unloading_modulus"``.
    """
    image = Image.new("RGB", (_WIDTH, _HEIGHT), PAPER)
    draw = ImageDraw.Draw(image)
    values = [f"{_NAMES[s]} {_kilo(moduli[f'{s}ing_modulus'].value)} kPa" for s in _NAMES]
    margin = 24 * _SCALE
    title = f"Compression: modulus of {', of '.join(values)}"
    draw.text((margin, margin), title, fill=INK, font=font(_TITLE))
    _draw_curves(draw, setup.stress, curves, moduli)
    _paste_bed(image, view, setup)
    image.reduce(_SCALE).save(path)


def _kilo(pascals: float) -> str:
    return number(pascals / 1000, 3)


def _draw_curves(
    draw: ImageDraw.ImageDraw,
    stress: float,
    curves: Mapping[str, Curve],
    moduli: Mapping[str, Modulus],
) -> None:
    height = float(curves["seat"].heights[-1])
    strains = {stage: curve.strains(height) for stage, curve in curves.items()}
    longest = 1.08 * max(float(strains["load"].max()), 1e-9)
    left, top, right, bottom = _PLOT
    highest = 1.08 * stress

    def place(strain: float, pressure: float) -> tuple[float, float]:
        x = left + (right - left) * strain / longest
        return x, bottom - (bottom - top) * pressure / highest

    _axes(draw, place, 100 * longest, highest / 1000)
    for stage in _NAMES:
        points = [place(*pair) for pair in zip(strains[stage], curves[stage].stresses, strict=True)]
        draw.line(points, fill=_COLOURS[stage], width=2 * _SCALE, joint="curve")
    for stage, name in _NAMES.items():
        fit = moduli[f"{stage}ing_modulus"]
        ends = [share * stress for share in FITTED]
        line = [place((p - fit.stress_at_zero) / fit.value, p) for p in ends]
        draw.line(line, fill=INK, width=4 * _SCALE)
        x, y = (line[0][0] + line[1][0]) / 2, (line[0][1] + line[1][1]) / 2
        side, anchor = (-1, "rm") if stage == "load" else (1, "lm")
        label = f"{name} {_kilo(fit.value)} kPa"
        draw.text((x + 12 * _SCALE * side, y), label, _COLOURS[stage], font(_TEXT), anchor)


def _axes(draw: ImageDraw.ImageDraw, place: Place, percent: float, kilopascals: float) -> None:
    left, top, right, bottom = _PLOT
    used = font(_TEXT)
    for tick in _ticks(percent):
        x, _ = place(tick / 100, 0)
        draw.line([(x, top), (x, bottom)], fill=_GRID, width=_SCALE)
        draw.text((x, bottom + 2 * _TICK), f"{tick:g}", QUIET_INK, used, "ma")
    for tick in _ticks(kilopascals):
        _, y = place(0, 1000 * tick)
        draw.line([(left, y), (right, y)], fill=_GRID, width=_SCALE)
        draw.text((left - 2 * _TICK, y), f"{tick:g}", QUIET_INK, used, "rm")
    draw.line([(left, top), (left, bottom), (right, bottom)], fill=INK, width=_SCALE)
    draw.text(((left + right) / 2, bottom + 6 * _TICK), "strain, %", INK, used, "ma")
    draw.text((left, top - 2 * _TICK), "stress on the piston, kPa", INK, used, "ls")


def _ticks(longest: float) -> list[float]:
    """Return round numbers from zero to not more than a value."""
    power = 10.0 ** math.floor(math.log10(longest / _MOST_TICKS))
    step = next(f * power for f in (1, 2, 5, 10) if f * power * _MOST_TICKS >= longest)
    return [step * n for n in range(int(longest / step) + 1)]


def _paste_bed(image: Image.Image, view: PotView, setup: CompressionSetup) -> None:
    """Paste the half of the bed behind the axis, with pot and piston."""
    left, _, right, bottom = _POT
    panel = view.side_view(has_piston=True).panel(right - left)
    image.paste(panel, (left, bottom - panel.height))
    words = f"the bed under {_kilo(setup.stress)} kPa, behind the axis"
    middle = ((left + right) / 2, bottom + 6 * _TICK)
    ImageDraw.Draw(image).text(middle, words, INK, font(_TEXT), "ma")
