"""The store of runs: one row for every run ever made, the truth about its status and responses.

Runs are kept by identity and belong to no calibration; a calibration only lists which runs it asked
for. So any later calibration that wants the same run finds it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import sqlalchemy as sql
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.pool import StaticPool

from grainfit.errors import StoreError
from grainfit.solvers.base import Response

SCHEMA_VERSION = 1
RunStatus = Literal["running", "finished", "failed"]

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
        KeyError, TypeError
            The data is not of a run.
        """
        responses = {name: Response(**response) for name, response in data["responses"].items()}
        return cls(**{**data, "responses": responses})


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
    stage: str
    parameters: Mapping[str, float]
    seed: int
    runs: Mapping[str, str]


class RunStore:
    """Index of runs in a database.

    Parameters
    ----------
    url : str
        SQLAlchemy URL; ``"sqlite://"`` keeps everything in memory.

    Raises
    ------
    StoreError
        The database cannot be opened, or was written by a newer version.
    """

    def __init__(self, url: str) -> None:
        self._lock = threading.RLock()
        self._where = url
        options: dict[str, Any] = {}
        if url == "sqlite://":
            options = {"poolclass": StaticPool, "connect_args": {"check_same_thread": False}}
        self._engine = sql.create_engine(url, **options)
        if self._engine.dialect.name == "sqlite":
            sql.event.listen(self._engine, "connect", _set_up_sqlite)
        self._create()

    @classmethod
    def in_folder(cls, folder: Path) -> RunStore:
        """Open the store of a work folder."""
        return cls(f"sqlite:///{folder / 'runs.sqlite'}")

    def _create(self) -> None:
        with self._transaction() as connection:
            _metadata.create_all(connection)
            version = connection.scalar(sql.select(_about.c.schema_version))
            if version is None:
                connection.execute(_about.insert().values(schema_version=SCHEMA_VERSION))
            elif version != SCHEMA_VERSION:
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
                raise StoreError(f"the run store {self._where} cannot be used: {cause}") from error

    def close(self) -> None:
        """Close all connections."""
        self._engine.dispose()

    def find(self, identity: str) -> RunRecord | None:
        """Return the run of this identity, or None."""
        with self._transaction() as connection:
            row = connection.execute(sql.select(_runs).where(_runs.c.identity == identity)).first()
        return None if row is None else RunRecord.from_json(row._asdict())

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
        with self._transaction() as connection:
            rows = connection.execute(sql.select(_runs).order_by(_runs.c.ended)).all()
        return [RunRecord.from_json(row._asdict()) for row in rows]

    def begin_calibration(self, identity: str, name: str, definition: Mapping[str, Any]) -> None:
        """Note that a calibration starts, or goes on."""
        with self._transaction() as connection:
            connection.execute(_calibrations.delete().where(_calibrations.c.identity == identity))
            connection.execute(_requests.delete().where(_requests.c.calibration == identity))
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
        """Note that a calibration asked for a parameter set."""
        with self._transaction() as connection:
            connection.execute(
                _requests.insert().values(calibration=calibration, **asdict(request))
            )

    def latest_calibration(self) -> CalibrationRecord | None:
        """Return the calibration that was started last, or None."""
        query = sql.select(_calibrations).order_by(_calibrations.c.started.desc()).limit(1)
        with self._transaction() as connection:
            row = connection.execute(query).first()
        return None if row is None else CalibrationRecord(**row._asdict())

    def requests(self, calibration: str) -> list[RequestRecord]:
        """Return what a calibration asked for, in order."""
        query = (
            sql.select(_requests)
            .where(_requests.c.calibration == calibration)
            .order_by(_requests.c.position)
        )
        with self._transaction() as connection:
            rows = [row._asdict() for row in connection.execute(query)]
        return [
            RequestRecord(**{k: v for k, v in row.items() if k != "calibration"}) for row in rows
        ]


def _set_up_sqlite(connection: Any, _record: Any) -> None:
    cursor = connection.cursor()
    cursor.execute("PRAGMA busy_timeout = 30000")
    # Write-ahead logging with full synchronisation survives a kill and a power cut.
    cursor.execute("PRAGMA journal_mode = WAL")
    cursor.execute("PRAGMA synchronous = FULL")
    cursor.close()
