"""A distribution of five classes in real runs: every class is there, with its share of the mass."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
import needs
from grainfit.bulk_tests.packing import Packing
from grainfit.scenes.packing import particle_numbers
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS

SIZES = gf.divide_into_classes(gf.LogNormal(median="3 mm", geometric_standard_deviation=1.3))


@pytest.mark.parametrize("solver", ["lammps", pytest.param("liggghts", marks=needs.LIGGGHTS)])
def test_every_class_has_its_share_of_the_mass(tmp_path: Path, solver: str) -> None:
    test = Packing(SIZES, cylinder_radius="9 mm", fill_height="15 mm", bulk_density_top="11 mm")
    program = DEM_PROGRAMS[solver](test, GLASS_BEADS)
    scene = test.scene(program.run_parameters({}), seed=1)
    output = program.simulate(scene, Workspace(tmp_path, 600.0))

    responses = test.measure(output)
    bed = output.snapshot("bed")
    assert len(bed) == test.number_of_particles
    masses = [
        bed.masses[np.isclose(2 * bed.radii, diameter, rtol=1e-4)].sum()
        for diameter in SIZES.diameters
    ]
    assert sum(masses) == pytest.approx(bed.masses.sum())
    # As near to equal shares as whole particles are.
    volumes = np.array(SIZES.diameters) ** 3
    nearest = particle_numbers(SIZES, len(bed)) * volumes
    assert masses / sum(masses) == pytest.approx(nearest / nearest.sum(), rel=1e-3)
    assert masses / sum(masses) == pytest.approx(SIZES.mass_fractions, rel=0.1)
    assert 0.5 < responses["bulk_density"].value / GLASS_BEADS["particle.density"] < 0.7
