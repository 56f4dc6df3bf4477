"""The benchmarks with published figures: records that come out again, and a page that has them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import needs
from grainfit.contact_models.hertz_mindlin.model import hertz_stiffness, particle_moduli
from grainfit.measurement.particles import Particles
from grainfit.testing.simulated_scenes import material
from studies.benchmarks import comparisons, disagreement, evidence, gas, packings, shear
from studies.benchmarks.gas import Gas, all_gases
from studies.benchmarks.impacts import SPINS, Run, all_runs, simulate
from studies.benchmarks.page import kept_records, page, readme

KEPT = kept_records()
RECORDS, GASES = KEPT.impacts, KEPT.gases
SOLVERS = [
    "lammps",
    pytest.param("liggghts", marks=needs.LIGGGHTS),
    pytest.param("yade", marks=[needs.YADE, pytest.mark.slow]),
]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("test", "body"), [(4, "oxide"), (6, "al_alloy"), (7, "copper")])
def test_impacts_come_out_as_they_are_kept(solver: str, test: int, body: str) -> None:
    (run,) = [r for r in all_runs([solver]) if (r.test, r.body) == (test, body)]
    found = simulate(run)["found"]
    for key, values in RECORDS[run]["found"].items():
        scale = float(np.ptp(values)) or 1.0
        assert found[key] == pytest.approx(values, abs=1e-3 * scale)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_gas_cools_as_it_is_kept(solver: str) -> None:
    run = Gas(solver, 0.9, 1)
    found = gas.simulate(run)
    assert found["rate"] == pytest.approx(GASES[run]["rate"], rel=0.02)
    assert found["growth"] <= 0


def test_a_gas_that_cools_by_haffs_law_has_its_rate() -> None:
    run = Gas("lammps", 0.9, 1)
    records = {
        run._replace(seed=s): {"rate": gas.haff_rate(0.9) * f} for s, f in ((1, 0.9), (2, 1))
    }
    mean, half = gas.cooling(records, "lammps")
    assert mean == pytest.approx(0.95)
    assert half == pytest.approx(12.706 * 0.05, rel=1e-3)


def test_a_cubic_lattice_has_six_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packings, "WIDTH", 8 * 0.999)
    along = 0.999 * (np.arange(8) + 0.5)
    places = np.array(np.meshgrid(along, along, along)).reshape(3, -1).T * packings.DIAMETER
    ones = np.ones(len(places))
    found = packings.measured(Particles(places, ones * packings.DIAMETER / 2, 1e-3 * ones))
    assert found["overlap"] == pytest.approx(0.001)
    assert found["coordination"] == 6
    assert found["solid_fraction"] == pytest.approx(np.pi / 6 / 0.999**3, rel=0.01)
    assert found["order"] > packings.ORDERED
    assert packings.order_of(np.eye(3)) == pytest.approx(8**-0.5)


def test_the_pressure_of_a_cubic_lattice_is_force_over_area() -> None:
    side = 0.998 * shear.DIAMETER
    along = side * (np.arange(12) + 0.5)
    places = np.array(np.meshgrid(along, along, along)).reshape(3, -1).T
    bed = Particles(places, np.full(len(places), shear.DIAMETER / 2), np.ones(len(places)))
    values = {**material(), "particle.youngs_modulus": shear.MODULUS}
    moduli = particle_moduli(values, "particle")
    overlap = shear.DIAMETER - side
    force = hertz_stiffness(overlap, moduli, shear.DIAMETER / 4) * overlap
    found = shear.mean_pressure(bed, (12 * side, 12 * side), values)
    assert found == pytest.approx(force / side**2, rel=0.01)


def test_the_limit_of_no_inertia_of_known_shear() -> None:
    records = {}
    for friction, exponent in ((0.0, 0.4), (0.5, 1.0)):
        for number in shear.CURVE:
            ratio = 0.3 + 0.5 * number**exponent
            records[shear.Sheared("lammps", friction, number, 1)] = {
                "angle": shear.angle_of(ratio),
                "error": 0.1,
                "solid_fraction": (0.6 - 0.3 * number) * (1 + shear.OVERLAP),
                "pressure": 0.9,
            }
        found = shear.limit(records, "lammps", friction)
        assert found is not None
        assert found.ratio == pytest.approx(0.3, abs=1e-4)
        assert found.exponent == pytest.approx(exponent, abs=1e-3)
        assert found.angle == pytest.approx(shear.angle_of(0.3 / 0.9), abs=0.02)
        assert found.solid_fraction == pytest.approx(0.6)


def test_all_beds_are_kept() -> None:
    solvers = ("lammps", "liggghts", "yade")
    assert set(GASES) == set(all_gases(solvers))
    assert set(KEPT.packings) == set(packings.all_packings(solvers))
    assert set(KEPT.sheared) == set(shear.all_sheared(solvers))


def test_all_impacts_of_three_solvers_are_kept() -> None:
    assert set(RECORDS) == set(all_runs(("lammps", "liggghts", "yade")))
    assert len(RECORDS[Run("yade", 7, "copper", 0.5)]["found"]["spin_share"]) == 2 * len(SPINS)


def test_the_page_and_the_table_of_the_readme_are_those_of_the_records() -> None:
    written = (evidence.ROOT / "docs" / "studies" / "benchmarks.md").read_text(encoding="utf-8")
    table = (evidence.ROOT / "README.md").read_text(encoding="utf-8")
    words = "Run: python -m studies.benchmarks page"
    assert written == page(KEPT), words
    assert table == readme(KEPT), words


def test_a_deviation_beyond_the_tolerance_is_bold() -> None:
    rows = {(r.comparison.test, r.comparison.reference): r for r in comparisons.rows(RECORDS)}
    sliding = rows[5, comparisons.SLIDING]
    assert sliding.is_met("lammps")
    assert not sliding.is_met("yade")
    by_name = {row.benchmark: row.results for row in evidence.evidence(KEPT)}
    assert "**" not in str(by_name["recoil (test 5), sliding"]["lammps"])
    assert str(by_name["recoil (test 5), sliding"]["yade"]).startswith("**")


def test_a_solver_that_has_not_been_run_is_left_out() -> None:
    some = {run: record for run, record in RECORDS.items() if run.solver == "lammps"}
    assert all(set(row.deviations) == {"lammps"} for row in comparisons.rows(some))
    assert "not run" in page(replace(KEPT, impacts=some))


def test_between_its_points_the_look_up_has_the_angles_of_its_neighbours() -> None:
    look_up = disagreement.LookUp()
    low, between, high = (float(look_up.angle(0.3, rolling, 30)) for rolling in (0.1, 0.15, 0.2))
    assert low < between < high
    assert between == pytest.approx((low + high) / 2)
    # Its own points, of 1.1 and 1.5 mm and restitutions 0.1 and 0.5, around 1.2 mm and 0.3.
    assert low == pytest.approx((3 * (36.17 + 35.66) + 37.37 + 36.65) / 8, abs=0.01)


def test_no_frictions_meet_the_photographs_of_both_calibrations() -> None:
    shares = {words: share for words, share, *_ in disagreement.agreement()}
    assert shares["the first photograph and the second one at 45 rpm"] == 0
    assert shares["the second photographs at all four speeds"] > 0
    for name, answer in disagreement.ANSWERS.items():
        measured = disagreement.photographed()[name, 45][0]
        assert float(disagreement.LookUp().angle(*answer, 45)) == pytest.approx(measured, abs=1.5)
