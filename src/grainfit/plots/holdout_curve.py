"""A curve that took no part in the fit: bands before and after the calibration, and the points."""

from __future__ import annotations

from html import escape

from grainfit.formatting import plain
from grainfit.plots.curve_traces import (
    axis_of,
    band,
    coordinate_axis,
    line,
    measured_points,
    single_runs,
    title_of_curve,
)
from grainfit.plots.figure import Figure
from grainfit.plots.labels import Label
from grainfit.plots.style import LEGEND_ABOVE, PURPLE
from grainfit.result import HoldoutCurve

_QUIET_BAND = "rgba(136, 136, 136, 0.2)"


def holdout_curve(label: Label, found: HoldoutCurve) -> Figure:
    """Draw the bands of expected curves, before and after the calibration, and the measured one."""
    places = found.coordinates
    runs = ((places, values) for values in found.at_answer)
    return Figure(
        (
            band(places, found.prior_low, found.prior_high, "before the calibration", _QUIET_BAND),
            band(places, found.low, found.high, "95 % of measured curves, after it"),
            single_runs(runs, "runs at the answer", PURPLE, 1.2),
            line(places, found.predicted, "expected"),
            measured_points(places, found.measured, found.uncertainties),
        ),
        {
            "xaxis": coordinate_axis(found.coordinate, found.coordinate_unit, places),
            "yaxis": axis_of(title_of_curve(label.name), found.unit),
            "legend": LEGEND_ABOVE,
            "hovermode": "closest",
        },
        f"Bands of expected curves of {label.words} before the calibration and after it, runs at "
        f"the answer, and the measured points. {plain(found.in_words(label.name))}",
        height=400,
        title=escape(plain(label.name)),
    )
