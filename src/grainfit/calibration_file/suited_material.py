"""Starting materials whose particles suit given instruments: few enough, and stiff enough."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from grainfit.bulk_tests.abilities import material_faults
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.instrument import Instrument
from grainfit.bulk_tests.parameter_names import MODULUS
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.calibration_file import messages
from grainfit.errors import InputError
from grainfit.materials.starting_materials import StartingMaterial
from grainfit.materials.starting_values import StartingValue
from grainfit.units import to_unit

#: Young's moduli to choose from where an instrument needs stiff particles, Pa.
_ROUND_MODULI = [digit * 10.0**power for power in (6, 7, 8) for digit in (1, 2, 5)]
#: Factors to choose from where an instrument holds more particles than can be simulated.
_ROUND_FACTORS = (1.0, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 80, 100)
#: Particles of a run that takes minutes.
_FEW = 20_000


def suited_to(
    material: StartingMaterial, kinds: Sequence[str], instruments: Mapping[str, Instrument]
) -> StartingMaterial:
    """Return the material with particles that a run of every test can have.

    Where an instrument holds more of the real ones than can be simulated, simulated ones are
    larger; where its stress would compress them instead of the bed, they are stiffer.

    Parameters
    ----------
    material : StartingMaterial
        What a file begins with.
    kinds : sequence of str
        Bulk tests of the file that are in their usual apparatus.
    instruments : mapping of str to Instrument
        Those of the file by name.

    Raises
    ------
    InputError
        The particles do not fit an instrument.
    """
    options: list[tuple[str, Mapping[str, Any]]] = [(kind, {}) for kind in kinds]
    options += [(one.type, one.values) for one in instruments.values()]
    diameter = material.sections["particle"]["diameter"].value
    factor, tests = _few_enough(diameter, options)
    if factor > 1:
        source = messages.ENLARGED_PARTICLES(
            names=", ".join(instruments),
            factor=factor,
            count=most_particles(tests),
        )
        material = _with_value(material, "coarse_graining", StartingValue(factor, source))
    return _stiff_enough(material, tests[len(kinds) :])


def _few_enough(
    diameter: Any, options: Sequence[tuple[str, Mapping[str, Any]]]
) -> tuple[float, list[BulkTest]]:
    """Return the tests with the real particles, or with larger ones, and their factor."""
    known = bulk_tests()
    sizes = known["packing"](diameter=diameter).sizes

    def tests(factor: float) -> list[BulkTest]:
        simulated = sizes.coarse_grained(factor)
        found = [known[kind](simulated, **values) for kind, values in options]
        InputError.raise_for(fault for test in found for fault in material_faults(test, {}))
        return found

    # Where no factor is possible, the faults are those of the real particles.
    factor = factor_for_few(lambda factor: most_particles(tests(factor))) or 1.0
    return factor, tests(factor)


def factor_for_few(count: Callable[[float], int]) -> float | None:
    """Return how many times as large particles are simulated where the real ones are too many.

    That is 1 if they are not; else the smallest round factor with which runs take minutes, or the
    largest possible one; None if no factor is.

    Parameters
    ----------
    count : callable
        Returns the particles of the largest test at a factor; raises `InputError` if a test is
        impossible with it.
    """
    found = None
    for factor in _ROUND_FACTORS:
        try:
            few = count(factor) <= _FEW
        except InputError:
            continue
        found = factor
        if few or factor == 1:
            break
    return found


def most_particles(tests: Iterable[BulkTest]) -> int:
    """Return the particles of the test that has most."""
    return max((test.number_of_particles for test in tests), default=0)


def _stiff_enough(material: StartingMaterial, tests: Sequence[BulkTest]) -> StartingMaterial:
    """Return the material, with a modulus that bears the stresses that instruments prescribe."""
    given = material.sections["particle"]["youngs_modulus"]
    usual = to_unit(str(given.value), "Pa")

    def is_too_soft(modulus: float) -> bool:
        return any(any(material_faults(t, {MODULUS: modulus})) for t in tests)

    moduli = [usual, *(m for m in _ROUND_MODULI if m > usual)]
    enough = next((modulus for modulus in moduli if not is_too_soft(modulus)), usual)
    if enough == usual:
        return material
    source = messages.RAISED_MODULUS(source=given.source, usual=given.value)
    return _with_value(material, "youngs_modulus", StartingValue(f"{enough / 1e6:g} MPa", source))


def _with_value(material: StartingMaterial, key: str, value: StartingValue) -> StartingMaterial:
    particle = {**material.sections["particle"], key: value}
    return replace(material, sections={**material.sections, "particle": particle})
