"""Faults of real programs: each is a failed run of the right kind, and its reason says what it was.

A failure of the machine is tried again, one of the simulation never is.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
from running import is_running
from small_heaps import SMALL_HEAP, each_solver

from grainfit.bulk_tests.heap import Heap
from grainfit.errors import RunFailedError
from grainfit.materials.sizes import ParticleSizes
from grainfit.scenes import messages as of_scenes
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.solvers.dem.liggghts.program import Liggghts
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.solvers.process import messages
from grainfit.solvers.process.faults import cause_of_exit, machine_fault
from grainfit.solvers.process.process import run_process
from grainfit.solvers.process.run_folder import RunFolder
from grainfit.testing.materials import GLASS_BEADS

PYTHON = sys.executable
SAID = "Neighbor list info"


def model(parent: Path, **files: str) -> Path:
    folder = parent / "model"
    folder.mkdir()
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text)
    return folder


def shell(parent: Path, script: str, **options) -> Command:
    return Command(model(parent, run__sh=script), ["sh", "run.sh"], **options)


def failure(solver, folder: Path, timeout: float = 60.0) -> RunFailedError:
    folder.mkdir(exist_ok=True)
    with pytest.raises(RunFailedError) as caught:
        solver.run({}, 1, Workspace(folder, timeout))
    assert "\n" not in caught.value.reason
    return caught.value


def heap(solver_type, **options):
    changes = options.pop("material", {})
    test = Heap(ParticleSizes((0.010,)), **SMALL_HEAP, **options)
    return solver_type(test, {**GLASS_BEADS, **changes})


def working_in(folder: Path) -> list[int]:
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if (process / "cwd").readlink() == folder:
                found.append(int(process.name))
    return found


def program(pid: int) -> str:
    try:
        return str(Path(f"/proc/{pid}/exe").readlink())
    except OSError:
        return ""


# --- the program cannot be started ---------------------------------------------------------------


@each_solver
def test_solver_that_was_uninstalled_or_forbidden_meanwhile(solver_type, tmp_path):
    program = tmp_path / "solver"
    program.symlink_to(heap(solver_type)._program())
    solver = heap(solver_type)
    solver.executable = str(program)
    solver.check()
    program.unlink()

    error = failure(solver, tmp_path / "gone")
    assert (error.kind, str(program) in error.reason) == ("machine", True)
    program.write_text("not executable")
    error = failure(solver, tmp_path / "forbidden")
    assert (error.kind, str(program) in error.reason) == ("machine", True)


def test_program_of_a_script_that_is_not_installed(tmp_path):
    error = failure(shell(tmp_path, "no-such-solver -in deck"), tmp_path / "run")

    assert error.kind == "machine"
    said = messages.NO_PROGRAM(reason="run.sh: 1: no-such-solver: not found")
    assert said in error.reason


# --- licences and memory -------------------------------------------------------------------------


@pytest.mark.parametrize("code", [0, 1, 7])
def test_solver_without_a_licence(tmp_path, code):
    script = f"""
        echo 'Solver 2025.1'
        echo 'ERROR: License checkout failed for feature dem_solver.' >&2
        echo 'FlexNet Licensing error:-4,132' >&2
        exit {code}"""
    error = failure(shell(tmp_path, script), tmp_path / "run")

    assert error.kind == "machine"
    assert messages.NO_LICENCE(reason="ERROR: License checkout failed") in error.reason
    assert "-4,132" in error.log_tail


def test_program_that_runs_out_of_memory(tmp_path):
    script = """
        ulimit -c 0
        echo "terminate called after throwing an instance of 'std::bad_alloc'"
        kill -ABRT $$"""
    error = failure(shell(tmp_path, script), tmp_path / "run")

    assert (error.kind, messages.NO_MEMORY.is_in(error.reason)) == ("machine", True)


def test_evaluation_that_runs_out_of_memory(tmp_path):
    folder = model(
        tmp_path,
        evaluate__py=(
            "import resource\n"
            "def measure(folder):\n"
            "    resource.setrlimit(resource.RLIMIT_AS, (2**29, 2**29))\n"
            "    return {'a': len(bytearray(2**30))}\n"
        ),
    )
    error = failure(Command(folder, ["true"], evaluate="evaluate.py:measure"), tmp_path / "run")

    assert (error.kind, messages.NO_MEMORY.is_in(error.reason)) == ("machine", True)
    assert "MemoryError" in error.log_tail
    error = failure(PythonCallable(lambda parameters, seed: bytearray(2**62)), tmp_path / "none")
    assert (error.kind, messages.NO_MEMORY.is_in(error.reason)) == ("machine", True)


def test_process_that_the_system_killed(tmp_path):
    error = failure(shell(tmp_path, "kill -KILL $$"), tmp_path / "run")

    assert error.kind == "machine"
    lack = messages.OUT_OF_MEMORY(signal="SIGKILL")
    assert error.reason == messages.KILLED(program="sh", signal=lack)


# --- crashes, also behind launchers and scripts --------------------------------------------------

OPEN_MPI = ["--oversubscribe", "--bind-to", "none"] + ["--allow-run-as-root"] * (os.geteuid() == 0)
LAUNCHERS = [
    pytest.param([str(Path(PYTHON).with_name("mpiexec.hydra"))], id="mpich"),
    pytest.param(["mpiexec.openmpi", *OPEN_MPI], id="open-mpi"),
]


def require(launcher: list[str]) -> None:
    if shutil.which(launcher[0]) is None:
        package = "openmpi-bin" if launcher[0].endswith("openmpi") else "mpich"
        pytest.skip(f"{launcher[0]} is not installed: apt-get install {package}")


@pytest.mark.parametrize("launcher", LAUNCHERS)
@pytest.mark.parametrize(("number", "kind"), [("SEGV", "simulation"), ("KILL", "machine")])
def test_rank_that_is_killed_is_told_from_the_ranks_that_the_launcher_ends(
    tmp_path, launcher, number, kind
):
    require(launcher)
    # A rank that dies while Hydra still starts the others leaves it without a word.
    crash = f"{{ sleep 0.3; kill -{number} $$; }}"
    rank = f"ulimit -c 0; [ ${{PMI_RANK:-$OMPI_COMM_WORLD_RANK}} = 1 ] && {crash}; sleep 60"
    solver = Command(model(tmp_path), [*launcher, "-n", "2", "sh", "-c", rank])
    error = failure(solver, tmp_path / "run")

    assert error.kind == kind
    name = f"SIG{number}"
    said = messages.OUT_OF_MEMORY(signal=name) if number == "KILL" else name
    assert error.reason == messages.PROCESS_KILLED(program=Path(launcher[0]).name, signal=said)


@pytest.mark.parametrize("launcher", LAUNCHERS)
def test_launcher_that_cannot_start_the_solver(tmp_path, launcher):
    require(launcher)
    solver = Command(model(tmp_path), [*launcher, "-n", "2", "/no/such/solver"])
    error = failure(solver, tmp_path / "run")

    # Open MPI ends with code 132, as if by an illegal instruction.
    assert (error.kind, messages.NO_PROGRAM.is_in(error.reason)) == ("machine", True)


@pytest.mark.parametrize(
    ("code", "log", "kind", "said"),
    [
        (139, "", "simulation", "SIGSEGV"),
        (137, "", "machine", messages.OUT_OF_MEMORY(signal="SIGKILL")),
        (143, "", "machine", "SIGTERM"),
        (
            1,
            "run.sh: line 3: 4711 Segmentation fault      lmp -in in.deck",
            "simulation",
            "SIGSEGV",
        ),
        (1, "srun: error: node7: task 3: Killed\nsrun: Terminating", "machine", "SIGKILL"),
        (
            9,
            "KILLED BY SIGNAL: 9 (Killed)\nRANK 1\nKILLED BY SIGNAL: 8 (Floating point exception)",
            "simulation",
            "SIGFPE",
        ),
        # The rank that gave up had the others killed.
        (137, "ERROR on proc 1: Neighbor list overflow\nsigned off\n", "simulation", "overflow"),
        (255, "last words", "simulation", f"{messages.EXIT_CODE(code=255)}: last words"),
        (-11, "", "simulation", messages.KILLED(program="solver", signal="SIGSEGV")),
        (254, "last words", "simulation", messages.EXIT_CODE(code=254)),
        (15, "Fatal error in internal_Wait: Other MPI error", "machine", messages.PROCESS_LOST),
        (134, "slurmstepd: Detected 1 oom_kill event in StepId=1.0", "machine", messages.NO_MEMORY),
        (1, "ERROR on proc 0: Failed to allocate 80000000000 bytes", "machine", messages.NO_MEMORY),
        (
            1,
            "lmp: error while loading shared libraries: libmpi.so.12",
            "machine",
            messages.NO_PROGRAM,
        ),
        (127, "", "machine", messages.STARTED_NOTHING),
    ],
)
def test_what_the_end_of_a_program_means(code, log, kind, said):
    cause = cause_of_exit("/opt/bin/solver", code, log)

    assert cause.kind == kind
    assert said in cause.reason if isinstance(said, str) else said.is_in(cause.reason)


@pytest.mark.parametrize(
    "line",
    [
        "Could not check out a license for EDEM",
        "ERROR: no license available",
        "Licensed number of users already reached.",
        "License server machine is down or not responding: cannot connect to license server",
        "Unable to obtain licence from 27000@server",
        "The licence has expired",
        "FLEXlm error: -15,570",
    ],
)
def test_messages_of_a_missing_licence(line):
    assert machine_fault(f"Solver 3.1\n{line}\nbye\n") == messages.NO_LICENCE(reason=line)


@pytest.mark.parametrize(
    "line",
    [
        "This program comes with NO WARRANTY: see the GNU General Public License.",
        "There is no warranty, GNU license 2.",
        "License check out successful: feature dem_solver",
        "Per MPI rank memory allocation (min/avg/max) = 3.7 | 3.7 | 3.7 Mbytes",
        "ERROR: Lost atoms: original 400 current 0",
        "disk loading test, particles in the disk: 100",
    ],
)
def test_messages_that_are_no_fault_of_the_machine(line):
    assert machine_fault(line) == ""
    assert cause_of_exit("solver", 1, line).kind == "simulation"


def test_lost_atoms_of_a_deck_of_the_users(tmp_path):
    # Particles that overlap grossly from the start, and a far too large time step.
    deck = """
