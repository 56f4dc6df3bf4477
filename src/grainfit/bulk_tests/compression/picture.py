"""Picture of a compression test: stress over strain with the fitted slopes, and the bed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.bulk_tests.compression.curve import FITTED, Curve, Modulus
from grainfit.bulk_tests.compression.setup import CompressionSetup
from grainfit.bulk_tests.shared.pot_view import PotView
from grainfit.formatting import number
from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.sheet import INK, OVERSAMPLING, sheet

_PANEL_WIDTH = 560 * OVERSAMPLING
_PLOT_SIZE = _PANEL_WIDTH, 420 * OVERSAMPLING
_NAMES = {"load": "loading", "unload": "unloading"}
#: Blue and vermilion are distinct in any kind of colour blindness (Okabe & Ito).
_COLOURS = "#0072b2", "#d55e00"


def draw_compression(
    path: Path,
    view: PotView,
    setup: CompressionSetup,
    curves: Mapping[str, Curve],
    moduli: Mapping[str, Modulus],
) -> None:
    """Write a PNG of the bed under the stress, and of stress over strain with the fitted moduli."""
    values = [f"{_NAMES[s]} {_kilo(moduli[f'{s}ing_modulus'].value)} kPa" for s in _NAMES]
    title = f"Compression: modulus of {', of '.join(values)}"
    subtitle = (
        f"left, the bed under {_kilo(setup.stress)} kPa behind the axis; right, the stress on the "
        "piston against strain, and the fitted lines"
    )
    panels = [
        view.side_view(has_piston=True).panel(_PANEL_WIDTH),
        _stress_panel(setup.stress, curves, moduli),
    ]
    sheet(title, subtitle, panels, _PANEL_WIDTH).save(path)


def _kilo(pascals: float) -> str:
    return number(pascals / 1000, 3)


def _stress_panel(
    stress: float, curves: Mapping[str, Curve], moduli: Mapping[str, Modulus]
) -> Image.Image:
    height = float(curves["seat"].heights[-1])
    stresses = np.array(FITTED) * stress
    behind, fitted = [], []
    for (stage, name), colour in zip(_NAMES.items(), _COLOURS, strict=True):
        curve, fit = curves[stage], moduli[f"{stage}ing_modulus"]
        label = f"{name}, {_kilo(fit.value)} kPa"
        strains = 100 * curve.strains(height)
        behind.append(PlottedLine(strains, curve.stresses / 1000, label, colour))
        strains = 100 * (stresses - fit.stress_at_zero) / fit.value
        fitted.append(PlottedLine(strains, stresses / 1000, colour=INK, width=4))
    return line_panel([*behind, *fitted], "strain, %", "stress on the piston, kPa", _PLOT_SIZE)
