"""A campaign makes each run once, keeps it, and survives what runs do."""

import json
import threading
import time
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import pytest

from grainfit.campaign import messages
from grainfit.campaign.campaign import RETRY_PAUSES, Campaign, CampaignOptions
from grainfit.campaign.folder_lock import hold, is_held
from grainfit.campaign.store.store import RunStore
from grainfit.campaign.work_folder import recover
from grainfit.errors import FailureKind, InputError, RunFailedError, StoreError
from grainfit.evaluation import Proposal, Response
from grainfit.solvers.base import Solver, Workspace
from grainfit.solvers.own_model.python_callable import PythonCallable


class Counting(Solver):
    """Writes a file, counts its runs, and fails on request."""

    name = "counting"

    def __init__(self, fails: FailureKind | None = None, hangs: bool = False) -> None:
        self.runs = 0
        self.fails = fails
        self.hangs = hangs

    @property
    def response_names(self) -> tuple[str, ...]:
        return ("double",)

    def model(self) -> dict[str, Any]:
        return {"solver": self.name}

    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> dict[str, Response]:
        self.runs += 1
        (workspace.folder / "output.txt").write_text(f"{seed}")
        while self.hangs and not workspace.cancelled.is_set():
            time.sleep(0.01)
        if workspace.cancelled.is_set():
            raise RunFailedError("stopped", kind="cancelled")
        if self.fails:
            raise RunFailedError("no luck", "the log", self.fails)
        return {"double": Response(2 * parameters["x"])}


class WithoutTriple(Counting):
    """May be without a response, and is."""

    absent: Mapping[str, str] = {"triple": "x is too small"}

    @property
    def response_names(self) -> tuple[str, ...]:
        return ("double", "triple")


def proposal(x: float, seed: int = 1) -> Proposal:
    return Proposal({"x": x}, seed, "design")


def start(
    folder: Path, solver: Solver, workers: int = 1, needed: Mapping[str, Collection[str]] = {}
) -> tuple[Campaign, RunStore]:
    (folder / "runs").mkdir(exist_ok=True)
    store = RunStore.in_folder(folder)
    recover(folder, store)
    options = CampaignOptions(workers, retry_pauses=(0.0,) * len(RETRY_PAUSES), needed=needed)
    return Campaign({"test": solver}, store, folder, options), store


def test_a_finished_run_is_never_made_again(tmp_path: Path) -> None:
    solver = Counting()
    for reused in (0, 1):
        campaign, _ = start(tmp_path, solver)
        campaign.start(proposal(3.0))
        [evaluation] = campaign.wait()
        campaign.close()
        assert evaluation.responses == {"double": Response(6.0)}
        assert evaluation.reused == reused
    assert solver.runs == 1


def test_a_run_that_failed_for_want_of_a_response_stays_in_the_store(tmp_path: Path) -> None:
    campaign, store = start(tmp_path, WithoutTriple(), needed={"test": ["triple"]})
    campaign.start(proposal(3.0))
    [evaluation] = campaign.wait()
    assert evaluation.failures == {"test": "no triple: x is too small"}
    campaign.forget_failures([evaluation])
    campaign.close()
    # Also one that came from another store, without a folder to restore it from.
    assert [record.responses for record in store.runs("finished")] == [{"double": Response(6.0)}]


def test_the_same_run_asked_for_twice_at_once_is_made_once(tmp_path: Path) -> None:
    solver = Counting()
    campaign, _ = start(tmp_path, solver, workers=2)
    campaign.start(proposal(3.0))
    campaign.start(proposal(3.0))
    evaluations = campaign.wait()
    while len(evaluations) < 2:
        evaluations += campaign.wait()
    assert solver.runs == 1


def test_run_folders_keep_the_solvers_files_and_a_record(tmp_path: Path) -> None:
    campaign, _ = start(tmp_path, Counting())
    campaign.start(proposal(3.0, seed=8))
    [evaluation] = campaign.wait()
    folder = tmp_path / "runs" / evaluation.runs["test"]
    assert (folder / "output.txt").read_text() == "8"
    assert json.loads((folder / "run.json").read_text())["status"] == "finished"


def test_a_lost_store_is_made_again_from_the_run_folders(tmp_path: Path) -> None:
    solver = Counting()
    campaign, store = start(tmp_path, solver)
    campaign.start(proposal(3.0))
    campaign.wait()
    campaign.close()
    store.close()
    for file in tmp_path.glob("runs.sqlite*"):
        file.unlink()
    campaign, _ = start(tmp_path, solver)
    campaign.start(proposal(3.0))
    [evaluation] = campaign.wait()
    assert evaluation.reused == 1
    assert solver.runs == 1