units           lj
region          box block 0 4 0 4 0 4
create_box      1 box
create_atoms    1 random 400 12345 NULL
mass            1 1.0
pair_style      lj/cut 2.5
pair_coeff      1 1 1.0 1.0 2.5
fix             motion all nve
timestep        0.05
thermo          10
run             1000000000
"""
    solver = Command(
        model(tmp_path, in__deck=deck),
        [Lammps(Heap(diameter="10 mm"), {})._program(), "-in", "in.deck"],
    )
    error = failure(solver, tmp_path / "run", timeout=30)

    assert error.kind == "simulation"
    assert (
        f"{messages.EXIT_CODE(code=1)}: ERROR: Lost atoms: original 400 current 0" in error.reason
    )
    assert "Lost atoms" in error.log_tail


# --- the heap test -------------------------------------------------------------------------------


@each_solver
@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({"time_step_fraction": 1.0}, id="time step"),
        pytest.param({"material": {"particle.youngs_modulus": 1e3}}, id="soft as jelly"),
        pytest.param(
            {"time_step_fraction": 1.0, "material": {"wall.youngs_modulus": 1e13}}, id="hard wall"
        ),
    ],
)
def test_heap_that_explodes_ends_at_once_and_says_so(solver_type, changes, tmp_path):
    error = failure(heap(solver_type, **changes), tmp_path)

    assert error.kind == "simulation"
    assert of_scenes.BROKEN.is_in(error.reason, stage="fill", container="cylinder")
    assert "fill,broken," in error.log_tail
    assert not list(tmp_path.rglob("*.dump"))


# --- a full disk ---------------------------------------------------------------------------------


@pytest.fixture
def tiny_disk(tmp_path):
    """Mount a disk of 512 kB; give a run's folder on it."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=512k", "tmpfs", str(disk)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("mounting a file system is not permitted: run the tests as root")
    try:
        (disk / "run").mkdir()
        yield disk / "run"
    finally:
        subprocess.run(["umount", str(disk)], check=True)


