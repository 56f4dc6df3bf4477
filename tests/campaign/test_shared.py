"""Several processes share a store: each run is made by one of them, and found by all."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import grainfit as gf
from grainfit.campaign import messages
from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.shared import SharedRuns, Timing, share
from grainfit.campaign.store.store import RunStore
from grainfit.errors import StoreError
from grainfit.evaluation import Proposal, Response
from grainfit.messages import Message
from grainfit.run_definition import RunDefinition
from grainfit.solvers.own_model.python_callable import PythonCallable
from tests.servers.postgresql_server import PostgresqlServer

FORK = multiprocessing.get_context("fork")


@pytest.fixture(params=["sqlite", "postgresql"])
def address(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'shared.sqlite'}"
    return str(request.getfixturevalue("server").url)


def record(identity: str, status: str = "running", **values: Any) -> RunRecord:
    return RunRecord(identity, "drum", status, RunDefinition({}, {}, 1), **values)  # type: ignore[arg-type]


def in_processes(count: int, work: Callable[[int], None]) -> None:
    processes = [FORK.Process(target=work, args=(number,)) for number in range(count)]
    for process in processes:
        process.start()
    for process in processes:
        process.join(300)
    assert [process.exitcode for process in processes] == [0] * count


def make_runs(address: str, made: Path, seeds: Sequence[int], number: int) -> None:
    """Ask for runs, in an order of one's own, and note those that are made here."""

    def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
        with made.open("a") as file:
            file.write(f"{seed}\n")
        return {"angle": parameters["friction"] + seed}

    order = random.Random(number).sample(seeds, len(seeds))
    own = RunStore.in_memory()
    solver = PythonCallable(simulate, identity="shared")
    with share(address, None, own) as shared:
        campaign = Campaign({"drum": solver}, own, None, CampaignOptions(workers=4), shared)
        ended = 0
        while ended < len(seeds):
            while order and campaign.has_free_worker:
                campaign.start(Proposal({"friction": 0.5}, order.pop(), "design"))
            for evaluation in campaign.wait():
                seed = evaluation.proposal.seed
                assert evaluation.responses == {"angle": Response(0.5 + seed)}
                ended += 1
        campaign.close()


