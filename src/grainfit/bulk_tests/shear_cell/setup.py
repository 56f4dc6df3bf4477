"""Geometry and procedure of a shear cell: what follows from its options and is possible."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grainfit.bulk_tests.shear.setup import DISPLACEMENT, ShearSetup
from grainfit.bulk_tests.shear_cell import messages
from grainfit.errors import Fault

#: Usual normal stresses at failure, and the largest, over that of the preshear.
_LOWEST, _HIGHEST, _LARGEST = 0.25, 0.75, 0.9
#: Time in which the load is reduced, over that of a shear strain of one.
_UNLOADING = 0.05


class ShearCellSetup(ShearSetup):
    """Geometry and procedure of a shear cell."""

    @property
    def usual_lowest(self) -> float:
        """Default of the lowest normal stress at failure, Pa."""
        return _LOWEST * self.normal_stress

    @property
    def usual_highest(self) -> float:
        """Default of the highest normal stress at failure, Pa."""
        return _HIGHEST * self.normal_stress

    @property
    def stresses(self) -> tuple[float, ...]:
        """Normal stresses at failure, Pa, the highest first, as with a tester."""
        return tuple(np.linspace(self.highest_stress, self.lowest_stress, self.points).tolist())

    @property
    def unloading_strain(self) -> float:
        """Shear strain for which the preshear would go on while the load is reduced."""
        return _UNLOADING

    def fault_stages(self) -> Iterator[list[Fault]]:
        """Iterate over what is impossible: the bed, then the procedure."""
        yield from super().fault_stages()
        yield [*self._procedure_faults()]

    def _procedure_faults(self) -> Iterator[Fault]:
        lowest, highest, stress = self.lowest_stress, self.highest_stress, self.normal_stress
        if lowest >= highest:
            yield messages.NOT_ASCENDING.fault(
                "lowest_stress", lowest=lowest, highest=highest, usual=self.usual_lowest
            )
        if highest > (1 + 1e-9) * _LARGEST * stress:
            yield messages.ABOVE_PRESHEAR.fault(
                "highest_stress",
                highest=highest,
                share=_LARGEST,
                stress=stress,
                most=_LARGEST * stress,
            )
        for name in ("preshear_strain", "failure_strain"):
            way = self.option(name) * self.gap
            if way > (1 + 1e-9) * DISPLACEMENT * self.length:
                yield messages.LONG_PRESHEAR.fault(
                    name,
                    way=way,
                    share=DISPLACEMENT,
                    length=self.length,
                    most=DISPLACEMENT * self.length / self.gap,
                )
