"""Store of runs: one row per run, with its status and responses.

Runs are stored by identity and belong to no calibration; a calibration only lists the runs that it
requested. Any later calibration that needs the same run therefore finds it.
"""

from __future__ import annotations

import logging
import sqlite3
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast, get_args

import sqlalchemy as sql
from sqlalchemy.exc import (
    ArgumentError,
    DBAPIError,
    IntegrityError,
    OperationalError,
    SQLAlchemyError,
)
from sqlalchemy.pool import StaticPool

from grainfit.campaign import messages
from grainfit.campaign.folder_lock import require_files
from grainfit.campaign.store import schema
from grainfit.campaign.store.address import StoreAddress, safe_address
from grainfit.campaign.store.causes import remedy, words_of
from grainfit.campaign.store.cells import choice, read_json, read_text, text
from grainfit.campaign.store.records import CalibrationRecord, RequestRecord, RunRecord, RunStatus
from grainfit.campaign.store.schema import OLDEST_READABLE, SCHEMA_VERSION
from grainfit.campaign.store.schema import calibrations as _calibrations
from grainfit.campaign.store.schema import requests as _requests
from grainfit.campaign.store.schema import runs as _runs
from grainfit.errors import Fault, StoreError, StoreUnreachableError
from grainfit.extras import how_to_install

if TYPE_CHECKING:
    from grainfit.campaign.store.postgresql import Connector

# Faults of a connection reach the caller. Python would print them, too, with a traceback: such as
# of a Ctrl-C that comes while one is given back.
logging.getLogger("sqlalchemy.pool").addHandler(logging.NullHandler())

STORE_NAME = "runs.sqlite"

_RENEW = (
    f"Move {STORE_NAME} away (and {STORE_NAME}-wal and {STORE_NAME}-shm next to it, if present): "
    "it is rebuilt from the run folders; only runs of Python functions and tables are lost."
)
#: Databases have limits on the number of values in one statement.
_CHUNK = 500
#: Key of the lock under which the tables of a shared database are created.
_SCHEMA_LOCK = 7_203_114
#: In place of the owner of a failed run that the next start repeats.
_REPEATED = "repeated"
#: Beginnings of the SQLSTATEs of a server that may serve the same request a little later: lost or
#: refused connections, transactions that were idle or in each other's way, and shutdowns.
_TRANSIENT = ("08", "25P03", "40", "53300", "55P03", "57")
#: Longest wait for another process that uses a SQLite file, and between two tries, s.
_BUSY_SECONDS, _RETRY_SECONDS = 30, 0.05
_RECORD_COLUMNS = [
    column
    for column in _runs.c
    if column.name not in ("model_hash", "natural_hash", "owner", "beat")
]
_CALIBRATION_COLUMNS = [column for column in _calibrations.c if column.name != "number"]
_Record = TypeVar("_Record")
#: Errors of a row that is not what was once stored.
UNUSABLE = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError)
#: Of a calibration: more would be no whole number of a database.
_LARGEST_NUMBER = 2**31 - 2
#: Characters of a row's key that a message shows.
_KEY_LENGTH = 40


@dataclass(frozen=True)
class Claim:
    """Process that executes a run, and its heartbeat counter."""

    owner: str
    beat: int


