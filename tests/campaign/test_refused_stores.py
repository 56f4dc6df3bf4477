"""Stores that cannot be used: each says at its opening what is wrong, and what helps."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import sqlalchemy as sql

from grainfit.campaign import messages
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import RunStore
from grainfit.errors import StoreError
from grainfit.messages import Message
from grainfit.run_definition import RunDefinition
from tests.servers.postgresql_server import PostgresqlServer


@pytest.mark.parametrize(
    ("address", "remedy"),
    [
        ("postgres://me@host/runs", messages.OTHER_BEGINNING),
        ("postgresql+psycopg2://me@host/runs", messages.OTHER_BEGINNING),
        ("postgresql+psycopg_async://me@host/runs", messages.OTHER_BEGINNING),
        ("postgresql+unheard://me@host/runs", messages.OTHER_BEGINNING),
        ("sqlite+aiosqlite:////tmp/shared.sqlite", messages.OTHER_BEGINNING),
        ("mysql://me@host/runs", messages.OTHER_SYSTEM),
        ("unheard://me@host/runs", messages.OTHER_SYSTEM),
        ("postgresql://me@host:port/runs", messages.PARTS_OF_ADDRESS),
        ("sqlite://", messages.NO_SQLITE_PATH),
        ("sqlite:///", messages.NO_SQLITE_PATH),
        ("sqlite:///:memory:", messages.NO_SQLITE_PATH),
        ("sqlite://shared.sqlite", messages.NO_SQLITE_PATH),
        ("sqlite:////tmp/what?is.sqlite", messages.NO_SQLITE_OPTIONS),
        ("shared", messages.GIVE_AN_ADDRESS),
    ],
)
@pytest.mark.parametrize("read_only", [False, True])
def test_an_address_of_no_shared_store_is_refused(
    address: str, remedy: Message, read_only: bool
) -> None:
    with pytest.raises(StoreError, match=messages.NO_ADDRESS.pattern) as caught:
        RunStore(address, read_only=read_only)
    assert remedy.is_in(str(caught.value))


def test_a_store_that_is_read_is_not_made(tmp_path: Path) -> None:
    file = tmp_path / "mistyped.sqlite"
    with pytest.raises(StoreError, match=messages.NO_STORE_FILE.pattern):
        RunStore(f"sqlite:///{file}", read_only=True)
    assert not file.exists()


def test_no_one_is_told_to_move_a_work_folder_away_for_another_file(tmp_path: Path) -> None:
    file = tmp_path / "letter.txt"
    file.write_text("Dear Sir or Madam, " * 99)
    with pytest.raises(StoreError, match="not a database") as caught:
        RunStore(f"sqlite:///{file}")
    assert messages.OWN_DATABASE.is_in(str(caught.value))


def test_the_folder_of_a_shared_file_that_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(StoreError) as caught:
        RunStore(f"sqlite:///{tmp_path}/none/shared.sqlite")
    assert messages.FOLDER_MISSING.is_in(str(caught.value), folder=str(tmp_path / "none"))


def test_a_database_with_a_table_of_another_program_is_refused(tmp_path: Path) -> None:
    address = f"sqlite:///{tmp_path / 'theirs.sqlite'}"
    with sql.create_engine(address).begin() as connection:
        connection.exec_driver_sql("CREATE TABLE requests (url TEXT)")
    for read_only in (False, True):
        with pytest.raises(StoreError) as caught:
            RunStore(address, read_only=read_only)
        assert messages.OWN_DATABASE.is_in(str(caught.value))


# On a server -------------------------------------------------------------------------------------


@contextmanager
def database(server: PostgresqlServer, *statements: str, options: str = "") -> Iterator[str]:
    """Make a database for one test; yield its address."""
    whole = sql.create_engine(server.url, isolation_level="AUTOCOMMIT")
    address = f"{server.url.rpartition('/')[0]}/another"
    own = sql.create_engine(address, connect_args={"client_encoding": "utf8"})
    with whole.connect() as connection:
        connection.exec_driver_sql(f"CREATE DATABASE another {options}")
        try:
            with own.begin() as inside:
                for statement in statements:
                    inside.exec_driver_sql(statement)
            own.dispose()
            yield address
        finally:
            connection.exec_driver_sql("DROP DATABASE another WITH (FORCE)")
            connection.exec_driver_sql("DROP ROLE IF EXISTS reader")
    whole.dispose()


def refusal(address: str) -> str:
    with pytest.raises(StoreError, match=messages.STORE_UNUSABLE.pattern) as caught:
        RunStore(address)
    text = str(caught.value)
    assert "\n" not in text
    assert "LINE 1" not in text
    assert not messages.CHECK_SERVER.is_in(text)
    return text


def test_a_database_that_is_missing_is_to_be_made(server: PostgresqlServer) -> None:
    text = refusal(f"{server.url}_none")
    assert messages.CREATE_DATABASE.is_in(text, name="postgres_none")


def test_an_option_that_the_driver_does_not_know_is_to_be_mended(server: PostgresqlServer) -> None:
    assert messages.CHECK_OPTIONS.is_in(refusal(f"{server.url}?colour=red"))


@pytest.mark.parametrize("table", ["about (text TEXT)", "runs (number INTEGER)"])
def test_a_database_of_another_application_is_refused(table: str, server: PostgresqlServer) -> None:
    with database(server, f"CREATE TABLE {table}") as address:
        assert messages.OWN_DATABASE.is_in(refusal(address))


def test_who_may_not_write_is_told_at_the_opening(server: PostgresqlServer) -> None:
    role = f"CREATE ROLE reader LOGIN PASSWORD '{server.password}'"
    with database(server, role) as address:
        other = address.replace(f"{server.user}@", f"reader:{server.password}@")
        assert messages.GRANT.is_in(refusal(other)), "no right to make tables"
        RunStore(address).close()
        with sql.create_engine(address).begin() as connection:
            connection.exec_driver_sql("GRANT SELECT ON ALL TABLES IN SCHEMA public TO reader")
        assert messages.GRANT.is_in(refusal(other)), "no right to write"
        RunStore(other, read_only=True).close()


def test_a_server_that_only_reads_is_told_at_the_opening(server: PostgresqlServer) -> None:
    RunStore(server.url).close()
    reading = f"{server.url}?options=-c%20default_transaction_read_only%3Don"
    assert messages.WRITES_NOTHING.is_in(refusal(reading))


def test_a_database_without_an_encoding_works(server: PostgresqlServer) -> None:
    options = "ENCODING 'SQL_ASCII' TEMPLATE template0 LC_COLLATE 'C' LC_CTYPE 'C'"
    with database(server, options=options) as address:
        store = RunStore(address)
        run = RunRecord("a" * 32, "Schüttwinkel", "failed", RunDefinition({}, {}, 1), reason="µ")
        store.save(run)
        assert store.find("a" * 32) == run
        store.close()


def test_a_character_that_a_database_lacks_is_named(server: PostgresqlServer) -> None:
    options = "ENCODING 'LATIN1' TEMPLATE template0 LC_COLLATE 'C' LC_CTYPE 'C'"
    with database(server, options=options) as address:
        store = RunStore(address)
        run = RunRecord("a" * 32, "drum", "failed", RunDefinition({}, {}, 1), reason="φ → 0")
        with pytest.raises(StoreError) as caught:
            store.save(run)
        assert messages.UTF8_DATABASE.is_in(str(caught.value))
        store.close()
