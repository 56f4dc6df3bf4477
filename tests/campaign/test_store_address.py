"""Addresses of stores are shown without passwords, in any form of the address."""

from __future__ import annotations

import json
import sqlite3
import traceback
from pathlib import Path
from urllib.parse import quote

import pytest
from typer.testing import CliRunner

from grainfit.campaign import messages
from grainfit.campaign.store.address import StoreAddress, safe_address
from grainfit.campaign.store.records import RunRecord
from grainfit.campaign.store.store import STORE_NAME, RunStore
from grainfit.cli.app import app
from grainfit.errors import StoreError
from grainfit.run_definition import RunDefinition

SECRET = "s3cret"
#: Addresses that no server answers.
ADDRESSES = (
    f"postgres://user:{SECRET}@host/runs",
    f"postgresql://user:{SECRET}@host:port/runs",
    f"postgresql://host:{SECRET}/runs",
    f"postgresql+psycopg://user:{SECRET}@[::1/runs",
    f"postgresql+psycopg://user:{SECRET}@[::1]:1/runs",
    f"postgresql+psycopg://user@127.0.0.1:1/runs?password={SECRET}",
    f"postgresql+psycopg://user@127.0.0.1:1/runs?PASSWORD={SECRET}",
    f"postgresql+psycopg://127.0.0.1:1/runs?sslpassword={SECRET}&sslmode=disable",
    f"postgresql+psycopg://user@127.0.0.1:1/runs?connect_timeout={SECRET}",
    f"postgresql+psycopg://user%3A{SECRET}@127.0.0.1:1/runs",
    f"postgresql+psycopg://user:p%40{SECRET}@127.0.0.1:1/runs",
    f"postgresql+psycopg://user:p@{SECRET}@127.0.0.1:1/runs",
    f"postgresql+psycopg://user:p@{SECRET}/x@127.0.0.1:1/runs",
    f"postgresql+psycopg://user:p/{SECRET}@127.0.0.1:1/runs",
    f"postgresql+psycopg://user:p?{SECRET}&x@127.0.0.1:1/runs",
    f"postgresql+psycopg://127.0.0.1:1/{quote(f'host=x password={SECRET}', safe='')}",
    f"postgresql+psycopg://user:p@{SECRET}?x@127.0.0.1:1/runs",
    f"postgresql+psycopg://user:@{SECRET}?@127.0.0.1:port/runs",
    f"sqlite://:@/{SECRET}/@/runs",
    f"mysql://user:{SECRET}@host/runs",
    f"nonsense://user:{SECRET}@host/runs",
    f"sqlite://user:{SECRET}@host/runs",
    f"://user:{SECRET}@host/runs",
    f"user:{SECRET}@host/runs",
    f"postgresql:/user:{SECRET}@host/runs",
)


@pytest.mark.parametrize("address", ADDRESSES)
def test_a_store_address_in_an_error_has_no_password(address: str) -> None:
    with pytest.raises(StoreError) as caught:
        RunStore(address)

    # A notebook shows the whole traceback, with its causes.
    shown = "".join(traceback.format_exception_only(caught.value))
    cause = caught.value.__cause__
    shown += "".join(traceback.format_exception_only(cause)) if cause else ""
    assert SECRET not in shown


@pytest.mark.parametrize("address", [ADDRESSES[0], ADDRESSES[5], *ADDRESSES[-2:]])
def test_no_command_prints_the_password_of_a_store(address: str) -> None:
    done = CliRunner().invoke(app, ["runs", "list", address])
    assert done.exit_code
    assert SECRET not in done.output
    done = CliRunner().invoke(app, ["status", address])
    assert done.exit_code
    assert SECRET not in done.output


@pytest.mark.parametrize("address", ADDRESSES)
def test_a_safe_address_stays_as_it_is(address: str) -> None:
    shown = safe_address(address)

    assert SECRET not in shown
    assert safe_address(shown) == shown


@pytest.mark.parametrize(
    ("address", "shown"),
    [
        (f"postgresql+psycopg://me:{SECRET}@db.org:5432/runs", "me:***@db.org:5432/runs"),
        (f"postgresql+psycopg://me@/runs?host=/run/db&password={SECRET}", "me@/runs?host=/run/db"),
        (f"postgresql+psycopg://:{SECRET}@[::1]:1/runs", ":***@[::1]:1/runs"),
        (f"postgresql+psycopg://me@/?host=a,b&sslmode=require&options={SECRET}", "me@/?host=a,b&"),
    ],
)
def test_a_safe_address_says_where_the_store_is(address: str, shown: str) -> None:
    assert safe_address(address).startswith(f"postgresql+psycopg://{shown}")


@pytest.mark.parametrize("path", ["beads.grainfit", "/data/me@home:1/beads", "C:/me@home/beads"])
def test_a_path_is_no_address(path: str) -> None:
    assert safe_address(path) == path


def test_a_message_of_a_driver_loses_what_an_address_hides() -> None:
    address = StoreAddress.read("postgresql+psycopg://me:a%40b@host/runs?options=hidden")

    said = address.without_secrets("no 'a@b' and no a%40b with hidden at host, but manhidden")

    assert said == "no '***' and no *** with *** at host, but manhidden"


@pytest.mark.parametrize("command", [["status"], ["result"], ["report"], ["runs", "prune"]])
def test_a_command_for_folders_says_that_it_takes_no_address(command: list[str]) -> None:
    done = CliRunner().invoke(app, [*command, ADDRESSES[5]])
    assert messages.FOLDERS_ONLY.is_in(str(done.exception))


def test_a_password_that_an_earlier_version_stored_is_not_shown(tmp_path: Path) -> None:
    address = f"postgresql+psycopg://me@host/runs?password={SECRET}"
    store = RunStore.in_folder(tmp_path)
    identity = "a" * 64
    store.save(RunRecord(identity, "drum", "finished", RunDefinition({}, {}, 1)))
    store.close()
    with sqlite3.connect(tmp_path / STORE_NAME) as database:
        database.execute("UPDATE runs SET origin = ?", (address,))
    database.close()

    table = tmp_path / "runs.csv"
    outputs = [
        CliRunner().invoke(app, ["runs", "show", str(tmp_path), identity]).output,
        CliRunner().invoke(app, ["runs", "export", str(tmp_path), str(table)]).output,
        table.read_text(),
        json.dumps([run.to_json() for run in RunStore.read_only(tmp_path).runs()]),
    ]

    assert "postgresql+psycopg://me@host/runs" in outputs[0]
    assert [SECRET in output for output in outputs] == [False] * 4
    RunStore.in_folder(tmp_path).close()
    assert [path for path in tmp_path.iterdir() if SECRET.encode() in path.read_bytes()] == []
