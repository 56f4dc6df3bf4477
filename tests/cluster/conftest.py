from __future__ import annotations

import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PROGRAMS = ("slurmctld", "slurmd", "munged", "sbatch")


def free_ports(count: int) -> int:
    """The first of some ports in a row that are all free."""
    for _ in range(50):
        with ExitStack() as stack:
            first = stack.enter_context(socket.socket())
            first.bind(("127.0.0.1", 0))
            port: int = first.getsockname()[1]
            try:
                for number in range(port + 1, port + count):
                    stack.enter_context(socket.socket()).bind(("127.0.0.1", number))
            except (OSError, OverflowError):
                continue
            return port
    raise RuntimeError(f"no {count} ports in a row are free")


@pytest.fixture(scope="session")
def _slurm() -> Iterator[Path]:
    """A Slurm of this process's own: tests of several processes do not disturb each other."""
    missing = [program for program in PROGRAMS if shutil.which(program) is None]
    if missing:
        pytest.skip(
            f"Slurm ({', '.join(missing)}) is not installed: apt-get install slurm-wlm munge"
        )
    if os.geteuid() != 0:
        pytest.skip("Slurm is started by root only: run the tests as root")
    # Not pytest's own folder: the path of a socket must be short.
    folder = Path(tempfile.mkdtemp(prefix="slurm-"))
    try:
        subprocess.run(
            [HERE / "start_slurm.sh", folder, str(free_ports(3))], check=True, timeout=60
        )
        yield folder
    finally:
        subprocess.run([HERE / "stop_slurm.sh", folder], check=False, timeout=60)
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def slurm(_slurm: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A Slurm whose commands work here."""
    monkeypatch.setenv("SLURM_CONF", str(_slurm / "slurm.conf"))
    return _slurm
