"""A hold-out on LAMMPS: a bed of real particles is predicted by values of its material."""

from __future__ import annotations

from pathlib import Path

import pytest

import grainfit as gf
from grainfit.verdict.options import HOLDOUT

FILE = """\
name = "glass beads"
[particle]
diameter = "10 mm"
youngs_modulus = "1 MPa"
poissons_ratio = 0.22
density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }
[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"
[particle_particle]
sliding_friction = 0.4
rolling_friction = 0.1
restitution = 0.6
rolling_damping = 0
[particle_wall]
sliding_friction = 0.4
rolling_friction = 0.1
restitution = 0.6
rolling_damping = 0
[[test]]
type = "packing"
name = "small"
solver = "lammps"
cylinder_radius = "25 mm"
fill_height = "40 mm"
targets.bulk_density = { value = "1200 kg/m^3" }
[[holdout]]
type = "packing"
name = "taller"
solver = "lammps"
cylinder_radius = "25 mm"
fill_height = "60 mm"
"""
MEASURED = 'targets.bulk_density = {{ value = "{} kg/m^3", uncertainty = "1 %" }}\n'


@pytest.mark.slow
def test_real_beds_are_simulated_once_and_predicted(tmp_path: Path) -> None:
    path, material, kept = tmp_path / "beads.toml", tmp_path / "given.toml", tmp_path / "kept"
    material.write_text('[particle]\ndensity = "2000 kg/m^3"\n')
    path.write_text(FILE)
    first = gf.predict(path, answer_of=material, workdir=kept)["taller"]
    expected = first.responses["bulk_density"]
    assert (first.state, first.failed) == ("simulated", 0)
    assert first.runs == HOLDOUT.answer_seeds + HOLDOUT.prior_draws
    # About 0.57 of the volume is solid, and the density of the bed is as that of the particles.
    assert 0.5 < expected.predicted / 2000 < 0.62
    assert expected.prior[1] / expected.prior[0] == pytest.approx(2.0, abs=0.15)
    made = sorted((kept / "runs").iterdir())
    assert len(made) == first.runs
    for factor, verdict in ((1.0, "predicts"), (1.2, "does not predict")):
        path.write_text(FILE + MEASURED.format(factor * expected.predicted))
        again = gf.predict(path, answer_of=material, workdir=kept)["taller"]
        assert again.responses["bulk_density"].verdict == verdict
    assert sorted((kept / "runs").iterdir()) == made
