"""The report lists the particle diameters of the runs, a whole distribution too."""

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


def page(sizes: gf.ParticleSizes | None) -> str:
    test = {} if sizes is None else {"test": gf.tests.Packing(sizes).definition()}
    definition = RunDefinition({"solver": "lammps", **test}, {"particle.density": 2000.0}, 1)
    record = RunRecord(definition.identity, "packing", "finished", definition)
    made = context(PROBLEM, evaluations(PROBLEM, 4))
    reading = replace(made.reading, fixed=FIXED, records={record.identity: record})
    return str(answer(replace(made, reading=reading)).html)


def test_diameters_stand_with_the_fixed_parameters() -> None:
    distribution = gf.LogNormal(median="3 mm", geometric_standard_deviation=1.4)
    classes = page(gf.divide_into_classes(distribution))

    assert "1.85 mm, 2.5 mm, 3 mm, 3.58 mm, 4.75 mm, each 20 % of the mass" in classes
    assert "8 mm (30 % of the mass), 10 mm (70 %)" in page(
        gf.ParticleSizes((0.008, 0.010), (0.3, 0.7))
    )
    assert "particle diameters" not in page(None)
