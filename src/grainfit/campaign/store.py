"""The store of runs: one row for every run ever made, the truth about its status and responses.

Runs are kept by identity and belong to no calibration; a calibration only lists which runs it asked
for. So any later calibration that wants the same run finds it.
"""

from __future__ import annotations

import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeVar, cast, get_args
from urllib.parse import unquote

import sqlalchemy as sql
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.pool import StaticPool

from grainfit.campaign.evaluation import Stage
from grainfit.errors import StoreError
from grainfit.solvers.base import Response

SCHEMA_VERSION = 1
RunStatus = Literal["running", "finished", "failed"]
STORE_NAME = "runs.sqlite"

_DAMAGED = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_ERROR)
_RENEW = (
    f"Move {STORE_NAME} away (and {STORE_NAME}-wal and {STORE_NAME}-shm beside it, if there): it "
    "is made anew from the run folders; only runs of Python functions and tables are lost."
)
_Record = TypeVar("_Record")

_metadata = sql.MetaData()
_about = sql.Table("about", _metadata, sql.Column("schema_version", sql.Integer, primary_key=True))
_runs = sql.Table(
    "runs",
    _metadata,
    sql.Column("identity", sql.String(32), primary_key=True),
    sql.Column("test", sql.Text, nullable=False),
    sql.Column("status", sql.String(16), nullable=False, index=True),
    sql.Column("definition", sql.JSON, nullable=False),
    sql.Column("responses", sql.JSON, nullable=False),
    sql.Column("reason", sql.Text, nullable=False),
    sql.Column("kind", sql.String(16), nullable=False),
    sql.Column("log_tail", sql.Text, nullable=False),
    sql.Column("seconds", sql.Float, nullable=False),
    sql.Column("ended", sql.Float, nullable=False),
)
_calibrations = sql.Table(
    "calibrations",
    _metadata,
    sql.Column("identity", sql.String(32), primary_key=True),
    sql.Column("name", sql.Text, nullable=False),
    sql.Column("definition", sql.JSON, nullable=False),
    sql.Column("status", sql.String(16), nullable=False),
    sql.Column("started", sql.Float, nullable=False),
)
_requests = sql.Table(
    "requests",
    _metadata,
    sql.Column("calibration", sql.String(32), primary_key=True),
    sql.Column("position", sql.Integer, primary_key=True),
    sql.Column("stage", sql.String(16), nullable=False),
    sql.Column("parameters", sql.JSON, nullable=False),
    sql.Column("seed", sql.BigInteger, nullable=False),
    sql.Column("runs", sql.JSON, nullable=False),
)


