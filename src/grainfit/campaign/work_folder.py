"""The work folder of a calibration: its run folders, and the files that are kept.

A run executes in ``runs/IDENTITY.ATTEMPT.partial``. When it has ended, its record is written next
to the solver's files as ``run.json`` and the folder is renamed to ``runs/IDENTITY``: a folder of
that name is always complete, and the store can be rebuilt from the folders.

A run that was killed, and has a restart file, waits as ``runs/IDENTITY.interrupted`` for the next
attempt, which continues in a copy of that folder.
"""

from __future__ import annotations

import json
import secrets
import shutil
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from grainfit.campaign.keep import Keep
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import UNUSABLE, RunStore
from grainfit.files import LARGEST_RESPONSES, read_within, write_atomically
from grainfit.solvers.process.restart_files import remove_restart_files, restart_states

RECORD_NAME = "run.json"
RESULT_NAME = "result.json"
PARTIAL_SUFFIX = ".partial"
INTERRUPTED_SUFFIX = ".interrupted"
_KEPT_SUFFIXES = frozenset({".log", ".png", ".json"})


def default_workdir(file: Path) -> Path:
    """Default work folder of a calibration file."""
    return Path(f"{file.stem}.grainfit")


def simulations_folder(file: Path) -> Path:
    """Default folder of single simulations: apart from the calibration, which starts cold."""
    return Path(f"{file.stem}.simulated")


def recover(folder: Path, store: RunStore) -> None:
    """Clean up after a killed process: end its solvers, keep every finished run."""
    # Imported where processes are ended: the commands that only read start without psutil.
    from grainfit.solvers.process.orphans import end_orphans

    store.forget_unsettled()
    runs = folder / "runs"
    for path in runs.glob(f"*{PARTIAL_SUFFIX}"):
        end_orphans(path)
        put_aside(path)
    # A worker that outlived its process may have finished its run until now, but not later.
    states = store.states()
    unknown = [path for path in sorted(runs.iterdir()) if states.get(path.name) != "finished"]
    records = {path.name: read_record(path) for path in unknown}
    # Failed runs that the store has forgotten are made again.
    store.save_many(
        record
        for name, record in records.items()
        if record is not None and record.status == "finished" and record.identity == name
    )


def read_record(folder: Path) -> RunRecord | None:
    """Read the record of a run folder; None when it is missing or damaged."""
    try:
        data = json.loads(read_within(folder / RECORD_NAME, LARGEST_RESPONSES))
        return RunRecord.from_json(data)
    except (OSError, *UNUSABLE):
        return None


def run_folder(folder: Path, identity: str) -> Path:
    """Folder of a run that has ended."""
    return folder / "runs" / identity


def open_run_folder(folder: Path, identity: str) -> Path:
    """Create a new folder in which a run executes.

    Every attempt has its own folder: a worker that outlives the process that started it must not
    write into the folder of the next attempt.
    """
    partial = folder / "runs" / f"{identity}.{secrets.token_hex(4)}{PARTIAL_SUFFIX}"
    # A work folder that was removed must not be created again without its store.
    partial.parent.mkdir(exist_ok=True)
    _copy_interrupted(folder, identity, partial)
    partial.mkdir(exist_ok=True)
    return partial


def _interrupted(folder: Path, identity: str) -> Path:
    """Folder of a run that waits for its continuation."""
    return folder / "runs" / f"{identity}{INTERRUPTED_SUFFIX}"


def put_aside(partial: Path) -> None:
    """Keep the folder of a killed run that can be continued; remove others.

    Of two such attempts, the one whose last restart file is later is kept.
    """
    interrupted = _interrupted(partial.parents[1], partial.name.partition(".")[0])
    if _restart_time(partial) > _restart_time(interrupted):
        shutil.rmtree(interrupted, ignore_errors=True)
        with suppress(OSError):
            partial.rename(interrupted)
    shutil.rmtree(partial, ignore_errors=True)


def _restart_time(folder: Path) -> float:
    """Return when the last restart file of a run was complete, s; 0 without one."""
    return max((path.stat().st_mtime for path in restart_states(folder)), default=0.0)


def _copy_interrupted(folder: Path, identity: str, partial: Path) -> None:
    """Begin a run folder with the files of an attempt that was killed, if there is one.

    They are copied: a program that outlives its process, as on another machine, may still write
    into the old ones. What says that the restart files are complete comes last.
    """
    sources = [_interrupted(folder, identity), run_folder(folder, identity)]
    source = max(sources, key=_restart_time)
    if not _restart_time(source):
        return
    states = [path.name for path in restart_states(source)]
    leave = shutil.ignore_patterns(".session", RECORD_NAME, *states)
    shutil.copytree(source, partial, ignore=leave)
    for name in states:
        shutil.copy2(source / name, partial)
    shutil.rmtree(sources[0], ignore_errors=True)


def close_run_folder(partial: Path, final: Path, record: RunRecord, keep: Keep = "all") -> None:
    """Write the record of an ended run into its folder, and give the folder its final name."""
    # The next attempt continues where a machine failed.
    if record.kind != "machine":
        remove_restart_files(partial)
        shutil.rmtree(_interrupted(final.parents[1], final.name), ignore_errors=True)
    write_atomically(partial / RECORD_NAME, json.dumps(record.to_json(), indent=1))
    if _is_as_good(read_record(final), record):
        # Another worker has finished the same run meanwhile; finished runs are never removed.
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
        # Last, because removing many files takes a while, in which the run could be lost.
        with suppress(OSError):
            prune_run_folder(final)


def _is_as_good(kept: RunRecord | None, record: RunRecord) -> bool:
    if kept is None or kept.status != "finished":
        return False
    return record.responses.keys() <= kept.responses.keys()


def discard_partial_folders(folder: Path, identities: Iterable[str]) -> None:
    """End the solvers of unfinished runs on this machine, and remove or put aside the run folders.

    Workers on other machines notice that their folder is gone, and end.
    """
    from grainfit.solvers.process.orphans import end_orphans

    for identity in identities:
        for partial in (folder / "runs").glob(f"{identity}.*{PARTIAL_SUFFIX}"):
            # Rename it first: the worker would otherwise store the stopped run as failed.
            # Its solvers are recognised by the beginning of its name.
            gone = partial.with_name(f"{partial.stem}.gone{PARTIAL_SUFFIX}")
            with suppress(OSError):
                partial.rename(gone)
            end_orphans(gone)
            put_aside(gone)


def prune_run_folder(folder: Path) -> int:
    """Remove all files except record, logs and pictures; return the number of bytes freed.

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
