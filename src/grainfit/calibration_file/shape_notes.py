"""Notes on clumps whose spheres nearly coincide."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.calibration_file.content import CalibrationFile
from grainfit.materials.particle_shape import ASPECT_RATIO

#: Aspect ratio up to which several spheres of a clump touch the same particle at once.
_NEARLY_A_SPHERE = 1.1


def shape_notes(file: CalibrationFile) -> Iterator[str]:
    """Yield a note on clumps of a family that come near a sphere.

    Parameters
    ----------
    file : CalibrationFile
        The calibration file.
    """
    shape = file.sizes.shape if file.sizes is not None else None
    if shape is None or not shape.has_aspect_ratio:
        return
    free = {p.name: p.minimum for p in file.parameters}
    lowest = {**file.fixed, **free}.get(ASPECT_RATIO, 1.0)
    if lowest >= _NEARLY_A_SPHERE or (lowest == 1 and ASPECT_RATIO not in free):
        return
    yield (
        f"{ASPECT_RATIO} is {lowest:g}{' and more' if ASPECT_RATIO in free else ''}: below "
        f"{_NEARLY_A_SPHERE:g}, spheres of the shape {shape.family} nearly coincide and touch at "
        "once, which makes clumps stiffer than spheres and runs longer, so that the responses of "
        f"soft particles jump where it becomes 1. Begin at {_NEARLY_A_SPHERE:g} "
        "(docs/clumps.md)."
    )
