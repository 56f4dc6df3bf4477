"""Bulk densities that no density of the particles within its interval can give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.parameter_names import DENSITY, MODULUS
from grainfit.bulk_tests.stiffness import overlap_law, stiffness_number
from grainfit.calibration_file.checks import messages
from grainfit.checks import Found, check
from grainfit.contact_models.registry import COHESION
from grainfit.evaluation import response_name
from grainfit.formatting import number, rounded_off
from grainfit.materials.walls import plain_name
from grainfit.problem import Target
from grainfit.solvers.check_context import CheckContext

#: Solid fractions of beds of equal spheres that are possible at all. Above: the densest packing of
#: equal spheres, pi/sqrt(18) (Hales, Annals of Mathematics 162, 2005). Below: far under random
#: loose packing, 0.555 (Onoda & Liniger, Physical Review Letters 64, 1990), which rolling friction
#: loosens further.
_LOOSEST, _DENSEST = 0.35, 0.7405
#: Solid fractions of poured beds, from below random loose packing to above random close packing,
#: 0.64 (Scott & Kilgour, Journal of Physics D 2, 1969), for the interval that is proposed.
_USUAL = (0.52, 0.66)
#: Ratio of the largest to the smallest diameter up to which small particles hardly fill gaps.
_NEARLY_EQUAL = 2.0
#: Solid fractions that are this many times off are due to a unit.
_OTHER_UNIT = 10.0
_BULK_DENSITY = "bulk_density"


@check("impossible-bulk-density", "warning")
def impossible_bulk_density(context: CheckContext) -> Iterator[Found]:
    """Bulk densities that no density of the particles within its interval can give.

    Nothing is said of clumps, which pack more densely than spheres, of very loose beds of cohesive
    particles, and of very dense ones of different sizes.
    """
    ends = context.intervals
    if DENSITY not in ends or min(ends[DENSITY]) <= 0:
        return
    targets = {target.name: target for target in context.problem.targets}
    for name, test in context.bulk_tests.items():
        target = targets.get(response_name(name, _BULK_DENSITY, len(context.solvers)))
        if target is not None and _BULK_DENSITY in test.responses and test.sizes.shape is None:
            key = context.key(name, f"targets.{_BULK_DENSITY}")
            yield from ((key, note) for note in _note(target, test, ends))


def _note(target: Target, test: BulkTest, ends: Mapping[str, tuple[float, float]]) -> Iterator[str]:
    lightest, heaviest = ends[DENSITY]
    most = 1 + _excess(test, {n: e[0] for n, e in ends.items()} | {DENSITY: heaviest})
    diameters = test.sizes.diameters
    is_dense = (target.value - target.tolerance) / (heaviest * most) > _DENSEST
    is_loose = (target.value + target.tolerance) / lightest < _LOOSEST
    if is_dense and max(diameters) <= _NEARLY_EQUAL * min(diameters):
        fraction, limit = target.value / (heaviest * most), messages.DENSEST(limit=_DENSEST)
    elif is_loose and not _is_cohesive(ends):
        fraction, limit = target.value / lightest, messages.LOOSEST(limit=_LOOSEST)
    else:
        return
    is_free = lightest < heaviest
    within = "even the " + ("heaviest" if is_dense else "lightest") if is_free else "the given"
    proposed = tuple(target.value / (share * most) for share in reversed(_USUAL))
    low, high = rounded_off(proposed[0], 2, up=False), rounded_off(proposed[1], 2, up=True)
    is_possible = _LOOSEST / _OTHER_UNIT < fraction < _DENSEST * _OTHER_UNIT
    yield messages.IMPOSSIBLE_BULK_DENSITY(
        target=target.name,
        value=target.value,
        within=within,
        density=heaviest if is_dense else lightest,
        fraction=number(fraction, 2),
        limit=limit,
        remedy=messages.USUAL_DENSITY(key=DENSITY, usual=_USUAL, low=low, high=high)
        if is_possible
        else messages.ANOTHER_UNIT(),
    )


def _excess(test: BulkTest, material: Mapping[str, float]) -> float:
    """Return the bulk density that overlaps of soft particles add, as a share."""
    if material.get(MODULUS, 0.0) <= 0:
        return 0.0
    return overlap_law(test).excess(stiffness_number(test, material))


def _is_cohesive(ends: Mapping[str, tuple[float, float]]) -> bool:
    return any(max(found) > 0 for name, found in ends.items() if plain_name(name) in COHESION)
