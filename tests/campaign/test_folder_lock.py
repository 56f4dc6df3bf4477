"""Work folders on file systems without locks, or whose locks other machines do not see."""

from __future__ import annotations

import errno
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.campaign import folder_lock, messages
from grainfit.campaign.folder_lock import hold, is_held
from grainfit.campaign.store.store import RunStore
from grainfit.errors import StoreError

HOLD = """
import sys
from pathlib import Path
from grainfit.campaign import folder_lock
from grainfit.errors import StoreError

folder_lock._BEAT_SECONDS, folder_lock._SILENT_SECONDS = 0.2, 3.0
try:
    with folder_lock.hold(Path("work")):
        print("held", flush=True)
        sys.stdin.read()
except StoreError as error:
    print(error, flush=True)
"""
FILE = """
name = "sand"

[parameters]
friction = { min = 0.1, max = 0.9 }

[[test]]
type = "python"
function = "drum.py:drum"
targets.angle = { value = 36, uncertainty = 0.4 }
"""
Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Replacement of the kernel's locks, for programs that are told so by LOCKS."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    built = tmp_path_factory.mktemp("locks") / "locks.so"
    source = Path(__file__).with_name("locks.c")
    subprocess.run([compiler, "-shared", "-fPIC", source, "-o", built, "-ldl"], check=True)
    return str(built)


@pytest.fixture
def start(library: str, tmp_path: Path) -> Iterator[Start]:
    """Start a program on a machine of another name, with other locks."""
    started = []

    def start(*command: str, locks: str = "", host: str = "") -> subprocess.Popen[str]:
        if host:
            named = ["sh", "-c", 'echo "$0" >/proc/sys/kernel/hostname && exec "$@"', host]
            command = ("unshare", "--uts", *named, *command)
        process = subprocess.Popen(
            command,
            cwd=tmp_path,
            env=os.environ | {"LD_PRELOAD": library, "LOCKS": locks},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("kind", ["flock", "fcntl"])
@pytest.mark.parametrize("error", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_folder_without_locks_is_refused(
    start: Start, tmp_path: Path, kind: str, error: int
) -> None:
    said = start(sys.executable, "-c", HOLD, locks=f"{kind}:{error}").communicate(timeout=60)[0]
    assert said.startswith("the work folder 'work' cannot be locked: ")
    for part in (os.strerror(error), "no locks", "workdir", "cluster", "administrator"):
        assert part in said
    assert not (tmp_path / "work" / "runs.sqlite").exists()


def test_run_without_locks_ends_at_once_with_the_reason(start: Start, tmp_path: Path) -> None:
    (tmp_path / "sand.toml").write_text(FILE)
    (tmp_path / "drum.py").write_text("def drum(parameters, seed): return {'angle': 36.0}\n")
    process = start(sys.executable, "-m", "grainfit", "run", "sand.toml", locks="fcntl:37")
    said = " ".join(process.communicate(timeout=60)[0].split())
    assert process.returncode == 1
    assert messages.NOT_LOCKED.is_in(said)
    assert "No locks available" in said
    assert "Traceback" not in said
    assert not (tmp_path / "sand.grainfit" / "runs.sqlite").exists()


def test_second_start_on_another_machine_is_refused_where_locks_are_apart(start: Start) -> None:
    if subprocess.run(["unshare", "--uts", "true"], check=False).returncode:
        pytest.skip("names of machines cannot be changed: run the tests as root")
    program = (sys.executable, "-c", HOLD)
    first = start(*program, locks="apart", host="login1")
    assert read_line(first) == "held"
    second = start(*program, locks="apart", host="login2")
    assert messages.FOLDER_IN_USE.is_in(
        read_line(second), folder="work", process=f"{first.pid} on login1"
    )
    # The refused one has not taken the lock over.
    third = start(*program, locks="apart", host="login2")
    assert messages.FOLDER_IN_USE.is_in(read_line(third), process=f"{first.pid} on login1")
    first.kill()
    first.wait()
    heir = start(*program, locks="apart", host="login2")
    assert read_line(heir) == "held"


@pytest.mark.parametrize("name", ["runs.sqlite", "runs.sqlite-wal", "lock", "result.json"])
def test_a_pipe_in_place_of_a_file_is_named_and_not_waited_for(name: str, tmp_path: Path) -> None:
    RunStore.in_folder(tmp_path).close()
    (tmp_path / name).unlink(missing_ok=True)
    os.mkfifo(tmp_path / name)
    found = messages.NOT_A_FILE(path=str(tmp_path / name))
    with pytest.raises(StoreError, match=re.escape(found)):
        gf.open(tmp_path)
    with pytest.raises(StoreError, match=re.escape(found)), hold(tmp_path):
        pass


def read_line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def test_start_after_another_machine_has_let_go_does_not_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folder_lock, "_SILENT_SECONDS", 600.0)
    began = time.monotonic()
    for _ in range(2):
        with hold(tmp_path):
            assert is_held(tmp_path)
            signature = (tmp_path / "lock").read_text().split()
            assert signature[:2] == [str(os.getpid()), os.uname().nodename]
        assert (tmp_path / "lock").read_text() == ""
    assert time.monotonic() - began < 300
