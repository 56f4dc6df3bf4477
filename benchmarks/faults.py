"""Inject faults into calibrations and count lost and repeated runs.

Each row is one kind of fault, at random moments, with real processes and a real program that counts
its own starts (see `tests.crash.crash_harness`). After each fault the calibration is started
again; at its end, status, parameters, responses and history are compared with those of an
undisturbed calibration. With several workers, where the order in which runs finish decides the next
proposals, and where the record of the proposals is destroyed, only the status is compared.

A full disk is a file system of 32 MB, which only root may mount; the server of a shared store is
Debian's PostgreSQL. Where these are not to be had, the rows are left out.
Exits with code 1 when a run was lost or repeated, or a result differs.

With --cells, single cells of a finished store are damaged instead, one at a time, and the work
folder is used with every command (see `tests.crash.damaged_cells`). Exits with code 1 when one
of them neither answers nor ends with a message that names the file.

    python benchmarks/faults.py [--kills N] [--seed N] [--json PATH]
    python benchmarks/faults.py --cells N [--seed N]
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from threadpoolctl import threadpool_limits

# The harness belongs to the tests, which are found from the root of the repository.
sys.path.append(str(Path(__file__).parents[1]))

from tests.crash.crash_harness import (
    VARIANTS,
    Progress,
    Tally,
    Variant,
    damage_stores,
    fill_disks,
    kill_at_random,
    kill_pool_workers,
    kill_solvers,
    remove_folders,
    truncate_newest,
)
from tests.crash.damaged_cells import USES, complaints, finished_calibration
from tests.servers.server_faults import cut_connections, restart_servers

#: Called with the work folder; reports every fault.
Infliction = Callable[[Path, Progress], Tally]


def inflictions(kills: int, seed: int) -> Iterator[Infliction]:
    """Return the kinds of faults in the order of the table; the first as often as asked for."""
    some = max(1, kills // 5)
    for variant in VARIANTS:
        times = kills if variant is VARIANTS[0] else some
        yield partial(_kill, variant, times, seed)
    for inflict in (kill_solvers, kill_pool_workers):
        yield partial(_inflict, inflict, some, seed)
    yield partial(_truncate, some, seed)
    for inflict in (damage_stores, fill_disks, remove_folders, restart_servers, cut_connections):
        yield partial(_inflict, inflict, some, seed)


def _kill(variant: Variant, times: int, seed: int, folder: Path, progress: Progress) -> Tally:
    return kill_at_random(variant, times, folder, seed, progress=progress)


def _truncate(times: int, seed: int, folder: Path, progress: Progress) -> Tally:
    variant = Variant("files truncated", same_history=False)
    return kill_at_random(variant, times, folder, seed, truncate_newest, progress)


def _inflict(
    inflict: Callable[..., Tally], times: int, seed: int, folder: Path, progress: Progress
) -> Tally:
    return inflict(times, folder, seed, progress)


def _show_progress(tally: Tally) -> None:
    print(f"\r{tally.fault}: {tally.injected} ", end="", file=sys.stderr, flush=True)


def damage_cells(times: int, seed: int) -> int:
    """Damage single cells, and return how many uses of a work folder ended badly."""
    bad = 0
    with tempfile.TemporaryDirectory() as folder, threadpool_limits(1, user_api="blas"):
        original = finished_calibration(Path(folder) / "original")
        for number in range(times):
            for complaint in complaints(original, Path(folder), seed + number, USES):
                bad += 1
                print(f"\r{complaint}", file=sys.stderr)
            print(f"\rcells damaged: {number + 1} ", end="", file=sys.stderr, flush=True)
    print(f"\n{times} cells damaged, {len(USES)} uses of each work folder, {bad} ended badly")
    return bad


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100, help="of the first kind; of others 1/5")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--cells", type=int, help="damage only single cells of a store, N times")
    options = parser.parse_args()
    if options.cells:
        sys.exit(1 if damage_cells(options.cells, options.seed) else 0)
    rows, complaints = [], []
    print("| fault | injected | runs lost | runs repeated | answer equal |")
    print("|---|---|---|---|---|", flush=True)
    for inflict in inflictions(options.kills, options.seed):
        started = time.monotonic()
        with tempfile.TemporaryDirectory() as folder, threadpool_limits(1, user_api="blas"):
            try:
                tally = inflict(Path(folder), _show_progress)
            except (PermissionError, FileNotFoundError) as error:
                print(f"\rleft out: {error}", file=sys.stderr)
                continue
        row = {
            "fault": tally.fault,
            "injected": tally.injected,
            "lost": len(tally.lost),
            "repeated": len(tally.repeated),
            "equal": not tally.different,
            "seconds": time.monotonic() - started,
        }
        rows.append(row)
        complaints += [*tally.lost, *tally.repeated, *tally.different]
        equal = "yes" if row["equal"] else "NO"
        print("\r", end="", file=sys.stderr, flush=True)
        print(
            f"| {tally.fault} | {tally.injected} | {row['lost']} | {row['repeated']} | {equal} |",
            flush=True,
        )
        if options.json:
            options.json.write_text(json.dumps(rows, indent=1))
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
