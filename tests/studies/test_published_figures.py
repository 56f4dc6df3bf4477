"""The benchmarks with published figures: records that come out again, and a page that has them."""

from __future__ import annotations

import numpy as np
import pytest

import needs
from benchmarks.kept_runs import read
from studies.benchmarks import comparisons, disagreement, evidence
from studies.benchmarks.impacts import SPINS, Run, all_runs, simulate
from studies.benchmarks.page import page, readme
from studies.benchmarks.published import DATA

RECORDS = read(DATA / "impacts.jsonl", Run)
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


def test_all_impacts_of_three_solvers_are_kept() -> None:
    assert set(RECORDS) == set(all_runs(("lammps", "liggghts", "yade")))
    assert len(RECORDS[Run("yade", 7, "copper", 0.5)]["found"]["spin_share"]) == 2 * len(SPINS)


def test_the_page_and_the_table_of_the_readme_are_those_of_the_records() -> None:
    written = (evidence.ROOT / "docs" / "studies" / "benchmarks.md").read_text(encoding="utf-8")
    table = (evidence.ROOT / "README.md").read_text(encoding="utf-8")
    words = "Run: python -m studies.benchmarks page"
    assert written == page(RECORDS), words
    assert table == readme(RECORDS), words


def test_a_deviation_beyond_the_tolerance_is_bold() -> None:
    rows = {(r.comparison.test, r.comparison.reference): r for r in comparisons.rows(RECORDS)}
    sliding = rows[5, comparisons.SLIDING]
    assert sliding.is_met("lammps")
    assert not sliding.is_met("yade")
    by_name = {row.benchmark: row.results for row in evidence.evidence(RECORDS)}
    assert "**" not in str(by_name["recoil (test 5), sliding"]["lammps"])
    assert str(by_name["recoil (test 5), sliding"]["yade"]).startswith("**")


def test_a_solver_that_has_not_been_run_is_left_out() -> None:
    some = {run: record for run, record in RECORDS.items() if run.solver == "lammps"}
    assert all(set(row.deviations) == {"lammps"} for row in comparisons.rows(some))
    assert "not run" in page(some)


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