@dataclass(frozen=True)
class RunRecord:
    """One run as the store knows it.

    Parameters
    ----------
    identity, test : str
        Identity of the run and name of the test that it is a run of.
    status : {"running", "finished", "failed"}
        A run that is not there was never started or did not end.
    definition : mapping
        All that decides the outcome, as `Solver.definition` gave it.
    responses : mapping of str to Response
        Empty unless finished.
    reason, kind, log_tail : str
        Why it failed, whose fault it was, and the last lines of the log.
    seconds : float
        Wall time, s.
    ended : float
        When it ended, seconds since the epoch.
    """

    identity: str
    test: str
    status: RunStatus
    definition: Mapping[str, Any]
    responses: Mapping[str, Response] = field(default_factory=dict)
    reason: str = ""
    kind: str = ""
    log_tail: str = ""
    seconds: float = 0.0
    ended: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """Return plain data that `from_json` reads."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> RunRecord:
        """Read what `to_json` wrote.

        Raises
        ------
        KeyError, TypeError, ValueError
            The data is not of a run.
        """
        if data["status"] not in get_args(RunStatus):
            raise ValueError(f"{data['status']!r} is not the status of a run")
        responses = {
            str(name): Response(float(found["value"]), float(found["standard_error"]))
            for name, found in _mapping(data["responses"]).items()
        }
        read = {
            "definition": _mapping(data["definition"]),
            "responses": responses,
            "seconds": float(data["seconds"]),
            "ended": float(data["ended"]),
        }
        return cls(**{**data, **read})


@dataclass(frozen=True)
class CalibrationRecord:
    """A calibration that used this store, with the runs it asked for, in order."""

    identity: str
    name: str
    definition: Mapping[str, Any]
    status: str
    started: float


@dataclass(frozen=True)
class RequestRecord:
    """One parameter set that a calibration asked for."""

    position: int
    stage: Stage
    parameters: Mapping[str, float]
    seed: int
    runs: Mapping[str, str]

    @classmethod
    def from_row(cls, row: Mapping[str, Any]) -> RequestRecord:
        """Read a row of the store.

        Raises
        ------
        KeyError, TypeError, ValueError
            The row is not of a request.
        """
        return cls(
            position=row["position"],
            stage=_stage(row["stage"]),
            parameters=_mapping(row["parameters"]),
            seed=row["seed"],
            runs={str(test): str(run) for test, run in _mapping(row["runs"]).items()},
        )


def _stage(value: Any) -> Stage:
    for stage in get_args(Stage):
        if value == stage:
            return cast(Stage, stage)
    raise ValueError(f"{value!r} is no stage of a calibration")


def _mapping(value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise TypeError(f"{value!r} does not map names to values")
    return value


class RunStore:
    """Index of runs in a database.

    Parameters
    ----------
    url : str or sqlalchemy.URL
        ``"sqlite://"`` keeps everything in memory.
    read_only : bool
        Write nothing, not even a schema.

    Raises
    ------
    StoreError
        The database cannot be opened, or was written by another version.
    """

    def __init__(self, url: str | sql.URL, *, read_only: bool = False) -> None:
        self._lock = threading.RLock()
        url = sql.make_url(url)
        self._where = _place(url)
        options: dict[str, Any] = {}
        if url == sql.make_url("sqlite://"):
            options = {"poolclass": StaticPool, "connect_args": {"check_same_thread": False}}
        self._engine = sql.create_engine(url, **options)
        if self._engine.dialect.name == "sqlite" and not read_only:
            sql.event.listen(self._engine, "connect", _set_up_sqlite)
        try:
            self._check_version() if read_only else self._create()
        except StoreError:
            self.close()
            raise

    @classmethod
    def in_folder(cls, folder: Path) -> RunStore:
        """Open the store of a work folder, and make it if there is none."""
        path = _path(folder)
        return cls(sql.URL.create("sqlite", database=str(path)))

    @classmethod
    def read_only(cls, folder: Path) -> RunStore:
        """Open the store of a work folder to read; a process that writes to it is not disturbed.

        Raises
        ------
        StoreError
            Also when there is no store yet.
        """
        path = _path(folder)
        query = {"uri": "true", "mode": "ro"}
        # Without a write-ahead log nobody writes, and reading one that is not there would make it.
        if not path.with_name(f"{STORE_NAME}-wal").exists():
            query["immutable"] = "1"
        database = path.absolute().as_uri()
        return cls(sql.URL.create("sqlite", database=database, query=query), read_only=True)

    def _create(self) -> None:
        with self._transaction() as connection:
            _metadata.create_all(connection)
            if connection.scalar(sql.select(_about.c.schema_version)) is None:
                connection.execute(_about.insert().values(schema_version=SCHEMA_VERSION))
        self._check_version()

    def _check_version(self) -> None:
        with self._transaction() as connection:
            if not sql.inspect(connection).has_table(_about.name):
                raise StoreError(f"the run store {self._where} is empty: nothing was run yet.")
            version = connection.scalar(sql.select(_about.c.schema_version))
        if version != SCHEMA_VERSION:
            raise StoreError(
                f"the run store {self._where} has schema version {version}, this grainfit "
                f"reads version {SCHEMA_VERSION}. Use the grainfit version that wrote it, or "
                "another work folder."
            )

    @contextmanager
    def _transaction(self) -> Iterator[sql.Connection]:
        with self._lock:
            try:
                with self._engine.begin() as connection:
                    yield connection
            except SQLAlchemyError as error:
                cause = getattr(error, "orig", None) or error
                raise StoreError(
                    f"the run store {self._where} cannot be used: {cause}. {_remedy(cause)}"
                ) from error

    def _read(
        self, query: sql.Select[Any], make: Callable[[Mapping[str, Any]], _Record]
    ) -> list[_Record]:
        with self._transaction() as connection:
            try:
                return [make(row._asdict()) for row in connection.execute(query)]
            except (KeyError, TypeError, ValueError) as error:
                raise StoreError(
                    f"the run store {self._where} is damaged: {error}. {_RENEW}"
                ) from error

    def close(self) -> None:
        """Close all connections."""
        self._engine.dispose()

    def find(self, identity: str) -> RunRecord | None:
        """Return the run of this identity, or None."""
        query = sql.select(_runs).where(_runs.c.identity == identity)
        return next(iter(self._read(query, RunRecord.from_json)), None)

    def save(self, record: RunRecord) -> None:
        """Write a run, in place of what was known of it."""
        row = record.to_json()
        with self._transaction() as connection:
            connection.execute(_runs.delete().where(_runs.c.identity == record.identity))
            connection.execute(_runs.insert().values(**row))

    def forget_running(self) -> None:
        """Drop the rows of runs that were under way when an earlier process died."""
        with self._transaction() as connection:
            connection.execute(_runs.delete().where(_runs.c.status == "running"))

    def forget(self, identity: str) -> None:
        """Drop one run (it was stopped before it ended)."""
        with self._transaction() as connection:
            connection.execute(_runs.delete().where(_runs.c.identity == identity))

    def identities(self) -> set[str]:
        """Return the identities of all runs."""
        with self._transaction() as connection:
            return set(connection.scalars(sql.select(_runs.c.identity)))

    def runs(self) -> list[RunRecord]:
        """Return all runs in the order in which they ended."""
        return self._read(sql.select(_runs).order_by(_runs.c.ended), RunRecord.from_json)

    def begin_calibration(self, identity: str, name: str, definition: Mapping[str, Any]) -> None:
        """Note that a calibration starts, or goes on with what it asked for before."""
        with self._transaction() as connection:
            connection.execute(_calibrations.delete().where(_calibrations.c.identity == identity))
            connection.execute(
                _calibrations.insert().values(
                    identity=identity,
                    name=name,
                    definition=dict(definition),
                    status="running",
                    started=time.time(),
                )
            )

    def end_calibration(self, identity: str, status: str) -> None:
        """Note how a calibration ended."""
        with self._transaction() as connection:
            connection.execute(
                _calibrations.update()
                .where(_calibrations.c.identity == identity)
                .values(status=status)
            )

    def add_request(self, calibration: str, request: RequestRecord) -> None:
        """Note that a calibration asked for a parameter set, in place of one at that position."""
        with self._transaction() as connection:
            connection.execute(
                _requests.delete().where(
                    _requests.c.calibration == calibration,
                    _requests.c.position == request.position,
                )
            )
            connection.execute(
                _requests.insert().values(calibration=calibration, **asdict(request))
            )

    def forget_requests_behind(self, calibration: str, position: int) -> None:
        """Forget what a calibration asked for behind a position, in an earlier start."""
        with self._transaction() as connection:
            connection.execute(
                _requests.delete().where(
                    _requests.c.calibration == calibration, _requests.c.position > position
                )
            )

    def latest_calibration(self) -> CalibrationRecord | None:
        """Return the calibration that was started last, or None."""
        query = sql.select(_calibrations).order_by(_calibrations.c.started.desc()).limit(1)
        return next(iter(self._read(query, lambda row: CalibrationRecord(**row))), None)

    def requests(self, calibration: str) -> list[RequestRecord]:
        """Return what a calibration asked for, in order."""
        query = (
            sql.select(_requests)
            .where(_requests.c.calibration == calibration)
            .order_by(_requests.c.position)
        )
        return self._read(query, RequestRecord.from_row)


def _place(url: sql.URL) -> str:
    place = str(url.database or url)
    return unquote(place.removeprefix("file://")) if place.startswith("file://") else place


def _path(folder: Path) -> Path:
    path = folder / STORE_NAME
    if path.is_dir():
        raise StoreError(f"the run store {path} is a folder, not a file. {_RENEW}")
    return path


def _remedy(cause: BaseException) -> str:
    code = getattr(cause, "sqlite_errorcode", None)
    # The low byte is the kind of the error, the rest its details.
    if code is not None and code & 0xFF in _DAMAGED:
        return _RENEW
    return "See that its folder can be written, the disk is not full, and nobody else uses it."


def _set_up_sqlite(connection: Any, _record: Any) -> None:
    cursor = connection.cursor()
    cursor.execute("PRAGMA busy_timeout = 30000")
    # Write-ahead logging with full synchronisation survives a kill and a power cut.
    cursor.execute("PRAGMA journal_mode = WAL")
    cursor.execute("PRAGMA synchronous = FULL")
    cursor.close()