class _File:
    """A file, distinguished from any other file that may later have the same path."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._identity = self._look()

    def is_there(self) -> bool:
        # Data written to a removed file is lost without an error.
        return self._look() == self._identity

    def _look(self) -> tuple[int, int] | None:
        try:
            found = self._path.stat()
        except OSError:
            return None
        return found.st_dev, found.st_ino


class RunStore:
    """Index of runs in a database.

    Parameters
    ----------
    url : str or sqlalchemy.URL
        The address that a user gave, such as ``"postgresql+psycopg://user@host/database"``, or a
        URL that is used as it is.
    read_only : bool
        Write nothing, not even a schema.
    renew : str, optional
        What to do if it is damaged; by default, to use another database.

    Raises
    ------
    StoreError
        The address is not that of a database, the database cannot be opened, or it was written by a
        version that this one cannot read.
    """

    def __init__(
        self, url: str | sql.URL, *, read_only: bool = False, renew: str | None = None
    ) -> None:
        self._lock = threading.RLock()
        self._address = StoreAddress.read(url)
        self._where = self._address.shown
        self._renew = renew or messages.OWN_DATABASE()
        #: All that must not be removed while it is in use.
        self._files: Sequence[_File] = ()
        #: Of a work folder: open from the first query to the end.
        self._held: sql.Connection | None = None
        self._version = SCHEMA_VERSION
        options: dict[str, Any] = {"pool_pre_ping": True, "json_deserializer": read_json}
        url = self._address.url
        if self._address.file is None and url.drivername == "sqlite":
            options |= {"poolclass": StaticPool, "connect_args": {"check_same_thread": False}}
        elif self._address.file is not None and read_only:
            url = _only_to_read(self._address.file)
        self._engine = self._make_engine(url, options)
        self._connector: Connector | None = None
        if self._engine.dialect.driver == "psycopg":
            from grainfit.campaign.store.postgresql import Connector

            self._connector = Connector()
            sql.event.listen(self._engine, "do_connect", self._connector.connect)
        if self._engine.dialect.name == "sqlite":
            sql.event.listen(self._engine, "connect", _leave_transactions_to_us)
            sql.event.listen(self._engine, "begin", _begin_sqlite)
            if not read_only:
                sql.event.listen(self._engine, "connect", _set_up_sqlite)
        try:
            self._check_version() if read_only else self._create()
        except StoreError:
            self.close()
            raise
        # A driver raises these for options that it does not know.
        except (TypeError, ValueError) as error:
            self.close()
            raise self._unusable(self._said(error), messages.CHECK_OPTIONS()) from None

    def _make_engine(self, url: sql.URL, options: Mapping[str, Any]) -> sql.Engine:
        try:
            return sql.create_engine(url, **options)
        except ImportError as error:
            install = how_to_install("postgresql")
            raise StoreError(messages.NO_DRIVER(store=self._where, install=install)) from error
        except (ArgumentError, TypeError, ValueError) as error:
            raise self._unusable(self._said(error), messages.CHECK_ADDRESS()) from None

    def _said(self, cause: BaseException) -> str:
        """Return what a driver said, without what its address hides."""
        return self._address.without_secrets(words_of(cause))

    def _unusable(
        self, reason: str, remedy: str, kind: type[StoreError] = StoreError
    ) -> StoreError:
        return kind(messages.STORE_UNUSABLE(store=self._where, reason=reason, remedy=remedy))

    @classmethod
    def in_memory(cls) -> RunStore:
        """Open a store of this process alone, which is gone with it."""
        return cls(sql.URL.create("sqlite"))

    @classmethod
    def in_folder(cls, folder: Path) -> RunStore:
        """Open the store of a work folder; create it if there is none."""
        path = _path(folder)
        log = path.with_name(f"{STORE_NAME}-wal")
        # SQLite would take an empty file for a new store, and drop the log.
        if path.exists() and not path.stat().st_size and log.exists() and log.stat().st_size:
            text = messages.STORE_DAMAGED(store=path, reason="it is empty", remedy=_RENEW)
            raise StoreError(text)
        store = cls(sql.URL.create("sqlite", database=str(path)), renew=_RENEW)
        store._hold_log()
        store._files = (_File(path), _File(log))
        return store

    @classmethod
    def read_only(cls, folder: Path) -> RunStore:
        """Open the store of a work folder for reading; another process may write to it meanwhile.

        Raises
        ------
        StoreError
            Also when there is no store yet.
        """
        url = sql.URL.create("sqlite", database=str(_path(folder).absolute()))
        return cls(url, read_only=True, renew=_RENEW)

    @property
    def place(self) -> str:
        """Location of the store for display, without a password."""
        return self._where

    def _create(self) -> None:
        with self._transaction() as connection:
            if connection.dialect.name == "postgresql":
                connection.execute(sql.select(sql.func.pg_advisory_xact_lock(_SCHEMA_LOCK)))
            version = schema.bring_up_to_date(connection)
            if version == SCHEMA_VERSION:
                _remove_passwords(connection)
                schema.require_writing(connection)
        self._require_version(version, SCHEMA_VERSION)

    def _check_version(self) -> None:
        with self._reading() as connection:
            version = schema.version_of(connection)
        if version is None:
            raise StoreError(messages.STORE_EMPTY(store=self._where))
        self._require_version(version, OLDEST_READABLE)

    def _require_version(self, version: int, oldest: int) -> None:
        self._version = version
        if version > SCHEMA_VERSION:
            raise StoreError(
                messages.STORE_TOO_NEW(store=self._where, version=version, own=SCHEMA_VERSION)
            )
        if version < oldest:
            raise StoreError(messages.STORE_TOO_OLD(store=self._where, version=version))

    def _require_file(self) -> None:
        if not all(file.is_there() for file in self._files):
            raise StoreError(messages.STORE_REMOVED(store=self._where, name=STORE_NAME))

    @contextmanager
    def _transaction(self) -> Iterator[sql.Connection]:
        self._require_file()
        with (
            self._lock,
            self._connection(self._engine.execution_options(writes=True)) as connection,
        ):
            yield connection

    @contextmanager
    def _reading(self) -> Iterator[sql.Connection]:
        with self._lock, self._connection(self._engine) as connection:
            yield connection

    @contextmanager
    def _connection(self, engine: sql.Engine) -> Iterator[sql.Connection]:
        with self._named_errors(), engine.begin() as connection:
            yield connection

    @contextmanager
    def _named_errors(self) -> Iterator[None]:
        handled = sys.exception()
        try:
            yield
        except SQLAlchemyError as error:
            if interrupt := _interrupt_before(error, handled):
                raise interrupt from None
            self._require_file()
            cause = getattr(error, "orig", None) or error
            known = str(error) == self._address.without_secrets(str(error))
            # A traceback would show the cause as the driver words it.
            kind = StoreUnreachableError if _may_come_back(error) else StoreError
            said = self._said(cause)
            what_to_do = remedy(cause, said, self._address.file, self._renew)
            raise self._unusable(said, what_to_do, kind) from (error if known else None)

    def _read(
        self, query: sql.Select[Any], make: Callable[[Mapping[str, Any]], _Record]
    ) -> list[_Record]:
        with self._reading() as connection:
            rows = connection.execute(query).mappings()
            return [self._made(query, cast(Mapping[str, Any], row), make) for row in rows]

    def _made(
        self,
        query: sql.Select[Any],
        row: Mapping[str, Any],
        make: Callable[[Mapping[str, Any]], _Record],
    ) -> _Record:
        try:
            return make(row)
        except UNUSABLE as error:
            [table] = query.get_final_froms()
            keys = (str(row[key.name])[:_KEY_LENGTH] for key in table.primary_key)
            place = f"table {table.description}, row {' '.join(keys)}"
            raise self.damaged(f"{place}: {error}") from error

    def damaged(self, why: str) -> StoreError:
        """Return the error of a store with unusable contents."""
        text = messages.STORE_DAMAGED(store=self._where, reason=why, remedy=self._renew)
        return StoreError(text)

    def _hold_log(self) -> None:
        """Keep a connection that no query uses.

        One that is interrupted in a query is closed, and SQLite removes the log with the last.
        """
        with self._named_errors():
            self._held = self._engine.connect()
            self._held.execute(sql.text("SELECT 1 FROM sqlite_master"))
            self._held.rollback()

    def close(self) -> None:
        """Close all connections."""
        if self._held is not None:
            self._held.close()
        self._engine.dispose()

    def hurry(self) -> None:
        """Wait hardly any longer for a server that does not answer."""
        if self._connector is not None:
            self._connector.hurry()

    # Runs --------------------------------------------------------------------------------------

    def find(self, identity: str) -> RunRecord | None:
        """Return the run of this identity, or None."""
        return self.find_many([identity]).get(identity)

    def find_many(self, identities: Collection[str]) -> dict[str, RunRecord]:
        """Return the stored runs of these identities, by identity."""
        wanted = list(identities)
        found = []
        for start in range(0, len(wanted), _CHUNK):
            query = sql.select(*_RECORD_COLUMNS).where(
                _runs.c.identity.in_(wanted[start : start + _CHUNK])
            )
            found += self._read(query, RunRecord.from_json)
        return {record.identity: record for record in found}

    def save(self, record: RunRecord) -> None:
        """Write a run; replace its earlier record."""
        self.save_many([record])

    def save_many(self, records: Iterable[RunRecord]) -> None:
        """Write several runs at once, or none of them."""
        rows = [_row(record) for record in records]
        with self._transaction() as connection:
            for start in range(0, len(rows), _CHUNK):
                part = rows[start : start + _CHUNK]
                identities = [row["identity"] for row in part]
                connection.execute(_runs.delete().where(_runs.c.identity.in_(identities)))
                connection.execute(_runs.insert(), part)

    def add_missing(self, records: Iterable[RunRecord]) -> None:
        """Write the runs that the store does not have, not even as a claim, or none of them."""
        rows = {record.identity: _row(record) for record in records}
        with self._transaction() as connection:
            for start in range(0, len(rows), _CHUNK):
                self._add_missing(connection, dict(list(rows.items())[start : start + _CHUNK]))

    def _add_missing(self, connection: sql.Connection, rows: Mapping[str, Any]) -> None:
        known = sql.select(_runs.c.identity).where(_runs.c.identity.in_(list(rows)))
        while True:
            there = set(connection.scalars(known))
            missing = [row for identity, row in rows.items() if identity not in there]
            try:
                with connection.begin_nested():
                    if missing:
                        connection.execute(_runs.insert(), missing)
                    return
            except IntegrityError:
                # Another process has added one of them meanwhile.
                continue

    def forget_unsettled(self) -> None:
        """Delete the runs that a start makes again.

        They were pending when an earlier process died, or are those of `repeat_failed`.
        """
        unsettled = sql.or_(_runs.c.status == "running", _is_repeated())
        with self._transaction() as connection:
            connection.execute(_runs.delete().where(unsettled))

    def forget(self, identity: str) -> None:
        """Delete one run."""
        with self._transaction() as connection:
            connection.execute(_runs.delete().where(_runs.c.identity == identity))

    def forget_ended(self, identity: str) -> None:
        """Delete one run, unless a process is executing it."""
        with self._transaction() as connection:
            here = sql.and_(_runs.c.identity == identity, _runs.c.status != "running")
            connection.execute(_runs.delete().where(here))

    def forget_failed(self, identities: Collection[str]) -> None:
        """Delete the failed ones of these runs, so that they are repeated."""
        self._change_failed(_runs.delete(), identities)

    def repeat_failed(self, identities: Collection[str]) -> None:
        """Let the next start forget the failed ones of these runs: until then, users see them."""
        self._change_failed(_runs.update().values(owner=_REPEATED), identities)

    def _change_failed(self, change: sql.Delete | sql.Update, identities: Collection[str]) -> None:
        wanted = list(identities)
        with self._transaction() as connection:
            for start in range(0, len(wanted), _CHUNK):
                part = _runs.c.identity.in_(wanted[start : start + _CHUNK])
                connection.execute(change.where(part, _runs.c.status == "failed"))

    def identities(self) -> set[str]:
        """Return the identities of all runs."""
        return set(self.states())

    def states(self) -> dict[str, RunStatus]:
        """Return the status of every run by identity."""
        return dict(self._read(sql.select(_runs.c.identity, _runs.c.status), _state))

    def runs(self, status: RunStatus | None = None) -> list[RunRecord]:
        """Return all runs, or those of one status, in the order of their end."""
        return self._runs(status)

    def incomplete_runs(self) -> list[RunRecord]:
        """Return the finished runs that are without some responses for a known reason."""
        return self._runs("finished", _runs.c.reason != "")

    def _runs(
        self, status: RunStatus | None, *conditions: sql.ColumnElement[bool]
    ) -> list[RunRecord]:
        if status is not None:
            conditions = (*conditions, _runs.c.status == status)
        query = sql.select(*_RECORD_COLUMNS).where(*conditions)
        ordered = query.order_by(_runs.c.ended, _runs.c.identity)
        return self._read(ordered, RunRecord.from_json)

    def runs_of(
        self, model_hashes: Collection[str], status: RunStatus | None = None
    ) -> list[RunRecord]:
        """Return the runs of these models, optionally of one status, in the order of `runs`."""
        if self._version < SCHEMA_VERSION:
            known = self.runs(status)
            return [record for record in known if record.definition.model_hash in model_hashes]
        return self._runs(status, _runs.c.model_hash.in_(list(model_hashes)))

    def runs_at_any_scale(self, natural_hashes: Collection[str]) -> list[RunRecord]:
        """Return the finished runs of bulk tests that are the same in natural units."""
        if self._version < SCHEMA_VERSION:
            from grainfit.bulk_tests.natural_units import natural_hash

            known = self.runs("finished")
            return [r for r in known if natural_hash(r.definition) in natural_hashes]
        return self._runs("finished", _runs.c.natural_hash.in_(list(natural_hashes)))

    def models_at_any_scale(self) -> list[RunRecord]:
        """Return one finished run of every bulk test in natural units; none of an older store."""
        if self._version < SCHEMA_VERSION:
            return []
        first = (
            sql.select(sql.func.min(_runs.c.identity))
            .where(_runs.c.status == "finished", _runs.c.natural_hash != "")
            .group_by(_runs.c.natural_hash)
        )
        return self._runs("finished", _runs.c.identity.in_(first))

    # Claims, where several processes share a store ---------------------------------------------

    def claim(self, record: RunRecord, owner: str, instead_of: Claim | None = None) -> bool:
        """Claim a run, unless another process executes it or it has finished.

        A claim may be repeated, when it is not known whether it was received.

        Parameters
        ----------
        record : RunRecord
            The run, with status ``running``.
        owner : str
            Process that executes it.
        instead_of : Claim, optional
            Claim of an owner that has died, to take over.

        Returns
        -------
        bool
            True if the owner is to execute the run. Exactly one of several concurrent callers gets
            True.
        """
        other: sql.ColumnElement[bool]
        if instead_of is None:
            other = _runs.c.status == "failed"
        else:
            other = _claimed_by(instead_of.owner) & (_runs.c.beat == instead_of.beat)
        return self._put(_row(record) | {"owner": owner}, _claimed_by(owner) | other)

    def save_outcome(self, record: RunRecord, owner: str) -> bool:
        """Write the end of a run that this owner claimed, unless the run has gone on without it.

        An owner that was suspended, or cut off, may have lost its claim meanwhile. A finished run
        replaces any claim, and is never replaced; a failed one replaces no claim of another owner.

        Returns
        -------
        bool
            False if it was not written: the run has finished, or is executed, elsewhere.
        """
        if record.status == "finished":
            return self._put(_row(record), _runs.c.status != "finished")
        return self._put(_row(record), _claimed_by(owner) | (_runs.c.status == "failed"))

    def _put(self, row: Mapping[str, Any], replaceable: sql.ColumnElement[bool]) -> bool:
        """Write a row in place of none or of a replaceable one; return whether it was written."""
        here = _runs.c.identity == row["identity"]
        with self._transaction() as connection:
            if connection.execute(_runs.update().where(here, replaceable).values(**row)).rowcount:
                return True
            try:
                with connection.begin_nested():
                    connection.execute(_runs.insert().values(**row))
            except IntegrityError:
                return False
            return True

    def claims(self, identities: Collection[str]) -> dict[str, Claim]:
        """Return the claims of the pending ones of these runs, by identity."""
        query = sql.select(_runs.c.identity, _runs.c.owner, _runs.c.beat).where(
            _runs.c.status == "running", _runs.c.identity.in_(list(identities))
        )
        with self._reading() as connection:
            return {row.identity: Claim(row.owner, row.beat) for row in connection.execute(query)}

    def beat(self, owner: str) -> None:
        """Send the heartbeat of an owner of claims."""
        counted = _runs.update().where(_claimed_by(owner)).values(beat=_runs.c.beat + 1)
        with self._transaction() as connection:
            connection.execute(counted)

    def release(self, owner: str) -> None:
        """Release all claims of an owner, so that others may execute its unfinished runs."""
        with self._transaction() as connection:
            connection.execute(_runs.delete().where(_claimed_by(owner)))

    # Calibrations ------------------------------------------------------------------------------

    def begin_calibration(
        self,
        identity: str,
        name: str,
        definition: Mapping[str, Any],
        known: Sequence[str] = (),
        about: Mapping[str, Any] | None = None,
    ) -> None:
        """Record the start of a calibration, or its continuation.

        Parameters
        ----------
        identity, name : str
            Identity and display name.
        definition : mapping
            Everything that determines the runs it requests.
        known : sequence of str
            Identities of the earlier runs of its warm start.
        about : mapping, optional
            Further information for reports, as JSON.
        """
        with self._transaction() as connection:
            number = self._next_number(connection)
            connection.execute(_calibrations.delete().where(_calibrations.c.identity == identity))
            connection.execute(
                _calibrations.insert().values(
                    identity=identity,
                    name=name,
                    definition=dict(definition),
                    status="running",
                    started=time.time(),
                    known=list(known),
                    number=number,
                    about=dict(about or {}),
                )
            )

    def _next_number(self, connection: sql.Connection) -> int:
        latest = connection.scalar(sql.select(sql.func.max(_calibrations.c.number)))
        if latest is None:
            return 1
        if not isinstance(latest, int) or latest > _LARGEST_NUMBER:
            raise self.damaged(f"table {_calibrations.name}: its largest number is {latest!r:.40}")
        return latest + 1

    def end_calibration(self, identity: str, status: str, failure: str = "") -> None:
        """Record the status with which a calibration ended, and the failure, if any."""
        this = _calibrations.c.identity == identity
        with self._transaction() as connection:
            about = connection.scalar(sql.select(_calibrations.c.about).where(this)) or {}
            if failure:
                about = {**about, "failure": failure}
            connection.execute(
                _calibrations.update().where(this).values(status=status, about=about)
            )

    def calibration(self, identity: str) -> CalibrationRecord | None:
        """Return a calibration, or None."""
        query = sql.select(*_CALIBRATION_COLUMNS).where(_calibrations.c.identity == identity)
        return next(iter(self._read(query, CalibrationRecord.from_row)), None)

    def latest_calibration(self) -> CalibrationRecord | None:
        """Return the calibration that was started last, or None."""
        query = sql.select(*_CALIBRATION_COLUMNS).order_by(_calibrations.c.number.desc()).limit(1)
        return next(iter(self._read(query, CalibrationRecord.from_row)), None)

    def add_request(self, calibration: str, request: RequestRecord) -> None:
        """Record a parameter set that a calibration requested, in place of one at its position."""
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
        """Delete the requests of an earlier start of a calibration after a position."""
        with self._transaction() as connection:
            connection.execute(
                _requests.delete().where(
                    _requests.c.calibration == calibration, _requests.c.position > position
                )
            )

    def requests(self, calibration: str) -> list[RequestRecord]:
        """Return the requests of a calibration, in order."""
        query = (
            sql.select(_requests)
            .where(_requests.c.calibration == calibration)
            .order_by(_requests.c.position)
        )
        return self._read(query, RequestRecord.from_row)


def _state(row: Mapping[str, Any]) -> tuple[str, RunStatus]:
    status = choice(row["status"], "status", get_args(RunStatus))
    return text(row["identity"], "identity"), status


def _remove_passwords(connection: sql.Connection) -> None:
    """Replace the addresses that earlier versions stored with their options."""
    stored = sql.select(_runs.c.origin).where(_runs.c.origin.contains("://")).distinct()
    unsafe = [origin for origin in connection.scalars(stored) if safe_address(origin) != origin]
    if unsafe and connection.dialect.name == "sqlite":
        # SQLite would leave the old text in the free parts of the file.
        connection.exec_driver_sql("PRAGMA secure_delete = ON")
    for origin in unsafe:
        replaced = _runs.update().where(_runs.c.origin == origin)
        connection.execute(replaced.values(origin=safe_address(origin)))


def not_a_work_folder(folder: Path) -> Fault:
    """Return the fault of what has no store, where the address of one is none either."""
    shown = safe_address(folder)
    if shown != str(folder):
        return messages.FOLDERS_ONLY.fault("")
    return messages.NO_WORK_FOLDER.fault("", folder=shown, store=STORE_NAME)


def _path(folder: Path) -> Path:
    path = folder / STORE_NAME
    require_files(folder)
    if path.is_dir():
        raise StoreError(messages.STORE_IS_FOLDER(store=path, remedy=_RENEW))
    return path


def _only_to_read(file: Path) -> sql.URL:
    """Return the URL under which SQLite writes nothing to a file, not even an empty one.

    Raises
    ------
    StoreError
        There is no such file.
    """
    if not file.is_file():
        raise StoreError(messages.NO_STORE_FILE(store=str(file)))
    query = {"uri": "true", "mode": "ro"}
    # Without a write-ahead log no process writes, and opening the store would create one.
    if not file.with_name(f"{file.name}-wal").exists():
        query["immutable"] = "1"
    return sql.URL.create("sqlite", database=file.absolute().as_uri(), query=query)


def _row(record: RunRecord) -> dict[str, Any]:
    # Bulk tests need libraries that reading a store does not wait for.
    from grainfit.bulk_tests.natural_units import natural_hash

    row = record.to_json() | {
        "model_hash": record.definition.model_hash,
        "natural_hash": natural_hash(record.definition),
        "owner": "",
        "beat": 0,
    }
    # A solver may print anything; not every database accepts a zero byte in text.
    for name in ("reason", "log_tail"):
        row[name] = row[name].replace("\0", " ").encode(errors="replace").decode()
    return row


def _is_repeated() -> sql.ColumnElement[bool]:
    return sql.and_(_runs.c.status == "failed", _runs.c.owner == _REPEATED)


def _claimed_by(owner: str) -> sql.ColumnElement[bool]:
    return sql.and_(_runs.c.status == "running", _runs.c.owner == owner)


def _interrupt_before(
    error: BaseException | None, handled: BaseException | None
) -> KeyboardInterrupt | None:
    """Return the interrupt for whose sake a transaction was to be rolled back, which failed.

    One that was being handled before the transaction began is none.
    """
    while error is not None and error is not handled:
        if isinstance(error, KeyboardInterrupt):
            return error
        error = error.__cause__ or error.__context__
    return None


def _may_come_back(error: SQLAlchemyError) -> bool:
    """Return whether a server failed in a way that may pass, and not for what it was asked."""
    if not isinstance(error, DBAPIError):
        return False
    state = getattr(error.orig, "sqlstate", "")
    # PostgreSQL's driver has no SQLSTATE for a connection that could not be made.
    refused = state is None and isinstance(error, OperationalError)
    return error.connection_invalidated or refused or str(state).startswith(_TRANSIENT)


def _leave_transactions_to_us(connection: Any, _record: Any) -> None:
    # Python's own SQLite module would begin transactions late, and not at all before some
    # statements.
    connection.isolation_level = None
    connection.text_factory = read_text


def _begin_sqlite(connection: sql.Connection) -> None:
    # A writer must wait for other writers at the beginning: SQLite cannot wait later.
    writes = connection.get_execution_options().get("writes")
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _set_up_sqlite(connection: Any, _record: Any) -> None:
    cursor = connection.cursor()
    cursor.execute(f"PRAGMA busy_timeout = {1000 * _BUSY_SECONDS}")
    # Write-ahead logging with full synchronisation survives a kill and a power cut.
    _write_ahead(cursor)
    cursor.execute("PRAGMA synchronous = FULL")
    cursor.close()


def _write_ahead(cursor: sqlite3.Cursor) -> None:
    # SQLite does not always wait here for another process that opens the same new file.
    deadline = time.monotonic() + _BUSY_SECONDS
    while True:
        try:
            cursor.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > deadline:
                raise
            time.sleep(_RETRY_SECONDS)
        else:
            return
