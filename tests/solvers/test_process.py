"""Solver processes leave nothing running, in whichever way they end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from running import is_running

from grainfit.errors import RunFailedError
from grainfit.files import log_tail
from grainfit.solvers.base import Workspace
from grainfit.solvers.process import messages
from grainfit.solvers.process.ending import end_process_group
from grainfit.solvers.process.orphans import end_orphans, mark_of, record_session
from grainfit.solvers.process.process import LOG_NAME, run_process

PYTHON = sys.executable

#: Starts a child that ignores SIGTERM, notes both process numbers, and waits for ever.
STUBBORN_FAMILY = """
import os, signal, subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c",
    "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN);"
    "open('child_ready', 'w').close(); time.sleep(600)"])
while not os.path.exists("child_ready"):
    time.sleep(0.01)
with open("pids.new", "w") as file:
    file.write(f"{os.getpid()} {child.pid}")
os.rename("pids.new", "pids")
time.sleep(600)
"""


def python(code: str) -> list[str]:
    return [PYTHON, "-c", code]


def wait_for(condition, seconds: float = 10.0) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.01)
    return False


def pids_in(folder: Path) -> list[int]:
    assert wait_for((folder / "pids").exists)
    return [int(pid) for pid in (folder / "pids").read_text().split()]


def test_output_goes_to_the_log_and_the_wall_time_is_returned(tmp_path):
    code = "import sys, time; print('out'); print('err', file=sys.stderr); time.sleep(0.2)"

    began = time.monotonic()
    seconds = run_process(python(code), Workspace(tmp_path))

    assert set((tmp_path / LOG_NAME).read_text().split()) == {"out", "err"}
    assert 0.2 <= seconds <= time.monotonic() - began


def test_log_can_have_another_name(tmp_path):
    run_process(python("print('hello')"), Workspace(tmp_path), log_name="other.log")

    assert (tmp_path / "other.log").read_text() == "hello\n"
    assert not (tmp_path / LOG_NAME).exists()


def test_works_in_the_folder_and_knows_the_environment(tmp_path):
    folder = tmp_path / "a 'quoted' \"folder\""
    folder.mkdir()
    code = (
        "import os, pathlib;"
        "pathlib.Path('here').write_text(os.environ['WORD'] + os.environ['OMP_NUM_THREADS'])"
    )

    run_process(python(code), Workspace(folder), {"WORD": "x $HOME; "})

    assert (folder / "here").read_text() == "x $HOME; 1"


def test_arguments_reach_the_program_as_they_are(tmp_path):
    arguments = ["a b", "$(touch hacked)", "; touch hacked", "'\"", "*", ""]
    code = "import json, sys; json.dump(sys.argv[1:], open('arguments', 'w'))"

    run_process([*python(code), *arguments], Workspace(tmp_path))

    assert json.loads((tmp_path / "arguments").read_text()) == arguments
    assert not (tmp_path / "hacked").exists()


def test_reads_nothing_from_the_terminal(tmp_path):
    run_process(python("import sys; assert sys.stdin.read() == ''"), Workspace(tmp_path, 30))


@pytest.mark.parametrize("code", [1, 3, 255])
def test_exit_code_is_a_failure_of_the_simulation(tmp_path, code):
    with pytest.raises(RunFailedError, match=messages.EXIT_CODE(code=code)) as caught:
        run_process(python(f"print('the reason'); raise SystemExit({code})"), Workspace(tmp_path))

    assert caught.value.kind == "simulation"
    assert caught.value.log_tail == "the reason"


@pytest.mark.parametrize(
    ("number", "kind"),
    [
        (signal.SIGSEGV, "simulation"),
        (signal.SIGABRT, "simulation"),
        (signal.SIGFPE, "simulation"),
        (signal.SIGKILL, "machine"),
        (signal.SIGTERM, "machine"),
    ],
)
def test_death_by_a_signal_is_named(tmp_path, number, kind):
    code = (
        "import os, resource; resource.setrlimit(resource.RLIMIT_CORE, (0, 0));"
        f"print('before', flush=True); os.kill(os.getpid(), {int(number)})"
    )

    with pytest.raises(RunFailedError, match=messages.KILLED.pattern) as caught:
        run_process(python(code), Workspace(tmp_path))

    assert number.name in caught.value.reason
    assert caught.value.kind == kind
    assert caught.value.log_tail == "before"


@pytest.mark.parametrize(
    "command",
    [["no-such-program-anywhere"], ["/no/such/program"], ["./missing"], [PYTHON, "zero\0byte"]],
)
def test_program_that_cannot_be_started(tmp_path, command):
    with pytest.raises(RunFailedError, match=messages.NOT_STARTED.pattern) as caught:
        run_process(command, Workspace(tmp_path))

    assert caught.value.kind == "machine"


def test_time_out_ends_the_whole_family(tmp_path):
    started = time.monotonic()
    with pytest.raises(RunFailedError, match=messages.TOO_LONG(timeout=4)) as caught:
        run_process(python(STUBBORN_FAMILY), Workspace(tmp_path, timeout=4.0))

    assert caught.value.kind == "timeout"
    # The family would go on for ten minutes.
    assert 4.0 <= time.monotonic() - started < 60.0
    leader, child = pids_in(tmp_path)
    assert not is_running(leader)
    assert wait_for(lambda: not is_running(child))


@pytest.mark.slow
def test_time_out_does_not_count_a_suspension(tmp_path):
    """As of a laptop that sleeps: program and watcher stand still for longer than the time-out."""
    waits = "import os, time\nwith open('new', 'w') as file: file.write(str(os.getpid()))\n"
    waits += "os.rename('new', 'pids')\n"
    waits += "while not os.path.exists('go'): time.sleep(0.05)"
    watcher = (
        "import sys; from pathlib import Path;"
        "from grainfit.solvers.base import Workspace;"
        "from grainfit.solvers.process.process import run_process;"
        "print(run_process([sys.executable, '-c', sys.argv[1]], Workspace(Path(), timeout=7.0)))"
    )
    command = [PYTHON, "-c", watcher, waits]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    family = [process.pid, *pids_in(tmp_path)]

    for pid in family:
        os.kill(pid, signal.SIGSTOP)
    time.sleep(8.0)
    for pid in family:
        os.kill(pid, signal.SIGCONT)
    time.sleep(0.5)
    (tmp_path / "go").touch()
    said, _ = process.communicate(timeout=60)

    assert process.returncode == 0
    assert float(said) < 7.0


def test_cancelling_ends_the_whole_family(tmp_path):
    workspace = Workspace(tmp_path)
    canceller = threading.Thread(target=lambda: (pids_in(tmp_path), workspace.cancelled.set()))
    canceller.start()
    with pytest.raises(RunFailedError) as caught:
        run_process(python(STUBBORN_FAMILY), workspace)
    canceller.join()

    assert caught.value.kind == "cancelled"
    leader, child = pids_in(tmp_path)
    assert not is_running(leader)
    assert wait_for(lambda: not is_running(child))


def test_child_left_behind_by_a_program_that_ended_well_is_ended_too(tmp_path):
    code = (
        "import subprocess, sys;"
        "child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)']);"
        "open('pids', 'w').write(str(child.pid))"
    )

    run_process(python(code), Workspace(tmp_path, timeout=30))

    (child,) = pids_in(tmp_path)
    assert wait_for(lambda: not is_running(child))


def test_program_that_ignores_the_request_to_end_is_killed(tmp_path):
    code = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); time.sleep(600)"
    started = time.monotonic()

    with pytest.raises(RunFailedError, match=messages.TOO_LONG.pattern):
        run_process(python(code), Workspace(tmp_path, timeout=1.0))

    assert time.monotonic() - started < 60.0


def test_tail_of_a_log(tmp_path):
    log = tmp_path / "log"
    log.write_bytes(b"\n".join(b"line %d" % i for i in range(10_000)) + b"\nbroken \xff text\n")

    tail = log_tail(log, lines=3).splitlines()

    assert tail == ["line 9998", "line 9999", "broken \ufffd text"]
    assert log_tail(tmp_path / "none") == ""
    log.write_bytes(b"")
    assert log_tail(log) == ""


#: Notes the process number in the folder that is its argument, and waits for ever.
WAIT = """
import os, sys, time
with open(sys.argv[1] + "/pids.new", "w") as file:
    file.write(str(os.getpid()))
