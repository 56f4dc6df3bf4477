"""A search is driven from outside: by hand, from a scheduler, and by a strategy of one's own."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import grainfit as gf
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.testing.strategy_contract import heap, heap_problem

DOCS = Path(__file__).parents[2] / "docs"
PAGES = (DOCS / "ask_and_tell.md", DOCS / "developers" / "own_strategy.md")


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """Names that the code of the page and of the next one defines, block after block."""
    names: dict[str, Any] = {"__name__": "page"}
    for path in PAGES:
        text = path.read_text(encoding="utf-8")
        for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
            exec(compile(block, str(path), "exec", dont_inherit=True), names)
    return names


def test_the_search_of_the_page_finds_the_answer(page: dict[str, Any]) -> None:
    # 15 + 25 * 0.64 = 31
    assert page["answer"].parameters["friction"] == pytest.approx(0.64, abs=0.02)
    assert page["answer"].probability_all_met >= 0.95


def test_the_strategy_of_the_page_calibrates(page: dict[str, Any]) -> None:
    result = page["result"]
    assert result.strategy == "random"
    assert result.runs.optimisation == 20
    assert result.runs.verification >= 3 or result.status != "calibrated"
    assert result.parameters["friction"] == pytest.approx(0.64, abs=0.1)


def test_a_strategy_of_ones_own_has_its_options_checked(page: dict[str, Any]) -> None:
    with pytest.raises(gf.InputError, match="tries: is 3"):
        page["RandomSearch"](tries=3)


def test_a_calibration_with_it_is_continued_without_repeating_a_run(
    page: dict[str, Any], tmp_path: Path
) -> None:
    made: list[int] = []

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        made.append(seed)
        return page["simulate"](parameters, seed)

    # A function that counts its calls is another one after each, unless it is named.
    solver = PythonCallable(simulate, identity="page")
    strategy = page["RandomSearch"](tries=12)
    first = gf.calibrate(page["problem"], solver, strategy=strategy, workdir=tmp_path)
    runs = len(made)
    again = gf.calibrate(page["problem"], solver, strategy=strategy, workdir=tmp_path)
    assert (again.identity, again.parameters) == (first.identity, first.parameters)
    assert len(made) == runs
    other = gf.calibrate(
        page["problem"], solver, strategy=page["RandomSearch"](tries=13), workdir=tmp_path
    )
    assert other.identity != first.identity


def test_what_is_told_by_hand_and_by_a_campaign_gives_the_same_calibration() -> None:
    problem = heap_problem()
    simulated: dict[int, gf.Evaluation] = {}

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        simulated[seed] = heap(gf.Proposal(parameters, seed, "design"))
        return {name: one.value for name, one in simulated[seed].responses.items()}

    result = gf.calibrate(problem, simulate, strategy="sequential", seed=3)
    search = gf.Sequential().start(problem, seed=3)
    asked = []
    while not search.finished:
        proposal = search.ask()
        assert proposal is not None
        asked.append(proposal)
        search.tell(proposal, simulated[proposal.seed].responses)
    made = [run for run in result.history if run.stage != "verification"]
    assert [(p.seed, p.parameters) for p in asked] == [(r.seed, r.parameters) for r in made]
    frozen = problem.rounded(search.answer().parameters)
    assert frozen == result.parameters
    for run in result.history[len(made) :]:
        proposal = gf.Proposal(run.parameters, run.seed, "verification")
        search.tell(proposal, simulated[run.seed].responses)
    assert search.answer(frozen).predicted == pytest.approx(
        {name: found.predicted for name, found in result.responses.items()}
    )


def test_an_evaluation_of_another_proposal_is_refused() -> None:
    search = gf.Staged().start(heap_problem(), seed=1)
    first, second = search.ask(), search.ask()
    assert first is not None
    assert second is not None
    with pytest.raises(gf.InputError, match="another proposal"):
        search.tell(first, heap(second))


def test_a_fault_of_the_machine_is_told_as_such() -> None:
    proposal = gf.Proposal({"friction": 0.3}, 1, "design")
    failed = gf.RunFailedError("the disk is full", kind="machine")
    assert gf.Evaluation.of(proposal, failed).failed_by_machine
    assert not gf.Evaluation.of(proposal, gf.RunFailedError("flew away")).failed_by_machine
