"""Picture of a compression test: stress over strain with the fitted slopes, and the bed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from grainfit.bulk_tests.compression.curve import FITTED, Curve, Modulus
from grainfit.bulk_tests.compression.setup import CompressionSetup
from grainfit.formatting import number
from grainfit.measurement.particles import Particles

#: Everything is drawn this much larger and then reduced, for smooth edges.
_SCALE = 2
_WIDTH, _HEIGHT = 1240 * _SCALE, 620 * _SCALE
_PLOT = (100 * _SCALE, 110 * _SCALE, 700 * _SCALE, 540 * _SCALE)
_POT = (800 * _SCALE, 110 * _SCALE, 1200 * _SCALE, 540 * _SCALE)
_TITLE, _TEXT = 30 * _SCALE, 17 * _SCALE
_TICK = 6 * _SCALE
_MOST_TICKS = 6

_PAPER, _INK, _QUIET, _GRID = "#ffffff", "#1f2933", "#616e7c", "#e4e7eb"
_GREY = "#9aa5b1"
#: Blue and vermilion are distinct in any kind of colour blindness (Okabe & Ito).
_COLOURS = {"load": "#0072b2", "unload": "#d55e00", "seat": _GREY}
_NAMES = {"load": "loading", "unload": "unloading"}

Place = Callable[[float, float], tuple[float, float]]


def draw_compression(
    path: Path,
    bed: Particles,
    setup: CompressionSetup,
    curves: Mapping[str, Curve],
    moduli: Mapping[str, Modulus],
) -> None:
    """Write a PNG of stress over strain, and of the bed under the stress.

    Parameters
    ----------
    path : Path
        File to write; ends in ``.png``.
    bed : Particles
        Under the stress.
    setup : CompressionSetup
        Geometry and stresses.
    curves : mapping of str to Curve
        Of the stages ``"seat"``, ``"load"`` and ``"unload"``.
    moduli : mapping of str to Modulus
        ``"loading_modulus"`` and ``"unloading_modulus"``.
    """
    image = Image.new("RGB", (_WIDTH, _HEIGHT), _PAPER)
    draw = ImageDraw.Draw(image)
    values = [f"{_NAMES[s]} {_kilo(moduli[f'{s}ing_modulus'].value)} kPa" for s in _NAMES]
    margin = 24 * _SCALE
    title = f"Compression: modulus of {', of '.join(values)}"
    draw.text((margin, margin), title, fill=_INK, font=_font(_TITLE))
    _draw_curves(draw, setup.stress, curves, moduli)
    _draw_bed(draw, bed, setup, float(curves["load"].heights[-1]))
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
        draw.line(line, fill=_INK, width=4 * _SCALE)
        x, y = (line[0][0] + line[1][0]) / 2, (line[0][1] + line[1][1]) / 2
        side, anchor = (-1, "rm") if stage == "load" else (1, "lm")
        label = f"{name} {_kilo(fit.value)} kPa"
        draw.text((x + 12 * _SCALE * side, y), label, _COLOURS[stage], _font(_TEXT), anchor)


def _axes(draw: ImageDraw.ImageDraw, place: Place, percent: float, kilopascals: float) -> None:
    left, top, right, bottom = _PLOT
    font = _font(_TEXT)
    for tick in _ticks(percent):
        x, _ = place(tick / 100, 0)
        draw.line([(x, top), (x, bottom)], fill=_GRID, width=_SCALE)
        draw.text((x, bottom + 2 * _TICK), f"{tick:g}", _QUIET, font, "ma")
    for tick in _ticks(kilopascals):
        _, y = place(0, 1000 * tick)
        draw.line([(left, y), (right, y)], fill=_GRID, width=_SCALE)
        draw.text((left - 2 * _TICK, y), f"{tick:g}", _QUIET, font, "rm")
    draw.line([(left, top), (left, bottom), (right, bottom)], fill=_INK, width=_SCALE)
    draw.text(((left + right) / 2, bottom + 6 * _TICK), "strain, %", _INK, font, "ma")
    draw.text((left, top - 2 * _TICK), "stress on the piston, kPa", _INK, font, "ls")


def _ticks(longest: float) -> list[float]:
    """Return round numbers from zero to not more than a value."""
    power = 10.0 ** math.floor(math.log10(longest / _MOST_TICKS))
    step = next(f * power for f in (1, 2, 5, 10) if f * power * _MOST_TICKS >= longest)
    return [step * n for n in range(int(longest / step) + 1)]


def _draw_bed(
    draw: ImageDraw.ImageDraw, bed: Particles, setup: CompressionSetup, piston: float
) -> None:
    """Draw the particles from the side, those in front last, and pot, floor and piston."""
    left, top, right, bottom = _POT
    radius = setup.pot_radius
    scale = min((right - left) / (2 * radius), (bottom - top) / setup.piston_start)
    middle = (left + right) / 2

    def place(x: float, z: float) -> tuple[float, float]:
        return middle + x * scale, bottom - z * scale

    for i in np.argsort(-bed.positions[:, 1]):
        x, y, z = bed.positions[i]
        r = bed.radii[i]
        shade = round(205 + 40 * y / radius)
        box = [place(x - r, z + r), place(x + r, z - r)]
        draw.ellipse(box, fill=(shade, shade, shade), outline=_GREY, width=_SCALE)
    wide = 3 * _SCALE
    ends = [place(-radius, setup.piston_start), place(-radius, 0), place(radius, 0)]
    draw.line([*ends, place(radius, setup.piston_start)], fill=_INK, width=wide)
    colour = _COLOURS["load"]
    draw.line([place(-radius, piston), place(radius, piston)], fill=colour, width=2 * wide)
    words = f"the bed under {_kilo(setup.stress)} kPa"
    draw.text((middle, bottom + 6 * _TICK), words, _INK, _font(_TEXT), "ma")


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)