os.rename(sys.argv[1] + "/pids.new", sys.argv[1] + "/pids")
time.sleep(600)
"""
#: Does so in a session of its own, without a parent.
DETACH = f"""
import os, time
if os.fork():
    time.sleep(600)
os.setsid()
os.chdir("/")
if os.fork():
    os._exit(0)
{WAIT}
"""
ORPHANS = {
    "in its folder": python(STUBBORN_FAMILY),
    "in a subfolder": ["sh", "-c", 'mkdir work; cd work && exec "$@"', "sh", *python(WAIT)],
    "in a group of its own": ["sh", "-c", 'cd /; set -m; "$@" & wait', "sh", *python(WAIT)],
    "with an empty environment": ["sh", "-c", 'cd /; exec env -i "$@"', "sh", *python(WAIT)],
    "detached": python(DETACH),
}


def leave_orphans(folder: Path, command: list[str]) -> list[int]:
    """Kill a calibration while its solver runs; return the processes that it leaves."""
    calibration = subprocess.Popen(
        python(
            "from pathlib import Path\n"
            "from grainfit.solvers.base import Workspace\n"
            "from grainfit.solvers.process.process import run_process\n"
            f"run_process({[*command, str(folder)]!r}, Workspace(Path({str(folder)!r})))\n"
        )
    )
    pids = pids_in(folder)
    calibration.kill()
    calibration.wait()
    assert all(is_running(pid) for pid in pids)
    return pids


@pytest.mark.parametrize("place", ORPHANS)
def test_orphan_of_a_killed_calibration_is_ended(tmp_path, place):
    folder = tmp_path / "a run: 'signs'"
    folder.mkdir()
    pids = leave_orphans(folder, ORPHANS[place])

    assert end_orphans(folder)

    assert wait_for(lambda: not any(is_running(pid) for pid in pids))
    assert not end_orphans(folder)


def test_orphan_in_a_folder_that_was_moved_is_ended(tmp_path):
    folder = tmp_path / "runs" / "identity.token.partial"
    folder.mkdir(parents=True)
    pids = leave_orphans(folder, python(WAIT))
    (tmp_path / "runs").rename(tmp_path / "moved")
    gone = tmp_path / "moved" / "identity.token.gone.partial"
    (tmp_path / "moved" / folder.name).rename(gone)
    # A copy of the folder is another run.
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / gone.name).mkdir()

    assert not end_orphans(tmp_path / "runs" / gone.name)
    assert all(is_running(pid) for pid in pids)
    assert end_orphans(gone)
    assert wait_for(lambda: not any(is_running(pid) for pid in pids))


def test_a_solver_that_has_detached_itself_is_ended_by_the_time_out(tmp_path):
    with pytest.raises(RunFailedError, match=messages.TOO_LONG.pattern):
        run_process([*python(DETACH), str(tmp_path)], Workspace(tmp_path, timeout=4.0))

    (pid,) = pids_in(tmp_path)
    assert wait_for(lambda: not is_running(pid))


def test_a_session_that_has_got_the_number_of_an_old_one_is_not_ended(tmp_path):
    other = subprocess.Popen(python("import time; time.sleep(600)"), start_new_session=True)
    try:
        record_session(tmp_path, other.pid)
        (record,) = tmp_path.iterdir()
        number, boot, start = record.read_text().split()
        record.write_text(f"{number} {boot} {int(start) - 1}\n")
        assert not end_orphans(tmp_path)
        record.write_text("damaged")
        assert not end_orphans(tmp_path)
        assert other.poll() is None
    finally:
        other.kill()
        other.wait()


def test_the_shell_of_a_user_who_repeats_a_run_by_hand_is_not_ended(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    code = 'GRAINFIT_RUN="$1" "$2" -c "$3" "$4"; sleep 600'
    arguments = [mark_of(folder), PYTHON, WAIT, str(tmp_path)]
    shell = subprocess.Popen(["sh", "-c", code, "sh", *arguments], start_new_session=True)
    try:
        (run,) = pids_in(tmp_path)
        assert end_orphans(folder)
        assert not is_running(run)
        assert shell.poll() is None
    finally:
        end_process_group(shell.pid)
        shell.wait()


def test_neither_this_process_nor_what_started_it_is_taken_for_an_orphan(tmp_path):
    code = (
        "import os, sys, subprocess; from pathlib import Path;"
        "from grainfit.solvers.process.orphans import MARK, end_orphans, mark_of;"
        "folder = Path.cwd(); again = os.environ.get(MARK);"
        "os.environ[MARK] = mark_of(folder);"
        "sys.exit(end_orphans(folder) if again else subprocess.call(sys.orig_argv))"
    )
    done = subprocess.run(python(code), cwd=tmp_path, start_new_session=True, check=False)

    assert done.returncode == 0


def test_somebody_who_looks_into_a_folder_is_not_taken_for_an_orphan(tmp_path):
    other = subprocess.Popen(python("import time; time.sleep(600)"), cwd=tmp_path)
    try:
        assert not end_orphans(tmp_path)
        assert other.poll() is None
    finally:
        other.kill()
        other.wait()


def test_solvers_of_other_folders_are_not_ended(tmp_path):
    here, elsewhere = tmp_path / "here", tmp_path / "elsewhere"
    here.mkdir()
    elsewhere.mkdir()
    ended = []

    def work():
        ended.append(run_process(python("import time; time.sleep(1)"), Workspace(elsewhere)))

    run = threading.Thread(target=work)
    run.start()
    assert wait_for((elsewhere / LOG_NAME).exists)
    assert not end_orphans(here)
    run.join()
    assert ended
