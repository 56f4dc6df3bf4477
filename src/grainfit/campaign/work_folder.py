"""The work folder of a calibration: who holds it, where runs happen, what is kept of them.

A run happens in ``runs/IDENTITY.ATTEMPT.partial``. When it has ended, its record is written beside
the solver's files as ``run.json`` and the folder is renamed to ``runs/IDENTITY``: a folder of that
name is always whole, and the store can be made anew from the folders.
"""

from __future__ import annotations

import fcntl
import json
import os
import secrets
import shutil
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TextIO

from grainfit.campaign.keep import Keep
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.errors import StoreError
from grainfit.files import write_atomically
from grainfit.solvers.process.process import end_orphan

RECORD_NAME = "run.json"
RESULT_NAME = "result.json"
PARTIAL_SUFFIX = ".partial"
_KEPT_SUFFIXES = frozenset({".log", ".png", ".json"})
#: A look at whether a folder is held takes its lock for a moment; nobody is refused for that.
_LOCK_SECONDS = 1.0
_held: set[TextIO] = set()


def _let_go() -> None:
    for file in _held:
        file.close()
    _held.clear()


# Workers of a pool are forked with all open files, and outlive a process that is killed: the lock
# must not live on with them.
os.register_at_fork(after_in_child=_let_go)


def default_workdir(file: Path) -> Path:
    """Work folder of a calibration file when none is named."""
    return Path(f"{file.stem}.grainfit")


@contextmanager
def hold(folder: Path) -> Iterator[None]:
    """Hold a work folder for this process alone.

    Raises
    ------
    StoreError
        The folder cannot be made or written, or another process holds it.
    """
    path = folder / "lock"
    try:
        (folder / "runs").mkdir(parents=True, exist_ok=True)
        file = path.open("a+", encoding="utf-8")
    except OSError as error:
        raise StoreError(
            f"the work folder {str(folder)!r} cannot be used: {error.strerror}. "
            "Choose another with --workdir."
        ) from error
    with file:
        if not _lock(file, folder):
            file.seek(0)
            raise StoreError(
                f"the work folder {str(folder)!r} is in use by process {file.read().strip()}. "
                "Wait for it to end, or choose another folder with --workdir."
            )
        _held.add(file)
        try:
            _sign(file)
            yield
        finally:
            _held.discard(file)


def _sign(file: TextIO) -> None:
    """Write down who holds the folder; the lock counts, so that a full disk is no hindrance."""
    with suppress(OSError):
        os.ftruncate(file.fileno(), 0)
        os.write(file.fileno(), f"{os.getpid()}\n".encode())


def _lock(file: TextIO, folder: Path) -> bool:
    deadline = time.monotonic() + _LOCK_SECONDS
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() > deadline:
                return False
            time.sleep(0.02)
        except OSError as error:
            raise StoreError(
                f"the work folder {str(folder)!r} cannot be locked: {error.strerror}. "
                "Choose one on a local disk with --workdir."
            ) from error


def is_held(folder: Path) -> bool:
    """Return whether a process is at work in the folder now."""
    try:
        with (folder / "lock").open("r", encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def recover(folder: Path, store: RunStore) -> None:
    """Put in order what a killed process left: end its solvers, keep every finished run."""
    store.forget_running()
    runs = folder / "runs"
    for path in runs.glob(f"*{PARTIAL_SUFFIX}"):
        end_orphan(path)
        shutil.rmtree(path, ignore_errors=True)
    # A worker that has outlived its process may have finished its run up to now, but not later.
    states = store.states()
    unknown = [path for path in sorted(runs.iterdir()) if states.get(path.name) != "finished"]
    records = {path.name: read_record(path) for path in unknown}
    # Failures that the store has forgotten are to be made again.
    store.save_many(
        record
        for name, record in records.items()
        if record is not None and record.status == "finished" and record.identity == name
    )


def read_record(folder: Path) -> RunRecord | None:
    """Read the record kept in a run folder; None when there is none or it is damaged."""
    try:
        data = json.loads((folder / RECORD_NAME).read_text(encoding="utf-8"))
        return RunRecord.from_json(data)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def run_folder(folder: Path, identity: str) -> Path:
    """Folder of a run that has ended."""
    return folder / "runs" / identity


def open_run_folder(folder: Path, identity: str) -> Path:
    """Make a fresh folder for a run to happen in.

    Every attempt has one of its own: a worker that lives on after the process that sent it has died
    must not write among the files of its successor.
    """
    partial = folder / "runs" / f"{identity}.{secrets.token_hex(4)}{PARTIAL_SUFFIX}"
    # A work folder that was removed must not come to life again, without its store.
    partial.parent.mkdir(exist_ok=True)
    partial.mkdir()
    return partial


def close_run_folder(partial: Path, final: Path, record: RunRecord, keep: Keep = "all") -> None:
    """Keep the folder of a run that has ended, with its record in it."""
    write_atomically(partial / RECORD_NAME, json.dumps(record.to_json(), indent=1))
    if _is_as_good(read_record(final), record):
        # Another worker has made the same run meanwhile; what is finished is never removed.
        shutil.rmtree(partial, ignore_errors=True)
        return
    shutil.rmtree(final, ignore_errors=True)
    try:
        partial.rename(final)
    except OSError:
        if read_record(final) is None:
            raise
        shutil.rmtree(partial, ignore_errors=True)
    if keep == "results" and record.status == "finished":
        # Only now: to remove many files takes a while, in which the run could be lost.
        with suppress(OSError):
            prune_run_folder(final)


def _is_as_good(kept: RunRecord | None, record: RunRecord) -> bool:
    if kept is None or kept.status != "finished":
        return False
    return record.responses.keys() <= kept.responses.keys()


def discard_partial_folders(folder: Path, identities: Iterable[str]) -> None:
    """End the solvers of runs that have not ended, as far as they are here; remove the folders.

    Workers elsewhere notice that their folder is gone, and end.
    """
    for identity in identities:
        for partial in (folder / "runs").glob(f"{identity}.*{PARTIAL_SUFFIX}"):
            # First of all out of the worker's reach, who would keep what it takes for a failed run.
            gone = partial.with_name(f"{secrets.token_hex(8)}{PARTIAL_SUFFIX}")
            with suppress(OSError):
                partial.rename(gone)
            end_orphan(gone)
            shutil.rmtree(gone, ignore_errors=True)


def prune_run_folder(folder: Path) -> int:
    """Remove what a solver read and wrote, and keep record, logs, and pictures; return bytes freed.

    Links are removed, never followed.
    """
    freed = 0
    for path in sorted(folder.rglob("*"), reverse=True):
        if path.is_dir() and not path.is_symlink():
            with suppress(OSError):
                path.rmdir()
        elif path.suffix not in _KEPT_SUFFIXES and not path.name.startswith("log."):
            freed += path.lstat().st_size
            path.unlink()
    return freed
