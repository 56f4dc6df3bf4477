"""Runs work with any executor of the user."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import random
import signal
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.campaign import messages
from grainfit.campaign.campaign import Campaign, CampaignOptions
from grainfit.campaign.store.store import RunStore
from grainfit.errors import ExecutorError
from grainfit.evaluation import Proposal
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.python_callable import PythonCallable

PROBLEM = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 33.0)])


def drum(parameters: dict[str, float], seed: int) -> dict[str, float]:
    noise = random.Random(seed).gauss(0, 0.2)
    return {"angle": 20 + 25 * parameters["friction"] + noise}


def die_at_first(parameters: dict[str, float], seed: int) -> dict[str, float]:
    os.kill(os.getpid(), signal.SIGKILL)
    return {}


@pytest.fixture
def processes() -> Iterator[Executor]:
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as pool:
        yield pool


def test_processes_give_what_threads_give(processes: Executor, tmp_path: Path) -> None:
    with ThreadPoolExecutor(2) as threads:
        results = [
            gf.calibrate(PROBLEM, drum, executor=executor, workdir=tmp_path / str(number))
            for number, executor in enumerate((None, threads, processes))
        ]
    assert results[0].history == results[1].history == results[2].history
    assert len({tuple(result.parameters.items()) for result in results}) == 1
    # The user's executor goes on.
    assert processes.submit(os.getpid).result() > 0


def test_an_own_model_runs_in_other_processes(processes: Executor, tmp_path: Path) -> None:
    model = tmp_path / "model"
    model.mkdir()
    (model / "run.sh").write_text(
        '#!/bin/sh\necho "{\\"angle\\": $1}" > responses.json\n', encoding="utf-8"
    )
    (model / "run.sh").chmod(0o755)
    solver = Command(model, ["./run.sh", "{{ friction }}"])
    options = CampaignOptions(2, executor=processes)
    campaign = Campaign({"own": solver}, RunStore.in_memory(), tmp_path / "work", options)
    (tmp_path / "work").mkdir()
    campaign.start(Proposal({"friction": 0.25}, 1, "design"))
    [evaluation] = campaign.wait()
    assert evaluation.responses["angle"].value == 0.25
    assert (tmp_path / "work" / "runs" / evaluation.runs["own"] / "run.json").is_file()
    assert pickle.loads(pickle.dumps(solver)).definition({"friction": 0.5}, 1) == (
        solver.definition({"friction": 0.5}, 1)
    )


def test_a_function_that_cannot_be_sent_is_an_error_that_says_so(processes: Executor) -> None:
    with pytest.raises(ExecutorError, match=messages.CANNOT_BE_SENT.pattern):
        gf.calibrate(PROBLEM, lambda p, s: {"angle": 30.0}, executor=processes)


def test_an_executor_that_is_broken_ends_the_calibration_and_loses_nothing(
    processes: Executor, tmp_path: Path
) -> None:
    with pytest.raises(ExecutorError, match=messages.NO_MORE_RUNS.pattern):
        gf.calibrate(
            PROBLEM,
            PythonCallable(die_at_first, identity="drum"),
            executor=processes,
            workdir=tmp_path,
        )
    result = gf.calibrate(PROBLEM, PythonCallable(drum, identity="drum"), workdir=tmp_path)
    assert result.status == "calibrated"


def test_runs_in_other_processes_end_with_the_calibration(
    processes: Executor, tmp_path: Path
) -> None:
    model = tmp_path / "model"
    model.mkdir()
    (model / "run.sh").write_text("#!/bin/sh\n# friction\nsleep 600\n", encoding="utf-8")
    (model / "run.sh").chmod(0o755)
    work = tmp_path / "work"
    work.mkdir()
    store = RunStore.in_folder(work)
    options = CampaignOptions(2, executor=processes)
    campaign = Campaign({"own": Command(model, ["./run.sh"])}, store, work, options)
    campaign.start(Proposal({"friction": 0.25}, 1, "design"))
    while not list(work.glob("runs/*.partial/solver.log")):
        time.sleep(0.01)
    began = time.monotonic()
    campaign.cancel()
    campaign.close()
    assert store.runs() == []
    assert processes.submit(sum, [1, 2]).result(timeout=10) == 3
    processes.shutdown()
    # The run would go on for ten minutes.
    assert time.monotonic() - began < 300
    assert not list((work / "runs").iterdir())


def test_a_run_whose_worker_is_lost_is_tried_again() -> None:
    class Losing(ThreadPoolExecutor):
        """Loses the first of all runs, as a cluster does whose job is ended."""

        lost = threading.Event()

        def submit(self, function, /, *arguments, **named):  # type: ignore[no-untyped-def]
            if self.lost.is_set():
                return super().submit(function, *arguments, **named)
            self.lost.set()
            return super().submit(self._lose)

        @staticmethod
        def _lose() -> None:
            raise ConnectionError("the node is down")

    with Losing(1) as executor:
        options = CampaignOptions(executor=executor, retry_pauses=(0.01,))
        campaign = Campaign({"drum": PythonCallable(drum)}, RunStore.in_memory(), None, options)
        campaign.start(Proposal({"friction": 0.25}, 1, "design"))
        [evaluation] = campaign.wait()
    assert not evaluation.failures
