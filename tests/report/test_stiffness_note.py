"""The report says by how much soft particles raise the responses of its answer."""

from __future__ import annotations

from dataclasses import replace

from contexts import context, evaluations

import grainfit as gf
from grainfit.campaign.store.records import RunRecord
from grainfit.report.sections.answer.section import answer
from grainfit.run_definition import RunDefinition
from grainfit.testing.materials import GLASS_BEADS

PROBLEM = gf.Problem(
    [gf.Parameter("particle.density", 1400, 2800, unit="kg/m^3")],
    [gf.Target("bulk_density", 10.0, tolerance=0.3, unit="kg/m^3")],
)
FIXED = {name: value for name, value in GLASS_BEADS.items() if name != "particle.density"}


def page(modulus: float, *, simulated: bool = True) -> str:
    fixed = {**FIXED, "particle.youngs_modulus": modulus}
    test = gf.tests.Heap(diameter="10 mm").definition()
    model = {"solver": "lammps", **({"test": test} if simulated else {})}
    definition = RunDefinition(model, {**fixed, "particle.density": 2000.0}, 1)
    record = RunRecord(definition.identity, "heap", "finished", definition)
    made = context(PROBLEM, evaluations(PROBLEM, 4))
    reading = replace(made.reading, fixed=fixed, records={record.identity: record})
    return str(answer(replace(made, reading=reading)).html)


def test_soft_particles_are_named_with_the_excess_at_the_answer() -> None:
    # The answer is 0.4 of the interval, 1960 kg/m^3, where E/(rho g d) = 1872.
    assert "E/(ρ g d) = 1870: bulk_density is about 13 % above" in page(3.6e5)
    assert "2 % with 6.6 MPa" in page(3.6e5)


def test_stiff_particles_and_models_of_the_user_are_not() -> None:
    assert "E/(ρ g d)" not in page(3.6e8)
    assert "E/(ρ g d)" not in page(3.6e5, simulated=False)
