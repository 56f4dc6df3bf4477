"""Picture of a packing: the half of the bed behind the axis."""

from __future__ import annotations

from pathlib import Path

from grainfit.bulk_tests.packing.setup import PackingSetup
from grainfit.bulk_tests.shared.pot_view import PotView
from grainfit.evaluation import Response
from grainfit.measurement.sheet import OVERSAMPLING, sheet

_PANEL_WIDTH = 560 * OVERSAMPLING


def draw_packing(path: Path, view: PotView, setup: PackingSetup, measured: Response | str) -> None:
    """Write a PNG of the bed.

    Parameters
    ----------
    path : Path
        File to write; ends in ``.png``.
    view : PotView
        The bed.
    setup : PackingSetup
        Geometry of the test.
    measured : Response or str
        The bulk density, or the reason why there is none.
    """
    if isinstance(measured, str):
        title, subtitle = "Bulk density: not measurable", measured
    else:
        title = f"Bulk density {measured.value:.0f} ± {measured.standard_error:.0f} kg/m^3"
        subtitle = f"± standard error; {setup.measured_heights}; the half behind the axis is shown"
    panel = view.side_view().panel(_PANEL_WIDTH)
    sheet(title, subtitle, [panel], _PANEL_WIDTH).save(path)