FULL = messages.DISK_FULL()


@pytest.mark.parametrize(
    "script",
    [
        pytest.param("cat /dev/zero > dump || exit 3", id="exit code"),
        pytest.param(
            "cat /dev/zero > dump 2> /dev/null; echo '{\"a\": 1.0}' > responses.json", id="cut"
        ),
        pytest.param("cat /dev/zero > dump; sleep 60", id="hangs"),
    ],
)
def test_disk_that_fills_while_a_program_runs(tiny_disk, tmp_path, script):
    error = failure(shell(tmp_path, script), tiny_disk, timeout=2)

    assert (error.kind, error.reason) == ("machine", FULL)
    assert sorted(path.name for path in tiny_disk.iterdir() if path.name.startswith(".")) == []


def test_disk_that_is_full_before_the_run(tiny_disk, tmp_path):
    solver = shell(tmp_path, "exit 0")
    with pytest.raises(OSError, match="No space"), (tiny_disk.parent / "other").open("wb") as file:
        file.write(bytes(1_000_000))

    error = failure(solver, tiny_disk)
    assert (error.kind, error.reason) == ("machine", FULL)
    for solver_type in (Lammps, Liggghts):
        error = failure(heap(solver_type), tiny_disk)
        assert (error.kind, error.reason) == ("machine", FULL)


