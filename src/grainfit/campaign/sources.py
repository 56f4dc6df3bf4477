"""Runs of other work folders and stores, taken over as far as they fit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from grainfit.campaign.known import is_run_of
from grainfit.campaign.store import STORE_NAME, RunStore, not_a_work_folder
from grainfit.errors import InputError
from grainfit.problem import Problem
from grainfit.solvers.base import Solver


def take_runs(
    other: RunStore, problem: Problem, solvers: Mapping[str, Solver], store: RunStore
) -> int:
    """Copy those runs of another store that are runs of a problem; return how many were new.

    Parameters
    ----------
    other : RunStore
        Is only read.
    problem : Problem
        What is calibrated.
    solvers : mapping of str to Solver
        By name of the test.
    store : RunStore
        Where the copies go.
    """
    there = store.states()
    fitting = is_run_of(problem, solvers)
    new = [
        replace(record, origin=record.origin or other.place)
        for record in other.runs("finished")
        if there.get(record.identity) != "finished" and fitting(record)
    ]
    store.save_many(new)
    return len(new)


@contextmanager
def open_source(source: str | Path, key: str = "runs_from") -> Iterator[RunStore]:
    """Open the store of a work folder, or one at an address, to read.

    Parameters
    ----------
    source : path or str
        A work folder, or the address of a store.
    key : str
        What a fault is said to be of.

    Raises
    ------
    InputError
        The folder has no store.
    StoreError
        The store cannot be read.
    """
    if "://" in str(source):
        store = RunStore(str(source), read_only=True)
    else:
        folder = Path(source)
        if not (folder / STORE_NAME).is_file():
            remedy = "Name the folder that 'grainfit run' wrote, or the address of a store."
            raise InputError(replace(not_a_work_folder(source, key), remedy=remedy))
        store = RunStore.read_only(folder)
    try:
        yield store
    finally:
        store.close()
