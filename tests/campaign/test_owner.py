"""Names of processes in a shared store: random, and inherited by the next start alone."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from grainfit.campaign.store.owner import OWNER_NAME, earlier_owner, new_owner, note_owner
from tests.servers.postgresql_server import PostgresqlServer

#: A host: its own kernel's number, host name, and disk, as far as one kernel can give them.
HOST = """\
set -e
hostname laboratory
mount --bind "$DISK" "$MOUNT"
mount --bind "$DISK/boot_id" /proc/sys/kernel/random/boot_id
exec "$PYTHON" "$PROGRAM"
"""
PROGRAM = """\
import os, time
from pathlib import Path

import grainfit as gf
from grainfit.solvers.own_model.python_callable import PythonCallable

disk, made = Path(os.environ["MOUNT"]), Path(os.environ["MADE"])
waits = bool(os.environ.get("WAITS"))

def simulate(parameters, seed):
    with made.open("a") as file:
        file.write(f"{seed}\\n")
    while waits and not made.with_name("go").exists():
        time.sleep(0.01)
    return {"angle": 20 + 25 * parameters["friction"]}

def note(progress):
    made.with_name(f"asked {os.environ['NAME']}").touch()

problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 33.0)])
solver = PythonCallable(simulate, identity="of two hosts")
gf.calibrate(
    problem, solver, workdir=disk / "work", store=os.environ["STORE"], max_runs=7, on_progress=note
)
"""


def sign(folder: Path) -> str:
    name = new_owner(folder)
    note_owner(folder, name)
    return name


def test_the_next_start_in_a_folder_knows_the_name_of_the_one_before(tmp_path: Path) -> None:
    assert earlier_owner(tmp_path) is None
    first = sign(tmp_path)
    assert str(tmp_path) in first
    assert earlier_owner(tmp_path) == first
    second = sign(tmp_path)
    assert second != first
    assert earlier_owner(tmp_path) == second
    assert new_owner(None) != new_owner(None)


def test_a_folder_that_was_moved_keeps_its_name_and_a_copy_has_none(tmp_path: Path) -> None:
    work = tmp_path / "work"
    work.mkdir()
    name = sign(work)
    shutil.copytree(work, tmp_path / "copy")
    assert earlier_owner(tmp_path / "copy") is None
    moved = work.rename(tmp_path / "moved")
    assert earlier_owner(moved) == name


def test_the_same_folder_on_another_machine_has_no_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sign(tmp_path)
    other = tmp_path / "boot_id"
    other.write_text("00000000-0000-0000-0000-000000000000\n")
    monkeypatch.setattr("grainfit.platforms.BOOT_ID", other)
    assert earlier_owner(tmp_path) is None
    monkeypatch.setattr("grainfit.platforms.BOOT_ID", tmp_path / "none")
    sign(tmp_path)
    assert earlier_owner(tmp_path) is None


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"name": 1, "place": []}', "\x00"])
def test_a_damaged_name_is_none(tmp_path: Path, text: str) -> None:
    (tmp_path / OWNER_NAME).write_text(text)
    assert earlier_owner(tmp_path) is None


def test_two_hosts_with_the_same_name_and_path_make_each_run_once(
    server: PostgresqlServer, tmp_path: Path
) -> None:
    isolated = ["unshare", "--uts", "--mount", "sh", "-c"]
    if shutil.which("unshare") is None or subprocess.run([*isolated, "hostname x"]).returncode:
        pytest.skip("needs the rights to give processes a host name of their own (root)")
    mount, made, program = tmp_path / "data", tmp_path / "made", tmp_path / "program.py"
    mount.mkdir()
    program.write_text(PROGRAM)

    def start(name: str, **more: str) -> subprocess.Popen[bytes]:
        disk = tmp_path / name
        disk.mkdir(exist_ok=True)
        (disk / "boot_id").write_text(f"{name}\n")
        given = {"NAME": name, "DISK": disk, "MOUNT": mount, "MADE": made, "PROGRAM": program}
        given |= {"PYTHON": sys.executable, "STORE": server.url, **more}
        environment = os.environ | {key: str(value) for key, value in given.items()}
        return subprocess.Popen([*isolated, HOST], env=environment)

    def wait_for(path: Path) -> None:
        deadline = time.monotonic() + 60
        while not path.exists():
            assert not any(host.poll() for host in hosts)
            assert time.monotonic() < deadline
            time.sleep(0.02)

    hosts = [start("one", WAITS="yes")]
    try:
        wait_for(made)
        # The other one begins with a copy of the first one's disk, while that is in use:
        # `cp` may miss a file that is just being replaced, but never the lock.
        subprocess.run(["cp", "-a", tmp_path / "one", tmp_path / "two"], check=False)
        (tmp_path / "two" / "work" / "lock").unlink()
        hosts.append(start("two"))
        wait_for(tmp_path / "asked two")
        (tmp_path / "go").touch()
        assert [host.wait(60) for host in hosts] == [0, 0]
    finally:
        for host in hosts:
            host.kill()
    seeds = made.read_text().split()
    assert len(seeds) == len(set(seeds)) > 2
