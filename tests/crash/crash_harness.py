"""Kill calibrations at any moment, and report lost runs, repeated runs and different answers.

A calibration runs in a process forked from this one, which has already imported everything, so that
a start takes no time. Its model is a real program that logs every start outside the work folder.
Repeated runs are counted there, independently of the store.
"""

from __future__ import annotations

import faulthandler
import json
import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import psutil

from grainfit.calibration import calibrate as calibration
from grainfit.campaign import messages
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import STORE_NAME, RunStore
from grainfit.campaign.work_folder import PARTIAL_SUFFIX, read_record
from grainfit.errors import GrainfitError, StoreError
from grainfit.evaluation import scalars
from grainfit.problem import Parameter, Problem, Target
from grainfit.result import Result
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.python_callable import PythonCallable
from grainfit.strategies.base import Strategy
from grainfit.strategies.staged.strategy import Staged

LOG_VARIABLE = "CRASH_LOG"
SECONDS_VARIABLE = "CRASH_SECONDS"
OUTPUT_VARIABLE = "CRASH_OUTPUT"
#: Duration of one run of the program, s: long enough to be hit, short enough for many runs.
RUN_SECONDS = 0.01
PROGRAM = """\
#!/bin/sh
set -e
echo "started $$ $1 $2" >> "$CRASH_LOG"
sleep "$CRASH_SECONDS"
head -c "$CRASH_OUTPUT" /dev/zero > dump
awk -v friction="$1" -v seed="$2" 'BEGIN {
    printf "{\\"angle\\": %.15g}\\n", 10 + 50 * friction * friction + (seed % 1009) / 1009 - 0.5
}' > responses.json
echo "ended $$ $1 $2" >> "$CRASH_LOG"
"""
FRICTION = Parameter("friction", 0.1, 0.9)
#: A calibration that has not ended after this time hangs, s.
_PATIENCE = 120.0
_DISK_BYTES = 32 * 2**20

#: Identity of a run for the program: the value and the seed given to it.
Key = tuple[float, int]


def expected(key: Key) -> float:
    """Response of a run, computed without the program."""
    friction, seed = key
    return 10 + 50 * friction * friction + (seed % 1009) / 1009 - 0.5


def function(parameters: dict[str, float], seed: int) -> dict[str, float]:
    """Do the same as the program, in this process."""
    key = (parameters["friction"], seed)
    _write_line(f"started {os.getpid()} {key[0]!r} {seed}")
    time.sleep(float(os.environ[SECONDS_VARIABLE]))
    _write_line(f"ended {os.getpid()} {key[0]!r} {seed}")
    return {"angle": expected(key)}


def _write_line(line: str) -> None:
    with Path(os.environ[LOG_VARIABLE]).open("a", encoding="utf-8") as log:
        log.write(f"{line}\n")


@dataclass(frozen=True)
class Variant:
    """Settings of a calibration to kill.

    Parameters
    ----------
    name : str
        Name in a table.
    workers : int
        Runs at a time. With more than one, the next proposal depends on the order in which runs
        end, so that only the status of the answer is the same every time.
    strategy : str or Strategy
        Chooses the runs.
    solver : {"program", "function"}
        A program started for each run, or a function in the same process.
    pool : bool
        Whether worker processes carry out the runs.
    tolerance : float
        Of the target, degrees.
    options : mapping
        Further options of the calibration.
    seconds : float
        Duration of a run, s.
    output : int
        Bytes that a run of the program writes besides its responses.
    same_history : bool
        Whether the store keeps the proposals. Without them a calibration makes a warm start from
        the runs that are left, and finds a different answer that is as good.
    """

    name: str
    workers: int = 1
    strategy: str | Strategy = "sequential"
    solver: str = "program"
    pool: bool = False
    tolerance: float = 1.0
    options: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = RUN_SECONDS
    output: int = 100
    same_history: bool = True

    @property
    def exact(self) -> bool:
        """Whether the answer is the same to the last digit every time."""
        return self.workers == 1 and self.same_history


VARIANTS = (
    Variant("kill -9"),
    Variant("kill -9, 2 workers", workers=2),
    Variant("kill -9, staged", strategy="staged"),
    # The verification does not confirm the first answer, and the search continues.
    Variant(
        "kill -9, staged, two answers",
        strategy=Staged(design_runs=5),
        tolerance=0.3,
        options={"seed": 2},
    ),
    Variant("kill -9, Python function", solver="function"),
    Variant("kill -9, process pool", workers=2, pool=True),
)


