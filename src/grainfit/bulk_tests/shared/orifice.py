"""An orifice in diameters of the particles: arches may block a narrow one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.shared import messages
from grainfit.checks import Check, Found
from grainfit.errors import Fault
from grainfit.formatting import millimetres, number
from grainfit.materials.particle_shape import ASPECT_RATIO
from grainfit.materials.sizes import ParticleSizes

#: Width below which arches may block an orifice, in largest extents of the largest particles.
ARCHES = 4.0
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Orifice:
    """A slot or a hole in a floor.

    Parameters
    ----------
    option : str
        Option of the test with its width.
    words : str
        ``"a slot"`` or ``"an orifice"``.
    width : float
        m.
    """

    option: str
    words: str
    width: float

    def passing_faults(self, sizes: ParticleSizes) -> Iterator[Fault]:
        """Iterate over why the largest particles do not pass; a slender clump may."""
        largest = max(sizes.diameters)
        if self.width > largest:
            return
        yield messages.NO_PARTICLE_PASSES.fault(
            self.option,
            largest=largest,
            opening=self.words,
            width=self.width,
            arches=ARCHES,
            least=ARCHES * largest,
        )

    def coarse_graining_faults(self, sizes: ParticleSizes) -> Iterator[Fault]:
        """Iterate over why enlarged particles arch where the real ones may flow."""
        if sizes.coarse_graining == 1 or not self._is_narrow(sizes):
            return
        if sizes.shape is not None and sizes.clump is None:
            # Of an aspect ratio that is free, the largest one decides.
            return
        largest = max(sizes.outer_diameters)
        least = f"{self.words} of at least {ARCHES * largest:.4g} m"
        # Rounded down: the factor that is named must be accepted.
        factor = math.floor(100 * self._diameters(sizes.real) / ARCHES * (1 + _ROUNDING)) / 100
        use = f"Use particle.coarse_graining = {factor:g} at most"
        yield messages.ENLARGED_PARTICLES_ARCH.fault(
            self.option,
            opening=self.words,
            width=self.width,
            times=number(self._diameters(sizes), 3),
            largest=largest,
            arches=ARCHES,
            way_out=use if factor > 1 else "Leave particle.coarse_graining out",
            least=least,
        )

    def arching_notes(self, sizes: ParticleSizes) -> Iterator[Found]:
        """Iterate over a note on real particles that may arch."""
        if sizes.coarse_graining == 1 and self._is_narrow(sizes):
            yield (
                self.option,
                messages.MAY_ARCH(
                    opening=self.words,
                    width=millimetres(self.width),
                    times=number(self._diameters(sizes), 3),
                    largest=millimetres(max(sizes.outer_diameters)),
                    arches=ARCHES,
                ),
            )

    def _diameters(self, sizes: ParticleSizes) -> float:
        """Return the width in largest extents of the largest particles."""
        return self.width / max(sizes.outer_diameters)

    def _is_narrow(self, sizes: ParticleSizes) -> bool:
        return self._diameters(sizes) < ARCHES * (1 - _ROUNDING)


def narrow_orifice(orifice_of: Callable[[Any], Orifice]) -> Check[CheckedTest[Any]]:
    """Return the check of the orifice of a test.

    Parameters
    ----------
    orifice_of : callable
        Returns the orifice of a test.
    """

    def find(checked: CheckedTest[Any]) -> Iterator[Found]:
        # The most slender particles are the widest.
        sizes = checked.test.sizes.with_aspect_ratio(checked.highest.get(ASPECT_RATIO))
        return orifice_of(checked.test).arching_notes(sizes)

    about = "Orifices so narrow that particles may arch over them."
    return Check("narrow-orifice", "warning", about, find)
