"""Classes of sizes of which a test has only a few particles."""

from __future__ import annotations

from collections.abc import Iterator

from grainfit.bulk_tests.abilities import is_of_user
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.context import FileContext
from grainfit.checks import Found, check
from grainfit.formatting import counted, millimetres, percent
from grainfit.scenes.packing import particle_numbers

#: Particles of a diameter below which their share of the mass is a matter of chance.
_FEW = 10


@check("few-particles", "warning")
def few_particles(context: FileContext) -> Iterator[Found]:
    """Classes of sizes of which a test has only a few particles."""
    for name, test in context.bulk_tests.items():
        if is_of_user(test) or len(test.sizes.diameters) == 1:
            continue
        numbers = particle_numbers(test.sizes, test.number_of_particles)
        fewest = min(range(len(numbers)), key=lambda i: numbers[i])
        if numbers[fewest] >= _FEW:
            continue
        yield (
            "particle.diameter",
            messages.FEW_PARTICLES(
                test=name,
                particles=counted(numbers[fewest], "particle"),
                diameter=millimetres(test.sizes.real.diameters[fewest]),
                share=percent(test.sizes.mass_fractions[fewest]),
            ),
        )
