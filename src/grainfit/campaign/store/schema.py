"""Tables of the store, their version, and the migration of older versions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import sqlalchemy as sql

from grainfit.run_definition import RunDefinition

SCHEMA_VERSION = 5
#: Oldest version that can be read without migration.
OLDEST_READABLE = 3

metadata = sql.MetaData()
about = sql.Table("about", metadata, sql.Column("schema_version", sql.Integer, primary_key=True))
runs = sql.Table(
    "runs",
    metadata,
    sql.Column("identity", sql.String(32), primary_key=True),
    sql.Column("test", sql.Text, nullable=False),
    sql.Column("status", sql.String(16), nullable=False, index=True),
    sql.Column("definition", sql.JSON, nullable=False),
    # Key of the query for runs that can be reused for a problem.
    sql.Column("model_hash", sql.String(32), nullable=False, server_default="", index=True),
    # The same without the scale, for runs of bulk tests: see grainfit.bulk_tests.natural_units.
    sql.Column("natural_hash", sql.String(32), nullable=False, server_default="", index=True),
    sql.Column("responses", sql.JSON, nullable=False),
    sql.Column("reason", sql.Text, nullable=False),
    sql.Column("kind", sql.String(16), nullable=False),
    sql.Column("log_tail", sql.Text, nullable=False),
    sql.Column("seconds", sql.Float, nullable=False),
    sql.Column("ended", sql.Float, nullable=False),
    sql.Column("origin", sql.Text, nullable=False, server_default=""),
    # Process that executes the run, and its heartbeat counter: in shared stores only.
    sql.Column("owner", sql.Text, nullable=False, server_default=""),
    sql.Column("beat", sql.Integer, nullable=False, server_default="0"),
)
calibrations = sql.Table(
    "calibrations",
    metadata,
    sql.Column("identity", sql.String(32), primary_key=True),
    sql.Column("name", sql.Text, nullable=False),
    sql.Column("definition", sql.JSON, nullable=False),
    sql.Column("status", sql.String(16), nullable=False),
    sql.Column("started", sql.Float, nullable=False),
    sql.Column("known", sql.JSON, nullable=False, server_default="[]"),
    # The latest one has the largest number; start times are unreliable, because clocks can jump.
    sql.Column("number", sql.Integer, nullable=False, server_default="0"),
    sql.Column("about", sql.JSON, nullable=False, server_default="{}"),
)
requests = sql.Table(
    "requests",
    metadata,
    sql.Column("calibration", sql.String(32), primary_key=True),
    sql.Column("position", sql.Integer, primary_key=True),
    sql.Column("stage", sql.String(16), nullable=False),
    sql.Column("parameters", sql.JSON, nullable=False),
    sql.Column("seed", sql.BigInteger, nullable=False),
    sql.Column("runs", sql.JSON, nullable=False),
)

#: Statements that migrate each older version to the next one.
_MIGRATIONS: Mapping[int, tuple[str, ...]] = {
    1: (
        "ALTER TABLE runs ADD COLUMN origin TEXT NOT NULL DEFAULT ''",
        "ALTER TABLE runs ADD COLUMN owner TEXT NOT NULL DEFAULT ''",
        "ALTER TABLE runs ADD COLUMN beat INTEGER NOT NULL DEFAULT 0",
        "ALTER TABLE calibrations ADD COLUMN known JSON NOT NULL DEFAULT '[]'",
        "ALTER TABLE calibrations ADD COLUMN number INTEGER NOT NULL DEFAULT 0",
        "UPDATE calibrations SET number = "
        "(SELECT count(*) FROM calibrations AS earlier "
        "WHERE earlier.started <= calibrations.started)",
    ),
    2: ("ALTER TABLE calibrations ADD COLUMN about JSON NOT NULL DEFAULT '{}'",),
    3: (
        "ALTER TABLE runs ADD COLUMN model_hash VARCHAR(32) NOT NULL DEFAULT ''",
        "CREATE INDEX ix_runs_model_hash ON runs (model_hash)",
    ),
    4: (
        "ALTER TABLE runs ADD COLUMN natural_hash VARCHAR(32) NOT NULL DEFAULT ''",
        "CREATE INDEX ix_runs_natural_hash ON runs (natural_hash)",
    ),
}
#: Rows that are read and written at a time.
_CHUNK = 500


def version_of(connection: sql.Connection) -> int | None:
    """Return the schema version of a database; None if it has no such table.

    Tables of these names that are of another program are an error of the database.
    """
    if not any(map(sql.inspect(connection).has_table, metadata.tables)):
        return None
    version = connection.scalar(sql.select(about.c.schema_version))
    return None if version is None else int(version)


def bring_up_to_date(connection: sql.Connection) -> int:
    """Create the tables, or migrate those of an older version; return their version.

    An unknown version is not changed.
    """
    version = version_of(connection)
    if version is None:
        metadata.create_all(connection)
        connection.execute(about.insert().values(schema_version=SCHEMA_VERSION))
        return SCHEMA_VERSION
    while version in _MIGRATIONS:
        for statement in _MIGRATIONS[version]:
            connection.execute(sql.text(statement))
        if version in _HASHES:
            _fill_in(connection, *_HASHES[version])
        version += 1
        connection.execute(about.update().values(schema_version=version))
    return version


def require_writing(connection: sql.Connection) -> None:
    """Have the database refuse a user who may not write, without writing anything."""
    nothing = sql.select(runs).where(sql.false())
    connection.execute(runs.insert().from_select(list(runs.c.keys()), nothing))
    connection.execute(runs.update().where(sql.false()).values(beat=0))
    connection.execute(runs.delete().where(sql.false()))


def _fill_in(
    connection: sql.Connection, column: str, hash_of: Callable[[RunDefinition], str]
) -> None:
    """Fill in a hash of every run, which older versions did not keep."""
    rows = connection.execute(sql.select(runs.c.identity, runs.c.definition)).all()
    hashes = [{"of": row.identity, "found": _hash(row.definition, hash_of)} for row in rows]
    here = runs.c.identity == sql.bindparam("of")
    for start in range(0, len(hashes), _CHUNK):
        connection.execute(
            runs.update().where(here).values({column: sql.bindparam("found")}),
            hashes[start : start + _CHUNK],
        )


def _hash(definition: Any, hash_of: Callable[[RunDefinition], str]) -> str:
    try:
        return hash_of(RunDefinition.from_json(definition))
    except (AttributeError, TypeError, ValueError):
        # A damaged row is reported when it is read; it must not stop the migration.
        return ""


def _natural_hash(definition: RunDefinition) -> str:
    # Bulk tests need libraries that opening a store does not wait for.
    from grainfit.bulk_tests.natural_units import natural_hash

    return natural_hash(definition)


#: Hashes that a version of the store lacks: the column, and how to compute it.
_HASHES: Mapping[int, tuple[str, Callable[[RunDefinition], str]]] = {
    3: ("model_hash", lambda definition: definition.model_hash),
    4: ("natural_hash", _natural_hash),
}