@dataclass
class Tally:
    """Effects of one kind of fault.

    Parameters
    ----------
    fault : str
        Name of the fault.
    injected : int
        Number of faults injected.
    lost, repeated, different : list of str
        Finished runs that were lost, runs that were repeated, and answers that changed.
    """

    fault: str
    injected: int = 0
    lost: list[str] = field(default_factory=list)
    repeated: list[str] = field(default_factory=list)
    different: list[str] = field(default_factory=list)


Progress = Callable[[Tally], None]


def _silent(_tally: Tally) -> None:
    """Show nothing."""


@dataclass
class Ending:
    """End of a calibration's process: with a result, with an error, or killed."""

    result: dict[str, Any] | None = None
    error: str = ""
    message: str = ""


class Trial:
    """One calibration and its work folder, through all its starts.

    Parameters
    ----------
    variant : Variant
        Settings of the calibration.
    folder : Path
        Separate empty folder.
    tally : Tally
        Collects the complaints.
    work : Path, optional
        The work folder, if it is not ``folder / "work"``.
    """

    def __init__(
        self, variant: Variant, folder: Path, tally: Tally, work: Path | None = None
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.variant = variant
        self.name = f"calibration {folder.name}"
        self.work = work or folder / "work"
        self.log = folder / "program.log"
        self.log.touch()
        self._tally = tally
        self._model = folder / "model"
        self._ending = folder / "ending.json"
        self._stacks = folder / "stacks"
        self._groups: list[int] = []
        self._finished: dict[Key, int] = {}
        self._model.mkdir(exist_ok=True)
        program = self._model / "simulate.sh"
        program.write_text(PROGRAM, encoding="utf-8")
        program.chmod(0o755)

    # One start ---------------------------------------------------------------------------------

    def start(self, **options: Any) -> int:
        """Start or continue the calibration; return its process."""
        self._ending.unlink(missing_ok=True)
        sys.stdout.flush()
        sys.stderr.flush()
        process = os.fork()
        if process == 0:
            code = 1
            try:
                os.setsid()
                faulthandler.register(signal.SIGUSR1, self._stacks.open("w"))
                self._calibrate(options)
                code = 0
            finally:
                os._exit(code)
        self._groups.append(process)
        return process

    def _calibrate(self, options: Mapping[str, Any]) -> None:
        """Calibrate in the forked process, and record its end."""
        os.environ[LOG_VARIABLE] = str(self.log)
        os.environ[SECONDS_VARIABLE] = str(self.variant.seconds)
        os.environ[OUTPUT_VARIABLE] = str(self.variant.output)
        # A machine that fails here does so on purpose, and recovers at once.
        at_once = partial(CampaignOptions, retry_pauses=(0.0, 0.0))
        patch.object(calibration, "CampaignOptions", at_once).start()
        target = Target("angle", 27.0, tolerance=self.variant.tolerance)
        try:
            with self._executor() as executor:
                result = calibration.calibrate(
                    Problem([FRICTION], [target]),
                    self._solver(),
                    strategy=self.variant.strategy,
                    workers=self.variant.workers,
                    workdir=self.work,
                    executor=executor,
                    **{**self.variant.options, **options},
                )
            ending: dict[str, Any] = {"result": _essence(result)}
        except GrainfitError as error:
            ending = {"error": type(error).__name__, "message": str(error)}
        except BaseException as error:
            ending = {"error": type(error).__name__, "message": traceback.format_exc()}
        new = self._ending.with_suffix(".new")
        new.write_text(json.dumps(ending), encoding="utf-8")
        new.rename(self._ending)

    @contextmanager
    def _executor(self) -> Iterator[Executor | None]:
        if not self.variant.pool:
            yield None
            return
        context = multiprocessing.get_context("fork")
        pool = ProcessPoolExecutor(self.variant.workers, mp_context=context)
        yield pool
        pool.shutdown()

    def _solver(self) -> Any:
        if self.variant.solver == "function":
            return PythonCallable(function, identity="crash")
        return Command(self._model, ["./simulate.sh", "{{ friction }}", "{{ seed }}"])

    def wait(self, process: int, meanwhile: Callable[[], None] = lambda: None) -> Ending:
        """Wait for the end of a start, and call a function repeatedly until then."""
        deadline = time.monotonic() + _PATIENCE
        while os.waitpid(process, os.WNOHANG)[0] == 0:
            meanwhile()
            if time.monotonic() > deadline:
                message = f"no end within {_PATIENCE:g} s:\n{self._stacks_of(process)}"
                os.kill(process, signal.SIGKILL)
                os.waitpid(process, 0)
                return Ending(error="Hang", message=message)
            time.sleep(0.002)
        return self.ending()

    def _stacks_of(self, process: int) -> str:
        """Where all threads of a start and of its workers are."""
        for one in (process, *children(process)):
            os.kill(one, signal.SIGUSR1)
            time.sleep(0.2)
        return self._stacks.read_text(encoding="utf-8")

    def ending(self) -> Ending:
        """End of the last start; empty when it was killed before its end."""
        if not self._ending.exists():
            return Ending()
        return Ending(**json.loads(self._ending.read_text(encoding="utf-8")))

    def kill_after(self, process: int, seconds: float) -> bool:
        """Kill only the process of a start after a while; return True if it was still alive."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if os.waitpid(process, os.WNOHANG)[0]:
                return False
            time.sleep(0.0005)
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
        return not self._ending.exists()

    def clear_away(self) -> None:
        """End processes left over from killed starts, such as workers of a pool."""
        for group in self._groups:
            try:
                os.killpg(group, signal.SIGKILL)
            except ProcessLookupError:
                continue
        self._groups.clear()

    # Checks -------------------------------------------------------------------------------------

    def starts(self) -> Counter[Key]:
        """Number of times that the model was started, for each run."""
        return Counter(key for _, key in self.programs())

    def finished(self) -> dict[Key, RunRecord]:
        """Finished runs: their record is in the store, or their folder has its final name."""
        return self._in_folders() | {_key_of(record): record for record in self._stored()}

    def _in_folders(self) -> dict[Key, RunRecord]:
        found = {}
        for path in (self.work / "runs").glob("*"):
            record = None if path.suffix == PARTIAL_SUFFIX else read_record(path)
            if record is not None and record.status == "finished":
                found[_key_of(record)] = record
        return found

    def _stored(self) -> list[RunRecord]:
        """Read a copy of the store: on a full disk there is no room even for reading."""
        files = [self.work / STORE_NAME, self.work / f"{STORE_NAME}-wal"]
        if not files[0].exists() or files[0].stat().st_size == 0:
            return []
        with tempfile.TemporaryDirectory() as copy:
            for file in files:
                if file.exists():
                    shutil.copy(file, copy)
            try:
                store = RunStore.read_only(Path(copy))
            except StoreError as error:
                # Killed before anything was written to the store.
                if messages.STORE_EMPTY.is_in(str(error)):
                    return []
                raise
            try:
                return store.runs("finished")
            finally:
                store.close()

    def programs(self) -> list[tuple[int, Key]]:
        """Process of every program that was started, with its run."""
        lines = (line.split() for line in self.log.read_text(encoding="utf-8").splitlines())
        return [(int(words[1]), _key(*words[2:])) for words in lines if words[0] == "started"]

    def look(self, when: str) -> None:
        """Complain about runs that were finished earlier and are now lost or repeated."""
        finished, starts = self.finished(), self.starts()
        for key, before in self._finished.items():
            if key not in finished:
                self._tally.lost.append(f"{when}: {key}")
            if starts[key] > before:
                self._tally.repeated.append(f"{when}: {key}")
        for key, record in finished.items():
            if not _agree(record, key):
                self._tally.different.append(f"{when}: {key} gave {record.responses}")
        self._finished = {key: starts[key] for key in finished}

    def forget_finished(self, folders_only: bool = False) -> None:
        """Expect only the runs that are finished now: the rest was destroyed on purpose."""
        starts = self.starts()
        finished = self._in_folders() if folders_only else self.finished()
        self._finished = {key: starts[key] for key in finished}

    def look_into_folders(self) -> None:
        """Complain about finished runs of the store that could not be found without it."""
        found = self._in_folders()
        lost = [_key_of(record) for record in self._stored() if _key_of(record) not in found]
        self._tally.lost += [f"in no folder: {key}" for key in lost]

    def complain(self, condition: bool, message: str) -> None:
        """Record a complaint."""
        if not condition:
            self._tally.different.append(message)

    def expect_error(self, ending: Ending, errors: Collection[str], words: str) -> None:
        """Complain unless a start ended with one of some errors, whose message has some words."""
        self.complain(
            ending.error in errors and words in ending.message, f"{ending.error}: {ending.message}"
        )

    def compare(self, ending: Ending, reference: Mapping[str, Any]) -> None:
        """Complain if an answer differs from that of the undisturbed calibration."""
        if ending.result is None:
            self._tally.different.append(f"{ending.error or 'killed'}: {ending.message}")
            return
        wanted = reference if self.variant.exact else {"status": reference["status"]}
        for name, value in wanted.items():
            if ending.result[name] != value:
                self._tally.different.append(f"{name}: {ending.result[name]} instead of {value}")
        stored = {_key_of(record) for record in self._stored()}
        history = ending.result["history"]
        asked = {_key(run["parameters"]["friction"], run["seed"]) for run in history}
        if not asked <= stored:
            self._tally.lost.append(f"not in the store at the end: {asked - stored}")
        # A run that no start asks for again was wasted.
        if self.variant.same_history and not stored <= asked:
            self._tally.lost.append(f"not used for the answer: {stored - asked}")


def undisturbed(variant: Variant, folder: Path) -> tuple[dict[str, Any], float]:
    """Return the result of an undisturbed calibration, and its duration, s."""
    trial = Trial(variant, folder, Tally("none"))
    started = time.monotonic()
    ending = trial.wait(trial.start())
    seconds = time.monotonic() - started
    if ending.result is None:
        raise RuntimeError(f"the undisturbed calibration ended with {ending.message}")
    repeats = [key for key, count in trial.starts().items() if count > 1]
    if ending.result["status"] != "calibrated" or repeats:
        raise RuntimeError(f"the undisturbed calibration is none: {ending.result}, {repeats}")
    return ending.result, seconds


@dataclass
class Faults:
    """Faults of one kind in calibrations of one variant, at random moments.

    Parameters
    ----------
    variant : Variant
        Settings of the calibrations.
    times : int
        Number of faults.
    folder : Path
        Folder for the calibrations.
    seed : int
        Decides the moments.
    progress : callable
        Called after each fault.
    """

    variant: Variant
    times: int
    folder: Path
    seed: int = 1
    progress: Progress = _silent

    def __post_init__(self) -> None:
        self.chance = random.Random(self.seed)
        self.tally = Tally(self.variant.name)
        self.reference, self._seconds = undisturbed(self.variant, self.folder / "undisturbed")

    @property
    def enough(self) -> bool:
        """Whether all faults were injected."""
        return self.tally.injected >= self.times

    def trials(self) -> Iterator[Trial]:
        """Yield calibrations until all faults were injected."""
        number = 0
        while not self.enough:
            number += 1
            trial = Trial(self.variant, self.folder / str(number), self.tally)
            try:
                yield trial
            finally:
                trial.clear_away()

    def seconds(self) -> float:
        """Return a random part of the duration of an undisturbed calibration, s."""
        return self._seconds * self.chance.random()

    def late(self) -> float:
        """Return a random part of the second half of it, s."""
        return self._seconds * (0.5 + 0.5 * self.chance.random())

    def count(self) -> None:
        """Count a fault."""
        self.tally.injected += 1
        self.progress(self.tally)

    def judge(self, trial: Trial, ending: Ending) -> None:
        """Complain about a calibration at its end."""
        trial.look(f"{trial.name}, end")
        trial.compare(ending, self.reference)

    def complain_about_repeats(self, trial: Trial, allowed: Mapping[Key, int]) -> None:
        """Complain about runs that were started again without need."""
        self.tally.repeated += [
            f"{trial.name}: {key} was started {count} times"
            for key, count in trial.starts().items()
            if count > 1 + allowed.get(key, 0)
        ]


def kill_at_random(
    variant: Variant,
    kills: int,
    folder: Path,
    seed: int = 1,
    disturb: Callable[[Trial, random.Random], None] | None = None,
    progress: Progress = _silent,
) -> Tally:
    """Kill calibrations at random moments; ``disturb`` does more harm after each kill.

    A calibration is killed, started again, killed again, and so on until it ends before its turn.
    """
    faults = Faults(variant, kills, folder, seed, progress)
    for trial in faults.trials():
        process = trial.start()
        while not faults.enough:
            # Every fourth one at once: before there is a store, or while it is repaired.
            share = 0.05 if faults.chance.random() < 0.25 else 1.0
            if not trial.kill_after(process, share * faults.seconds()):
                break
            trial.look(f"kill {faults.tally.injected + 1}")
            if disturb is not None:
                disturb(trial, faults.chance)
                trial.forget_finished()
            faults.count()
            process = trial.start()
        faults.judge(trial, trial.ending() if trial.ending().result else _end(trial, process))
    return faults.tally


def _end(trial: Trial, process: int) -> Ending:
    try:
        return trial.wait(process)
    except ChildProcessError:
        return trial.ending()


# Faults other than a kill of the whole process ----------------------------------------------------


def kill_solvers(times: int, folder: Path, seed: int = 1, progress: Progress = _silent) -> Tally:
    """Kill the program of a run, up to twice for each run: only this run must be tried again."""
    faults = Faults(Variant("solver killed"), times, folder, seed, progress)
    for trial in faults.trials():
        seen: set[int] = set()
        killed: Counter[Key] = Counter()

        def kill(
            trial: Trial = trial, seen: set[int] = seen, killed: Counter[Key] = killed
        ) -> None:
            for pid, key in trial.programs():
                if pid in seen or killed[key] == 2 or faults.enough:
                    continue
                seen.add(pid)
                if faults.chance.random() < 0.5 and _kill_program(pid):
                    killed[key] += 1
                    faults.count()

        faults.judge(trial, trial.wait(trial.start(), kill))
        faults.complain_about_repeats(trial, killed)
    return faults.tally


def _kill_program(pid: int) -> bool:
    """Kill a program of the calibration, unless it has already ended."""
    try:
        program = psutil.Process(pid)
        if "simulate.sh" not in " ".join(program.cmdline()):
            return False
        program.kill()
    except psutil.Error:
        return False
    return True


def kill_pool_workers(
    times: int, folder: Path, seed: int = 1, progress: Progress = _silent
) -> Tally:
    """Kill a worker of a pool: the calibration ends with a message; a new start continues it."""
    variant = Variant("pool worker killed", workers=2, pool=True)
    faults = Faults(variant, times, folder, seed, progress)
    for trial in faults.trials():
        while True:
            process = trial.start()
            moment = time.monotonic() + faults.seconds()
            killed: list[int] = []

            def kill(
                process: int = process, moment: float = moment, killed: list[int] = killed
            ) -> None:
                workers = children(process)
                if not killed and workers and time.monotonic() > moment:
                    killed.append(faults.chance.choice(workers))
                    os.kill(killed[0], signal.SIGKILL)

            ending = trial.wait(process, (lambda: None) if faults.enough else kill)
            if ending.result is not None:
                break
            trial.look(f"kill {faults.tally.injected}")
            trial.expect_error(ending, ("ExecutorError",), "start again")
            faults.count()
        faults.judge(trial, ending)
    return faults.tally


def children(process: int) -> list[int]:
    """Processes that a process has started and that have not ended."""
    try:
        return [child.pid for child in psutil.Process(process).children()]
    except psutil.Error:
        return []


def is_alive(process: int) -> bool:
    """Whether a process is running; a zombie is not."""
    try:
        return psutil.Process(process).status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


def truncate_newest(trial: Trial, chance: random.Random) -> None:
    """Damage the newest files as a power cut may do: truncate them, or fill them with zeros.

    The store itself has its own test, see `damage_stores`.
    """
    runs = sorted(trial.work.glob("runs/*"), key=lambda path: path.stat().st_mtime)
    newest = [file for run in runs[-2:] for file in run.glob("*") if file.is_file()]
    beside = [trial.work / name for name in (f"{STORE_NAME}-shm", "lock", "result.json")]
    for path in [trial.work / f"{STORE_NAME}-wal", *newest, *beside]:
        if not path.exists() or chance.random() < 0.3:
            continue
        size = path.stat().st_size
        left = chance.randrange(size + 1)
        os.truncate(path, left)
        if chance.random() < 0.3 and not path.name.startswith(STORE_NAME):
            os.truncate(path, size)


def damage_stores(times: int, folder: Path, seed: int = 1, progress: Progress = _silent) -> Tally:
    """Truncate the store itself or fill it with zeros, and follow the message."""
    variant = Variant("store truncated", same_history=False)
    faults = Faults(variant, times, folder, seed, progress)
    for trial in faults.trials():
        store = trial.work / STORE_NAME
        while trial.kill_after(trial.start(), faults.late()):
            if store.exists() and store.stat().st_size:
                break
        trial.look("killed")
        trial.look_into_folders()
        size = store.stat().st_size
        left = faults.chance.choice(
            [0, 100, faults.chance.randrange(size), size - size % 4096 - 4096]
        )
        os.truncate(store, left)
        if faults.chance.random() < 0.3:
            os.truncate(store, size)
        trial.forget_finished(folders_only=True)
        ending = trial.wait(trial.start())
        if ending.result is None:
            trial.expect_error(ending, ("StoreError",), f"Move {STORE_NAME} away")
            for name in (STORE_NAME, f"{STORE_NAME}-wal", f"{STORE_NAME}-shm"):
                if (trial.work / name).exists():
                    (trial.work / name).rename(trial.work / f"{name}.damaged")
            ending = trial.wait(trial.start())
        faults.judge(trial, ending)
        faults.count()
    return faults.tally


def _removable(trial: Trial, whole: bool) -> list[Path]:
    if whole:
        return [trial.work] if list(trial.work.glob("runs/*")) else []
    return list(trial.work.glob(f"runs/*{PARTIAL_SUFFIX}"))[:1]


def remove_folders(times: int, folder: Path, seed: int = 1, progress: Progress = _silent) -> Tally:
    """Remove the work folder during the runs (the first half), or the folder of a run."""
    faults = Faults(Variant("folder removed"), times, folder, seed, progress)
    for trial in faults.trials():
        whole = faults.tally.injected < times // 2
        moment = time.monotonic() + faults.seconds()
        removed: list[Path] = []
        before: list[int] = []

        def remove(
            trial: Trial = trial,
            before: list[int] = before,
            whole: bool = whole,
            moment: float = moment,
            removed: list[Path] = removed,
        ) -> None:
            if removed or time.monotonic() < moment:
                return
            removed.extend(_removable(trial, whole))
            before.append(len(trial.programs()))
            for path in removed:
                while path.exists():
                    shutil.rmtree(path, ignore_errors=True)

        ending = trial.wait(trial.start(), remove)
        if not removed:
            continue
        if whole and ending.result is not None:
            # Too late to matter: only the result was left to be written.
            trial.complain(len(trial.programs()) == before[0], "the removal was not noticed")
            continue
        if whole:
            trial.expect_error(ending, ("StoreError", "RunFailedError"), "again")
            trial.forget_finished()
            ending = trial.wait(trial.start())
        faults.judge(trial, ending)
        faults.count()
    return faults.tally


@contextmanager
def small_disk(place: Path, size: int) -> Iterator[Path]:
    """Yield the folder of a small file system.

    Raises
    ------
    PermissionError
        The file system cannot be mounted: only root may do it, and not everywhere.
    """
    place.mkdir(parents=True)
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(place)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise PermissionError(f"a file system cannot be mounted here: {error}") from error
    if done.returncode:
        raise PermissionError(f"a file system cannot be mounted here: {done.stderr.strip()}")
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def fill_disks(times: int, folder: Path, seed: int = 1, progress: Progress = _silent) -> Tally:
    """Let the disk become full, then make room and start again."""
    faults = Faults(Variant("disk full", output=400_000), times, folder, seed, progress)
    for trial in faults.trials():
        with small_disk(trial.work.parent / "disk", _DISK_BYTES) as disk:
            trial.work = disk / "work"
            ballast = disk / "ballast"
            # The runs write 7 MB, and 4 MB are reserved if there is room.
            left = faults.chance.choice(
                [100_000, 4_100_000, 8_200_000, faults.chance.randrange(9_000_000)]
            )
            with ballast.open("wb") as file:
                os.posix_fallocate(file.fileno(), 0, _DISK_BYTES - left)
            ending = trial.wait(trial.start())
            trial.look("full")
            if ending.result is None:
                trial.expect_error(ending, ("StoreError", "RunFailedError"), "full")
                faults.count()
                ballast.unlink()
                ending = trial.wait(trial.start())
            faults.judge(trial, ending)
    return faults.tally


def _essence(result: Result) -> dict[str, Any]:
    """Part of a result that must not depend on the number of interruptions."""
    data = json.loads(json.dumps(result.to_dict()))
    history = [
        {name: run[name] for name in ("stage", "parameters", "seed", "responses")}
        for run in data["history"]
    ]
    return {
        "status": data["status"],
        "parameters": data["parameters"],
        "responses": data["responses"],
        "history": history,
    }


def _key(friction: str | float, seed: str | int) -> Key:
    return float(friction), int(seed)


def _key_of(record: RunRecord) -> Key:
    return _key(record.definition.parameters["friction"], record.definition.seed)


def _agree(record: RunRecord, key: Key) -> bool:
    return abs(scalars(record.responses)["angle"].value - expected(key)) < 1e-9