@pytest.mark.parametrize(
    ("backend", "processes", "runs"),
    [
        pytest.param("sqlite", 4, 100, id="sqlite"),
        pytest.param("postgresql", 8, 400, id="postgresql"),
        pytest.param("postgresql", 8, 2000, id="many", marks=pytest.mark.thorough),
    ],
)
def test_of_all_processes_one_makes_a_run_and_all_get_it(
    tmp_path: Path, request: pytest.FixtureRequest, backend: str, processes: int, runs: int
) -> None:
    address = f"sqlite:///{tmp_path / 'shared.sqlite'}"
    if backend == "postgresql":
        address = request.getfixturevalue("server").url
    made = tmp_path / "made"
    # Every run is wanted by two processes, by all of them in turn.
    wanted = [
        [seed for seed in range(1, runs + 1) if number in (seed % processes, seed // 8 % processes)]
        for number in range(processes)
    ]
    in_processes(processes, lambda number: make_runs(address, made, wanted[number], number))
    assert sorted(map(int, made.read_text().split())) == list(range(1, runs + 1))
    store = RunStore(address)
    assert len(store.runs("finished")) == len(store.identities()) == runs
    store.close()


def test_of_two_who_claim_a_run_one_gets_it(address: str) -> None:
    store = RunStore(address)
    assert store.claim(record("a"), "first")
    assert not store.claim(record("a"), "second")
    store.release("first")
    assert store.claim(record("a"), "second")
    store.save(record("a", "finished"))
    assert not store.claim(record("a"), "first")
    store.save(record("a", "failed", kind="machine"))
    assert store.claim(record("a"), "first")
    store.close()


def test_text_that_a_solver_printed_is_kept_whatever_it_is(address: str) -> None:
    store = RunStore(address)
    store.save(record("a", "failed", reason="zero \0 byte", log_tail="lone \udc80 surrogate, \x1b"))
    assert store.runs()[0].reason == "zero   byte"
    store.close()


def test_what_a_dead_process_was_making_is_made_by_another(address: str, tmp_path: Path) -> None:
    def claim_and_die(_number: int) -> None:
        SharedRuns(RunStore(address), "dead", Timing(beat_seconds=0.05)).claim(record("a"))
        time.sleep(0.2)
        os.kill(os.getpid(), signal.SIGKILL)

    process = FORK.Process(target=claim_and_die, args=(0,))
    process.start()
    store = RunStore(address)
    shared = SharedRuns(store, "alive", Timing(lease_seconds=0.5))
    while not store.claims(["a"]):
        time.sleep(0.01)
    # While its owner shows that it lives, a run is not taken away.
    assert not shared.claim(record("a"))
    assert not shared.take_over(record("a"))
    process.join()
    deadline = time.monotonic() + 10
    while not shared.take_over(record("a")):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert store.claims(["a"])["a"].owner == "alive"
    shared.close()
    assert store.claims(["a"]) == {}
    store.close()


def test_time_in_which_an_owner_could_not_be_heard_does_not_count(address: str) -> None:
    store = RunStore(address)
    assert store.claim(record("a"), "away")
    shared = SharedRuns(store, "here", Timing(beat_seconds=0.05, lease_seconds=0.2))
    assert not shared.take_over(record("a"))
    # As after the suspension of this process, or of both.
    time.sleep(0.5)
    assert not shared.take_over(record("a"))
    deadline = time.monotonic() + 10
    while not shared.take_over(record("a")):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    shared.close()
    store.close()


def test_runs_given_to_a_shared_store_replace_nothing_there(address: str) -> None:
    store = RunStore(address)
    assert store.claim(record("a"), "somebody")
    store.save(record("b", "finished", seconds=1.0))
    store.add_missing(record(name, "finished", seconds=2.0) for name in ("a", "b", "c"))
    assert store.states() == {"a": "running", "b": "finished", "c": "finished"}
    assert {run.identity: run.seconds for run in store.runs("finished")} == {"b": 1.0, "c": 2.0}
    store.close()


def test_runs_taken_from_a_shared_store_are_not_given_back(address: str, tmp_path: Path) -> None:
    own = RunStore.in_memory()
    with share(address, None, own) as shared:
        own.save(record("taken", "finished", origin=shared.place))
        own.save(record("elsewhere", "finished", origin=str(tmp_path)))
        own.save(record("made", "finished"))
    with share(address, None, own) as shared:
        assert set(shared.find(["taken", "elsewhere", "made"])) == {"elsewhere", "made"}


def test_an_outcome_counts_unless_the_run_went_on_without_its_owner(address: str) -> None:
    store = RunStore(address)
    assert store.claim(record("a"), "first")
    assert store.claim(record("a"), "first")
    (claim,) = store.claims(["a"]).values()
    assert store.claim(record("a"), "second", instead_of=claim)
    assert not store.save_outcome(record("a", "failed", kind="timeout"), "first")
    assert store.claims(["a"])["a"].owner == "second"
    assert store.save_outcome(record("a", "finished", seconds=2.0), "second")
    assert not store.save_outcome(record("a", "finished", seconds=1.0), "first")
    assert not store.save_outcome(record("a", "failed", kind="timeout"), "second")
    store.forget_ended("nothing")
    assert [run.seconds for run in store.runs()] == [2.0]
    store.forget_ended("a")
    assert store.claim(record("a"), "first")
    store.forget_ended("a")
    assert store.save_outcome(record("a", "failed", kind="simulation"), "first")
    assert store.states() == {"a": "failed"}
    store.close()


def drum(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """Angle of repose in a drum, with the scatter of a seed."""
    noise = random.Random(seed).gauss(0, 0.2)
    return {"angle": 20 + 25 * parameters["friction"] + noise}


def test_a_second_calibration_learns_from_a_shared_store(address: str, tmp_path: Path) -> None:
    problem = gf.Problem(
        [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 33.0, tolerance=0.5)]
    )
    first = gf.calibrate(problem, drum, workdir=tmp_path / "first", store=address)
    second = gf.calibrate(problem, drum, workdir=tmp_path / "second", store=address)
    assert (first.runs.warm_start_runs, second.runs.warm_start_runs) == (0, first.runs.total)
    assert second.status == "calibrated"
    assert second.runs.design == 0
    assert second.runs.optimisation <= 1
    # What was taken over belongs to the work folder now, and says where it came from.
    own = RunStore.read_only(tmp_path / "second")
    assert {run.origin for run in own.runs()} == {"", RunStore(address).place}
    own.close()


def test_the_password_of_a_shared_store_is_written_nowhere(
    server: PostgresqlServer, tmp_path: Path
) -> None:
    problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 33.0)])
    address = f"{server.url}?password={server.password}"
    gf.calibrate(problem, drum, workdir=tmp_path / "first", store=address, max_runs=7)
    gf.calibrate(problem, drum, workdir=tmp_path / "second", runs_from=[address], max_runs=7)
    gf.open(tmp_path / "second").report()
    store = RunStore.read_only(tmp_path / "second")
    assert {run.origin for run in store.runs()} >= {server.url}
    store.close()
    written = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert {path.name for path in written} >= {"runs.sqlite", "report.html"}
    secret = server.password.encode()
    assert [path for path in written if secret in path.read_bytes()] == []


def test_a_work_folder_gives_a_shared_store_what_it_has(address: str, tmp_path: Path) -> None:
    problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 33.0)])
    alone = gf.calibrate(problem, drum, workdir=tmp_path)
    gf.calibrate(problem, drum, workdir=tmp_path, store=address)
    store = RunStore(address)
    assert len(store.runs("finished")) == alone.runs.total
    store.close()


def test_a_run_that_another_process_makes_is_not_counted_as_ones_own(address: str) -> None:
    other, own = RunStore(address), RunStore.in_memory()
    solver = PythonCallable(drum, identity="shared")
    proposal = Proposal({"friction": 0.5}, 1, "design")
    with share(address, None, own) as shared:
        campaign = Campaign({"drum": solver}, own, None, shared=shared)
        run = record(campaign.identities(proposal)["drum"])
        assert other.claim(run, "other")
        campaign.start(proposal)
        assert [pending.state for pending in campaign.pending_runs] == ["elsewhere"]
        found = {"angle": Response(30.0)}
        other.save_outcome(replace(run, status="finished", responses=found, seconds=9.0), "other")
        [evaluation] = campaign.wait()
        campaign.close()
    other.close()
    assert (evaluation.reused, evaluation.seconds, evaluation.simulated_seconds) == (1, 9.0, 0.0)


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("nonsense", messages.NO_ADDRESS),
        ("oracle+nonsense://x/y", messages.NO_ADDRESS),
        ("postgresql+psycopg://nobody:secret@/x?host=/nowhere", messages.STORE_UNUSABLE),
        ("sqlite:////nowhere/at/all.sqlite", messages.STORE_UNUSABLE),
    ],
)
def test_a_store_that_cannot_be_had_is_an_error_without_its_password(
    address: str, message: Message
) -> None:
    with pytest.raises(StoreError, match=message.pattern) as caught:
        RunStore(address)
    assert "secret" not in str(caught.value)
