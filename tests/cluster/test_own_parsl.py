"""A Parsl configuration of the user's own, on this machine."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from grainfit.campaign import messages
from grainfit.campaign.cluster.executor import cluster_executor
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.errors import GrainfitError

pytest.importorskip("parsl")
psutil = pytest.importorskip("psutil")

OWN = """
import sys
from pathlib import Path
from parsl import Config
from parsl.executors import HighThroughputExecutor
from parsl.providers import LocalProvider

pool = Path(sys.prefix) / "bin" / "process_worker_pool.py"
local = HighThroughputExecutor(
    address="127.0.0.1",
    max_workers_per_node=2,
    provider=LocalProvider(init_blocks=1, worker_init=f"export PATH={pool.parent}:$PATH"),
)
config = Config([local], run_dir="somewhere/else", retries=7, strategy_period=1)
number = 3
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "my_parsl.py").write_text(OWN)
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "my_parsl.py"


@pytest.mark.skipif(
    shutil.which("ps") is None,
    reason="ps is not installed: apt-get install procps; Parsl's LocalProvider ends jobs with it",
)
def test_runs_go_through_it_and_nothing_is_left_anywhere_else(own: Path) -> None:
    options = ClusterOptions(parsl=f"{own}:config", runs_per_job=2)
    folder = own.with_name("work")
    with cluster_executor(options, folder) as executor:
        futures = [executor.submit(divmod, number, 3) for number in (7, 8)]
        assert [future.result(180) for future in futures] == [(2, 1), (2, 2)]
        failed = executor.submit(divmod, 1, 0)
        assert isinstance(failed.exception(180), ZeroDivisionError)
    assert list(Path().iterdir()) == []
    assert (folder / "parsl" / "000").is_dir()
    # Those that were told to end take a moment on a busy machine.
    _, alive = psutil.wait_procs(processes_of(folder), timeout=30)
    assert alive == []


def processes_of(folder: Path) -> list[psutil.Process]:
    return [
        process
        for process in psutil.process_iter(["cmdline"])
        if str(folder) in " ".join(process.info["cmdline"] or [])
    ]


def test_its_workers_notice_soon_that_a_calibration_was_killed(own: Path) -> None:
    from grainfit.campaign.cluster import parsl_executor

    [executor] = parsl_executor._own_config(f"{own}:config").executors
    assert (executor.heartbeat_period, executor.heartbeat_threshold) == (
        parsl_executor._HEARTBEAT_SECONDS,
        parsl_executor._LOST_SECONDS,
    )


def test_something_else_than_a_configuration_is_refused(own: Path) -> None:
    options = ClusterOptions(parsl=f"{own}:number")
    with pytest.raises(GrainfitError, match=messages.NO_CONFIG.pattern):
        cluster_executor(options, own.with_name("work")).__enter__()
