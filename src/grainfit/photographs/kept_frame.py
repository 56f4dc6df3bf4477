"""The frame of a turning drum that a report shows: upright, its bed rising to the right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from grainfit.arrays import Array
from grainfit.photographs.drum import DrumSeries
from grainfit.photographs.kept import COPY_WIDTH, KeptPicture, rounded, write_copy
from grainfit.photographs.pictures import opencv

#: Half the width of a copy, in radii of the drum.
_BESIDE = 1.2


def keep_frame(
    kept: KeptPicture,
    found: DrumSeries,
    parts: Mapping[str, float],
    angles: Mapping[str, tuple[float, float]],
    folder: Path,
) -> KeptPicture:
    """Add what was measured on a video or on stills, and write an upright copy of its first frame.

    Parameters
    ----------
    kept : KeptPicture
        With its name and its hash.
    found : DrumSeries
        What was measured.
    parts : dict
        Standard uncertainties of its dynamic angle by their source, degrees.
    angles : dict
        Angles of all videos and stills together, with their standard uncertainties, degrees.
    folder : Path
        Where the copy is written.
    """
    radius = COPY_WIDTH / (2 * _BESIDE)
    of_drum = radius / found.angles.bed.radius
    copy = opencv().warpAffine(
        found.shown,
        found.circle.turned(radius, COPY_WIDTH, found.level),
        (COPY_WIDTH, COPY_WIDTH),
        borderMode=opencv().BORDER_REPLICATE,
    )
    write_copy(copy if found.rises_right else np.fliplr(copy), folder, kept.name)
    across, heights = of_drum * np.array(found.angles.surface.places()).T
    flanks = found.angles.flanks().values()
    half = COPY_WIDTH / 2
    return replace(
        kept,
        angle=found.responses["dynamic_angle"].value,
        parts=parts,
        outline=(rounded(across), rounded(heights)),
        shown=(-half, half, -half, half),
        drum_radius=radius,
        is_mirrored=not found.rises_right,
        lines=tuple(_ends(of_drum * np.array([one.start, one.end])) for one in flanks),
        angles=angles,
        frames=len(found.angles.bed.heights),
    )


def _ends(line: Array) -> tuple[float, float, float, float]:
    x1, y1, x2, y2 = rounded(line.ravel())
    return x1, y1, x2, y2
