"""Clumps whose spheres nearly coincide."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests.time_steps import least_stable
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.contact_models.hertz_mindlin.model import clump_factor
from grainfit.formatting import percent
from grainfit.materials.particle_shape import ASPECT_RATIO, NEAREST_CLUMP, ParticleShape

#: Aspect ratio below which the responses of soft particles differ from those of spheres (at 1).
_NEARLY_A_SPHERE = 1.1
#: Share of the usual time step that is too small to be no surprise.
_SLOW = 0.8


@check("near-spheres")
def near_spheres(context: FileContext) -> Iterator[Found]:
    """Clumps of a family whose spheres nearly coincide, which makes runs slow."""
    sizes = context.file.sizes
    shape = sizes.shape if sizes is not None else None
    if shape is None or not shape.has_aspect_ratio:
        return
    lowest = context.lowest.get(ASPECT_RATIO, 1.0)
    is_free = any(p.name == ASPECT_RATIO for p in context.problem.parameters)
    if lowest == 1 and not is_free:
        return
    share = _share_of_time_step(shape, lowest, least_stable(context.intervals))
    if share >= _SLOW:
        return
    found = messages.NEAR_SPHERES(
        key=ASPECT_RATIO,
        lowest=f"{lowest:g}{' and more' if is_free else ''}",
        family=shape.family,
        jump=f"{messages.STIFFER_THAN_SPHERES()} " if lowest < _NEARLY_A_SPHERE else "",
        share=percent(share),
    )
    yield ASPECT_RATIO, found


def _share_of_time_step(
    shape: ParticleShape, aspect_ratio: float, material: Mapping[str, float]
) -> float:
    clump = shape.with_aspect_ratio(max(aspect_ratio, NEAREST_CLUMP)).clump
    assert clump is not None
    stiffer = clump.rayleigh_radius / clump.smallest_radius
    return stiffer * clump_factor(material, clump.touching)
