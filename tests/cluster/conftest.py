from __future__ import annotations

import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
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


@contextmanager
def started(
    title: str, name: str, programs: Iterable[str], packages: str, ports: int
) -> Iterator[Path]:
    """The folder of a scheduler that ``start_NAME.sh`` has started; skips where it cannot be."""
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        pytest.skip(f"{title} ({', '.join(missing)}) is not installed: apt-get install {packages}")
    if os.geteuid() != 0:
        pytest.skip(f"{title} is started by root only: run the tests as root")
    # Not pytest's own folder: the path of a socket must be short.
    folder = Path(tempfile.mkdtemp(prefix=f"{name}-"))
    try:
        start = [HERE / f"start_{name}.sh", folder, str(free_ports(ports))]
        subprocess.run(start, check=True, timeout=60)
        yield folder
    finally:
        subprocess.run([HERE / f"stop_{name}.sh", folder], check=False, timeout=60)
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def _slurm() -> Iterator[Path]:
    """A Slurm of this process's own: tests of several processes do not disturb each other."""
    with started("Slurm", "slurm", PROGRAMS, "slurm-wlm munge", 3) as folder:
        yield folder


@pytest.fixture
def slurm(_slurm: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A Slurm whose commands work here."""
    monkeypatch.setenv("SLURM_CONF", str(_slurm / "slurm.conf"))
    return _slurm