@pytest.mark.parametrize(
    ("kind", "attempts"), [("simulation", 1), ("evaluation", 1), ("machine", 1 + len(RETRY_PAUSES))]
)
def test_only_faults_of_the_machine_are_tried_again(
    tmp_path: Path, kind: FailureKind, attempts: int
) -> None:
    solver = Counting(fails=kind)
    campaign, store = start(tmp_path, solver)
    campaign.start(proposal(3.0))
    [evaluation] = campaign.wait()
    assert evaluation.failures == {"test": "no luck"}
    assert evaluation.responses == {}
    assert solver.runs == attempts
    assert store.runs()[0].log_tail == "the log"


def test_a_failed_neighbour_costs_nobody_else(tmp_path: Path) -> None:
    bad = Counting(fails="simulation")
    # With the same name, both tests would be one and the same run.
    bad.name = "bad"
    campaign = Campaign({"good": Counting(), "bad": bad}, RunStore.in_memory(), tmp_path)
    campaign.start(proposal(3.0))
    [evaluation] = campaign.wait()
    assert evaluation.responses == {"good.double": Response(6.0)}
    assert evaluation.failures == {"bad": "no luck"}


def test_responses_that_are_no_numbers_are_a_failure(tmp_path: Path) -> None:
    campaign, _ = start(tmp_path, Counting())
    campaign.start(proposal(1e308))
    [evaluation] = campaign.wait()
    assert "double is inf" in evaluation.failures["test"]


def test_cancelled_runs_leave_no_trace_and_are_made_again(tmp_path: Path) -> None:
    solver = Counting(hangs=True)
    campaign, store = start(tmp_path, solver)
    campaign.start(proposal(3.0))
    while solver.runs == 0:
        time.sleep(0.01)
    campaign.cancel()
    campaign.close()
    assert store.runs() == []
    assert list((tmp_path / "runs").iterdir()) == []


def test_a_work_folder_is_held_by_one_process(tmp_path: Path) -> None:
    assert not is_held(tmp_path)
    with hold(tmp_path):
        assert is_held(tmp_path)
        with pytest.raises(StoreError, match=messages.FOLDER_IN_USE.pattern), hold(tmp_path):
            pass
    assert not is_held(tmp_path)


def test_several_workers_run_at_a_time(tmp_path: Path) -> None:
    class Meeting(Counting):
        barrier = threading.Barrier(2)

        def run(
            self, parameters: Mapping[str, float], seed: int, workspace: Workspace
        ) -> dict[str, Response]:
            self.barrier.wait(timeout=10)
            return {"double": Response(0.0)}

    campaign, _ = start(tmp_path, Meeting(), workers=2)
    campaign.start(proposal(1.0))
    assert campaign.has_free_worker
    campaign.start(proposal(2.0))
    assert not campaign.has_free_worker
    evaluations = campaign.wait()
    while len(evaluations) < 2:
        evaluations += campaign.wait()
    assert all(not e.failures for e in evaluations)


def test_what_is_asked_for_is_noted_before_any_of_its_runs_starts(tmp_path: Path) -> None:
    campaign, store = start(tmp_path, Counting())
    noted = []
    campaign.start(proposal(3.0), lambda runs: noted.append((runs, store.states())))
    [evaluation] = campaign.wait()
    campaign.close()
    assert noted == [(evaluation.runs, {})]


def test_worker_that_has_ended_one_of_several_tests_is_free_for_another_proposal(
    tmp_path: Path,
) -> None:
    goes_on = threading.Event()

    def slow(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        del parameters, seed
        assert goes_on.wait(30.0)
        return {"value": 1.0}

    def quick(parameters: Mapping[str, float], seed: int) -> dict[str, float]:
        del seed
        return {"value": parameters["x"]}

    solvers = {"slow": PythonCallable(slow), "quick": PythonCallable(quick)}
    campaign = Campaign(solvers, RunStore.in_folder(tmp_path), None, CampaignOptions(2))
    campaign.start(proposal(3.0))
    assert campaign.wait() == []
    assert campaign.has_free_worker
    goes_on.set()
    [evaluation] = campaign.wait()
    campaign.close()

    assert evaluation.responses == {"slow.value": Response(1.0), "quick.value": Response(3.0)}


def test_name_of_a_further_run_is_refused_for_a_test(tmp_path: Path) -> None:
    solvers = {"heap": Counting(), "heap, seed 2": Counting()}

    with pytest.raises(InputError, match=messages.NAME_OF_FURTHER_RUNS.pattern):
        Campaign(solvers, RunStore.in_folder(tmp_path), tmp_path)
