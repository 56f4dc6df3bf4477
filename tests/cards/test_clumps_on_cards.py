"""Cards of materials whose particles are clumps carry the clump."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from grainfit.bulk_tests.heap import Heap
from grainfit.cards import MaterialCard, render
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.solvers.dem.lammps.program import Lammps

SIZES = ParticleSizes((0.010,), shape=ParticleShape("grain", aspect_ratio=1.8))


@pytest.fixture
def clumps(card: MaterialCard) -> MaterialCard:
    return replace(card, sizes=SIZES)


def block(text: str, first: str, last: str) -> str:
    """Return the comments of a card between two lines, as they are to be copied."""
    lines = [line.removeprefix("#").removeprefix("     ") for line in text.splitlines()]
    begin = next(n for n, line in enumerate(lines) if first in line)
    end = next(n for n, line in enumerate(lines) if n > begin and last in line)
    return "\n".join(lines[begin + 1 : end])


def test_lammps_reads_the_molecule_of_a_card(clumps: MaterialCard, tmp_path: Path) -> None:
    text = render(clumps, "lammps")
    (tmp_path / "clump.mol").write_text("clump\n\n" + block(text, "reinit no", "--- values"))
    (tmp_path / "card").write_text(text)
    deck = (
        "units si\natom_style sphere\natom_modify map array\nboundary f f f\nnewton off\n"
        "comm_modify vel yes cutoff 0.1\n"
        "fix property all property/atom mol ghost yes\n"
        "region box block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box\ncreate_box 4 box\n"
        "include card\npair_style granular\n"
        "neigh_modify exclude molecule/intra all\n"
        + "".join(
            f"pair_coeff {i} {j} ${{particle_particle_contact_{i}_{j}}}\n"
            for i in range(1, 5)
            for j in range(i, 5)
        )
        + "molecule clump clump.mol\n"
        "region here block -0.02 0.02 -0.02 0.02 -0.02 0.02 units box\n"
        "fix motion all rigid/small molecule mol clump reinit no\n"
        "fix insert all deposit 1 0 1 12345 region here mol clump rigid motion units box\n"
        "compute body all rigid/local motion mass inertiax inertiay inertiaz\n"
        "compute all_bodies all reduce sum c_body[1] c_body[2] c_body[3] c_body[4] "
        "inputs local\n"
        "thermo_style custom step c_all_bodies[*]\nthermo_modify norm no format float %.12g\n"
        "timestep 1e-6\nrun 2 post no\nrun 0\n"
    )
    (tmp_path / "in.card").write_text(deck)
    program = Lammps(Heap(diameter="10 mm"), {})._program()
    done = subprocess.run(
        [program, "-in", "in.card", "-nocite"], cwd=tmp_path, capture_output=True, text=True
    )

    assert done.returncode == 0, done.stdout[-800:]
    lines = done.stdout.splitlines()
    heads = [n for n, line in enumerate(lines) if line.split()[:1] == ["Step"]]
    _, mass, *moments = map(float, lines[heads[-1] + 1].split())
    clump = SIZES.clump
    assert clump is not None
    density = clumps.values["particle.density"]
    expected = density * 3.141592653589793 / 6 * 0.01**3
    assert mass == pytest.approx(expected, rel=1e-9)
    assert sorted(moments) == pytest.approx(
        sorted(expected * 0.01**2 * moment for moment in clump.moments), rel=1e-6
    )


def test_every_card_has_the_spheres(clumps: MaterialCard) -> None:
    clump = SIZES.clump
    assert clump is not None
    found = json.loads(render(clumps, "json"))["particle_shape"]

    assert [sphere["radius"] for sphere in found["spheres"]] == clump.radii.tolist()
    assert found["moments_of_inertia"] == list(clump.moments)
    for to in ("lammps", "liggghts", "yade"):
        text = render(clumps, to)
        assert "clumps of spheres: grain, aspect ratio 1.8" in text
        assert all(line.startswith("#") for line in text.splitlines() if "multisphere" in line)
    assert "particletemplate/multisphere" in render(clumps, "liggghts")
    assert "appendClumped" in render(clumps, "yade")


def test_cards_of_spheres_say_nothing_of_clumps(card: MaterialCard) -> None:
    assert json.loads(render(card, "json"))["particle_shape"] is None
    assert all("clump" not in render(card, to) for to in ("lammps", "liggghts", "yade"))
