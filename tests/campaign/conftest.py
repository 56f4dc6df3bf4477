"""A PostgreSQL server for the tests of shared stores."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from grainfit.campaign.store.store import RunStore
from tests.servers.postgresql_server import PostgresqlServer, postgresql_server, program


@pytest.fixture(scope="session")
def running_server() -> Iterator[PostgresqlServer]:
    pytest.importorskip("psycopg")
    if program("initdb") is None:
        pytest.skip("PostgreSQL is not installed: apt-get install postgresql")
    with postgresql_server() as server:
        yield server


@pytest.fixture
def server(running_server: PostgresqlServer) -> Iterator[PostgresqlServer]:
    """A server whose store is empty."""
    yield running_server
    store = RunStore(running_server.url)
    for identity in store.identities():
        store.forget(identity)
    store.close()
