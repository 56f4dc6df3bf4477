"""Prime seeds, and the reason of an abort: what a LIGGGHTS deck of one's own needs."""

from __future__ import annotations

from math import isqrt
from pathlib import Path

import pytest

import needs
from grainfit.errors import RunFailedError
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.prime_seed import prime_seeds

DECK = """\
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
region reg block -0.05 0.05 -0.05 0.05 0. 0.15 units box
create_box 1 reg
neighbor 0.002 bin
fix m1 all property/global youngsModulus peratomtype 5.e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.95
fix m4 all property/global coefficientFriction peratomtypepair 1 {{ friction }}
pair_style gran model hertz tangential history
pair_coeff * *
timestep 0.00001
fix pts1 all particletemplate/sphere {{ prime_seed_3 }} atom_type 1 density constant 2500 &
  radius constant 0.005
fix pdd1 all particledistribution/discrete {{ prime_seed_2 }} 1 pts1 1.0
region inside block -0.04 0.04 -0.04 0.04 0.02 0.14 units box
fix ins all insert/pack seed {{ INSERTION }} distributiontemplate pdd1 vel constant 0. 0. -0.5 &
  insert_every once overlapcheck yes all_in yes particles_in_region 20 region inside
fix integr all nve/sphere
run 1
variable count equal atoms
variable place equal x[1]
run 0
print '{"count": ${count}, "place": ${place}}' file responses.json
"""


def is_prime(number: int) -> bool:
    return number > 1 and all(number % d for d in range(2, isqrt(number) + 1))


def test_they_are_different_primes_that_liggghts_and_lammps_take() -> None:
    found = [prime for seed in (*range(1, 60), 899_999_999) for prime in prime_seeds(seed).values()]
    assert len(set(found)) == len(found)
    assert all(10_000 < prime <= 900_000_000 and is_prime(prime) for prime in found)
    # The same seed has the same primes in every version: they decide the outcome of its run.
    assert prime_seeds(1)["prime_seed"] == 556122797


def liggghts(folder: Path, insertion: str) -> Command:
    folder.mkdir()
    (folder / "in.deck.j2").write_text(DECK.replace("INSERTION", insertion))
    return Command(folder, ["liggghts", "-in", "in.deck"])


def run(solver: Command, parent: Path, seed: int) -> dict[str, float]:
    folder = parent / f"run {seed}"
    folder.mkdir()
    responses = solver.run({"friction": 0.3}, seed, Workspace(folder, 60.0))
    return {name: response.value for name, response in responses.items()}


@needs.LIGGGHTS
class TestLiggghts:
    def test_it_inserts_with_prime_seeds_differently_for_each_seed(self, tmp_path: Path) -> None:
        solver = liggghts(tmp_path / "model", "prime_seed")
        first, second = (run(solver, tmp_path, seed) for seed in (1, 2))
        assert first["count"] == second["count"] == 20
        assert first["place"] != second["place"]

    def test_the_reason_of_its_abort_is_not_lost(self, tmp_path: Path) -> None:
        solver = liggghts(tmp_path / "model", "seed")
        with pytest.raises(RunFailedError) as caught:
            run(solver, tmp_path, 7)
        assert "the random seed value is > 10000 and a prime number" in caught.value.reason
        assert "possible valid seeds" in caught.value.log_tail


def test_python_that_is_killed_leaves_the_lines_that_it_has_printed(tmp_path: Path) -> None:
    folder = tmp_path / "model"
    folder.mkdir()
    (folder / "model.py").write_text(
        "import os, signal\n# parameters.json\nprint('the drum broke')\n"
        "os.kill(os.getpid(), signal.SIGSEGV)\n"
    )
    with pytest.raises(RunFailedError) as caught:
        run(Command(folder, ["python3", "model.py"]), tmp_path, 1)
    assert "the drum broke" in caught.value.log_tail
    assert "SIGSEGV" in caught.value.reason
