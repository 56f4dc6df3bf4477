"""Intervals in Python whose ends no material has, as calibration files refuse them."""

from __future__ import annotations

import pytest

from grainfit.bulk_tests.packing import Packing
from grainfit.errors import InputError
from grainfit.solvers.dem import messages
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import GLASS_BEADS


@pytest.mark.parametrize(
    ("name", "interval", "bad"),
    [
        ("particle_particle.restitution", (0.6, 1.4), 1.4),
        ("particle.density", (-2000.0, 2800.0), -2000.0),
        ("particle_wall.sliding_friction", (-0.1, 0.5), -0.1),
    ],
)
def test_an_impossible_end_is_refused(name: str, interval: tuple[float, float], bad: float) -> None:
    solver = Lammps(Packing(diameter="10 mm"), {n: v for n, v in GLASS_BEADS.items() if n != name})

    with pytest.raises(InputError) as caught:
        solver.within({name: interval})

    [fault] = caught.value.faults
    assert fault.key == name
    assert messages.OUTSIDE_LIMITS.is_in(str(fault), value=bad)