@each_solver
def test_disk_that_fills_under_a_real_solver(solver_type, tiny_disk):
    # Room for the deck, and for little of what the solver writes.
    (tiny_disk.parent / "other").write_bytes(bytes(430_000))

    error = failure(heap(solver_type), tiny_disk)

    assert (error.kind, error.reason) == ("machine", FULL)


@pytest.mark.parametrize("code", [0, 1])
def test_disk_that_is_full_elsewhere(tmp_path, code):
    error = failure(shell(tmp_path, f"cat run.sh > /dev/full\nexit {code}"), tmp_path / "run")

    assert error.kind == "machine"
    assert messages.DISK_IN_LOG.is_in(error.reason)
    assert "No space left on device" in error.log_tail


def test_finished_run_counts_whatever_a_program_says_of_disks_and_licences(tmp_path):
    script = """
        cat run.sh > /dev/full
        echo 'cannot reach license server, using the local licence'
        echo '{"a": 1.0}' > responses.json"""
    folder = tmp_path / "run"
    folder.mkdir()

    assert shell(tmp_path, script).run({}, 1, Workspace(folder))["a"].value == 1.0


def test_folder_that_cannot_be_written(tiny_disk, tmp_path):
    remount = ["mount", "-o", "remount,ro", str(tiny_disk.parent)]
    subprocess.run(remount, check=True)

    error = failure(shell(tmp_path, "exit 0"), tiny_disk)

    assert error.kind == "machine"
    assert error.reason == messages.FOLDER_READ_ONLY(reason="Read-only file system")


# --- a folder that goes away ---------------------------------------------------------------------

REMOVED = messages.FOLDER_REMOVED()


def remove(folder: Path) -> None:
    shutil.rmtree(folder)


def rename(folder: Path) -> None:
    folder.rename(folder.with_name("elsewhere"))


def replace(folder: Path) -> None:
    """Many file systems give the new folder the inode number that the old one had."""
    shutil.rmtree(folder)
    folder.mkdir()


def rename_what_it_is_in(folder: Path) -> None:
    folder.parent.rename(folder.parent.with_name("elsewhere"))


@pytest.mark.parametrize("take_away", [remove, rename, replace, rename_what_it_is_in])
@pytest.mark.parametrize("phase", ["simulation", "evaluation"])
def test_run_ends_soon_after_its_folder_was_taken_away(tmp_path, take_away, phase):
    note = tmp_path / "pid"
    wait = f"import os, time\nopen({str(note)!r}, 'w').write(str(os.getpid()))\ntime.sleep(600)\n"
    if phase == "simulation":
        solver = Command(
            model(tmp_path, wait__py=f"print('first words', flush=True)\n{wait}"),
            [PYTHON, "wait.py"],
        )
    else:
        evaluation = f"def measure(folder):\n    exec({wait!r})\n"
        solver = Command(
            model(tmp_path, evaluate__py=evaluation), ["true"], evaluate="evaluate.py:measure"
        )
    folder = tmp_path / "runs" / "run"
    folder.mkdir(parents=True)
    taken = []

    def take() -> None:
        while not (note.exists() and note.read_text()):
            time.sleep(0.01)
        take_away(folder)
        taken.append(time.monotonic())

    thread = threading.Thread(target=take)
    thread.start()
    error = failure(solver, folder)
    ended = time.monotonic()
    thread.join()

    assert (error.kind, error.reason) == ("machine", REMOVED)
    # It would go on for ten minutes; its time-out is another error.
    assert ended - taken[0] < 300.0
    assert not Path(f"/proc/{note.read_text()}").exists()
    assert error.log_tail == ("first words" if phase == "simulation" else "")
    assert not folder.exists() or list(folder.iterdir()) == []


def test_folder_that_is_given_the_number_of_the_one_before_is_told_from_it(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    with RunFolder(folder) as watched:
        assert not watched.is_gone()
        replace(folder)
        assert watched.is_gone()


def test_program_that_takes_its_own_folder_away(tmp_path):
    for number, end in enumerate(("exit 0", "echo '{\"a\": 1}' > responses.json", "kill -SEGV $$")):
        (tmp_path / str(number)).mkdir()
        solver = shell(tmp_path / str(number), f'ulimit -c 0; rm -r "$PWD"; {end}')
        error = failure(solver, tmp_path / f"run {number}")
        assert (error.kind, error.reason) == ("machine", REMOVED)


@pytest.mark.parametrize(("number", "kind"), [(9, "machine"), (11, "simulation")])
def test_signal_that_kills_a_real_solver_is_seen_through_what_started_it(tmp_path, number, kind):
    def kill() -> None:
        while SAID not in "".join(path.read_text() for path in tmp_path.rglob("log.lammps")):
            time.sleep(0.01)
        solvers = [pid for pid in working_in(tmp_path) if program(pid).endswith("/lmp")]
        os.kill(solvers[0], number)

    thread = threading.Thread(target=kill)
    thread.start()
    error = failure(heap(Lammps, material={"particle.youngs_modulus": 1e8}), tmp_path)
    thread.join()

    assert error.kind == kind
    assert signal.Signals(number).name in error.reason
    assert SAID in error.log_tail


@each_solver
def test_real_solver_whose_folder_is_removed(solver_type, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()

    def remove_at_work() -> None:
        while not any(path.stat().st_size for path in folder.glob("log.*")):
            time.sleep(0.01)
        # The solver may write a file between two of its steps.
        while folder.exists():
            shutil.rmtree(folder, ignore_errors=True)

    thread = threading.Thread(target=remove_at_work)
    thread.start()
    # So stiff that its time-out would come long before its end.
    solver = heap(solver_type, material={"particle.youngs_modulus": 1e11})
    error = failure(solver, folder)
    thread.join()

    assert (error.kind, error.reason) == ("machine", REMOVED)


# --- hangs and clocks ----------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("launcher", LAUNCHERS)
def test_ranks_that_will_not_end_are_gone_when_the_run_is(tmp_path, launcher):
    require(launcher)
    rank = (
        "import os, signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN);"
        "open(f'rank {os.getpid()}', 'w').close(); time.sleep(600)"
    )
    with pytest.raises(RunFailedError) as caught:
        run_process([*launcher, "-n", "2", PYTHON, "-c", rank], Workspace(tmp_path, timeout=2.0))

    assert caught.value.kind == "timeout"
    ranks = [path.name.split()[1] for path in tmp_path.glob("rank *")]
    assert len(ranks) == 2
    assert [rank for rank in ranks if is_running(rank)] == []


def test_child_with_a_session_of_its_own_is_ended_too(tmp_path):
    code = (
        "import os, signal, time\n"
        "if os.fork() == 0:\n"
        "    os.setsid()\n"
        "    signal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
        "    open('pid', 'w').write(str(os.getpid()))\n"
        "time.sleep(600)\n"
    )
    with pytest.raises(RunFailedError, match=messages.TOO_LONG.pattern):
        run_process([PYTHON, "-c", code], Workspace(tmp_path, timeout=4.0))

    assert not is_running((tmp_path / "pid").read_text())


def test_clock_that_jumps_neither_ends_nor_prolongs_a_run(tmp_path, monkeypatch):
    jumps = iter(range(0, 10**12, 10**6))
    monkeypatch.setattr(time, "time", lambda: float(next(jumps)))

    assert run_process(["true"], Workspace(tmp_path, timeout=30)) < 30
    monkeypatch.setattr(time, "time", lambda: 0.0)
    started = time.monotonic()
    with pytest.raises(RunFailedError, match=messages.TOO_LONG.pattern):
        run_process(["sleep", "600"], Workspace(tmp_path, timeout=0.3))
    assert time.monotonic() - started < 300
