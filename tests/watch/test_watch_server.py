"""The server of the page: who may read, who may stop, and what can never be reached."""

from __future__ import annotations

import http.client
import json
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from watched_runs import address, calibration, run, served, wait_for

from benchmarks import campaigns
from grainfit.campaign.folder_lock import hold
from grainfit.errors import InputError
from grainfit.local_pages import messages
from grainfit.local_pages.server import address_of, listen
from grainfit.watch import messages as of_watch
from grainfit.watch.server import WatchServer

SECRET = "a secret of the user"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    work = tmp_path_factory.mktemp("watched") / "work"
    with campaigns.campaign("no_run_finished", work):
        (work / "secret").write_text(SECRET)
        (work / "report.html").write_text("<p>the report</p>")
        return work


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[WatchServer]:
    with served(folder) as started:
        yield started


def ask(
    server: WatchServer, path: str, method: str = "GET", **headers: str
) -> tuple[int, str, dict[str, str]]:
    """Request a path as it is, without any correction."""
    port = server.socket.getsockname()[1]
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in {"Host": f"127.0.0.1:{port}", **headers}.items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    body = answer.read().decode()
    connection.close()
    return answer.status, body, dict(answer.getheaders())


def first_state(server: WatchServer) -> dict[str, Any]:
    port = server.socket.getsockname()[1]
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    connection.request("GET", f"/{server.token}/events")
    line = connection.getresponse().readline().decode()
    connection.close()
    state: dict[str, Any] = json.loads(line.removeprefix("data: "))
    return state


def test_the_address_shows_the_page_and_its_state(server: WatchServer) -> None:
    status, page, headers = ask(server, f"/{server.token}/")
    assert status == 200
    assert "<title>" in page
    assert headers["Referrer-Policy"] == "no-referrer"
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
    assert "unsafe" not in headers["Content-Security-Policy"]
    assert ask(server, f"/{server.token}")[0] == 303
    assert first_state(server)["state"] == "interrupted"


def test_a_tunnel_may_end_at_another_port(server: WatchServer) -> None:
    assert ask(server, f"/{server.token}/", Host="localhost:8000")[0] == 200


@pytest.mark.parametrize("token", ["", "0", "x" * 32, "\udcff", "TOKEN.", "token"])
def test_nothing_is_shown_without_the_token(server: WatchServer, token: str) -> None:
    given = token.replace("TOKEN", server.token).replace("token", server.token.swapcase())
    if token == "\udcff":
        given = "%ff"
    for rest in ("", "events", "report", "drawing/test-1"):
        status, body, _ = ask(server, f"/{given}/{rest}")
        assert status == 404
        assert server.token not in body
        assert "html" not in body


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "", "localhost:80@x"])
def test_a_page_under_another_name_reaches_nothing(server: WatchServer, host: str) -> None:
    for method, rest in (("GET", ""), ("GET", "events"), ("POST", "stop")):
        origin = f"http://{host}"
        assert ask(server, f"/{server.token}/{rest}", method, Host=host, Origin=origin)[0] == 403


@pytest.mark.parametrize(
    "path",
    [
        "secret",
        "runs.sqlite",
        "../secret",
        "drawing/../secret",
        "drawing/../../../../etc/passwd",
        "%2e%2e/secret",
        "drawing/%2e%2e%2fsecret",
        "report/../secret",
        "report.html",
        "/etc/passwd",
        "events/../../secret",
    ],
)
def test_no_other_file_is_reached(server: WatchServer, path: str) -> None:
    status, body, _ = ask(server, f"/{server.token}/{path}")
    assert status == 404
    assert SECRET not in body
    assert "root:" not in body


def test_the_report_is_shown_without_the_rights_of_the_page(server: WatchServer) -> None:
    status, body, headers = ask(server, f"/{server.token}/report")
    assert (status, body) == (200, "<p>the report</p>")
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("sandbox allow-scripts allow-downloads;")
    assert "same-origin" not in policy


def test_an_address_for_the_browser_leads_to_the_page_once(server: WatchServer) -> None:
    server.add_ticket("once")
    status, _, headers = ask(server, "/once/")
    assert (status, headers["Location"]) == (303, f"/{server.token}/")
    assert ask(server, "/once/")[0] == 404


def test_other_machines_reach_no_port(server: WatchServer) -> None:
    port = server.socket.getsockname()[1]
    assert server.socket.getsockname()[0] == "127.0.0.1"
    # Another address of this machine, which a server of all interfaces would answer at.
    with pytest.raises(ConnectionRefusedError), socket.create_connection(("127.0.0.2", port), 5):
        pass


def test_a_port_in_use_is_named(server: WatchServer) -> None:
    port = server.socket.getsockname()[1]
    with pytest.raises(InputError, match=f"port: {messages.PORT_TAKEN.pattern}"):
        listen(port)
    assert address_of(server.socket, "t") == f"http://127.0.0.1:{port}/t/"


def test_many_idle_connections_do_not_hang_up_the_server(server: WatchServer) -> None:
    port = server.socket.getsockname()[1]
    idle = [socket.create_connection(("127.0.0.1", port)) for _ in range(70)]
    for connection in idle:
        connection.close()
    wait_for(lambda: ask(server, f"/{server.token}/")[0] == 200, 20)


@contextmanager
def slow_clients(port: int, count: int) -> Iterator[list[socket.socket]]:
    """Connections that send a byte now and then, and never a whole request."""
    clients = [socket.create_connection(("127.0.0.1", port)) for _ in range(count)]
    ended = threading.Event()

    def send() -> None:
        while not ended.wait(0.2):
            for client in clients:
                with suppress(OSError):
                    client.send(b"G")

    thread = threading.Thread(target=send, daemon=True)
    thread.start()
    yield clients
    ended.set()
    thread.join()
    for client in clients:
        client.close()


def test_slow_clients_lock_nobody_out_who_has_the_token(server: WatchServer) -> None:
    port = server.socket.getsockname()[1]
    stream = socket.create_connection(("127.0.0.1", port), timeout=20)
    stream.sendall(f"GET /{server.token}/events HTTP/1.0\r\nHost: localhost\r\n\r\n".encode())
    assert stream.recv(12) == b"HTTP/1.0 200"

    def answers() -> bool:
        try:
            return ask(server, f"/{server.token}/")[0] == 200
        except OSError:
            return False

    with slow_clients(port, 64):
        wait_for(answers, 20)
    # Nor do they push out those who are there.
    stream.settimeout(0.5)
    with suppress(TimeoutError):
        while True:
            assert stream.recv(65536)
    stream.close()


def test_a_request_that_does_not_end_is_ended(
    server: WatchServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grainfit.local_pages.server._REQUEST_SECONDS", 1.0)
    with slow_clients(server.socket.getsockname()[1], 3) as clients:
        for client in clients:
            client.settimeout(20)
            with suppress(ConnectionResetError):
                assert client.recv(1) == b""


@pytest.fixture
def interrupts(tmp_path: Path) -> Iterator[list[int]]:
    """Interrupts of this process, which stands for a calibration and survives them."""
    received: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _frame: received.append(number))
    yield received
    signal.signal(signal.SIGINT, before)


def test_only_the_page_itself_can_stop_a_calibration(
    server: WatchServer, interrupts: list[int], folder: Path
) -> None:
    port = server.socket.getsockname()[1]
    own = f"http://127.0.0.1:{port}"
    with hold(folder):
        for origin in ("http://evil.example", f"https://127.0.0.1:{port}", "null", ""):
            assert ask(server, f"/{server.token}/stop", "POST", Origin=origin)[0] == 403
        assert ask(server, f"/{server.token}/stop", "POST")[0] == 403
        assert ask(server, "/wrong/stop", "POST", Origin=own)[0] == 404
        assert ask(server, f"/{server.token}/stop", "GET", Origin=own)[0] == 404
        for method in ("PUT", "DELETE", "OPTIONS", "HEAD"):
            assert ask(server, f"/{server.token}/stop", method, Origin=own)[0] == 501
        assert interrupts == []
        assert ask(server, f"/{server.token}/stop", "POST", Origin=own)[0] == 200
        wait_for(lambda: interrupts == [signal.SIGINT], 5)
    status, body, _ = ask(server, f"/{server.token}/stop", "POST", Origin=own)
    assert status == 409
    assert of_watch.NOT_IN_USE.is_in(json.loads(body)["why"])


def test_the_server_of_a_killed_run_tells_so_and_ends(tmp_path: Path) -> None:
    file = calibration(tmp_path)
    with run(file, "--watch") as process:
        at = urlsplit(address(file))
        connection = http.client.HTTPConnection(at.netloc, timeout=60)
        connection.request("GET", f"{at.path}events")
        stream = connection.getresponse()
        process.kill()
        lines = (line.decode() for line in stream)
        states = [json.loads(line[6:]) for line in lines if line.startswith("data: ")]
    assert states[0]["state"] == "running"
    assert (states[-1]["state"], states[-1]["ended"]) == ("interrupted", True)
    assert not any(state["ended"] for state in states[:-1])
    wait_for(lambda: not is_listening(at.port), 20)


def is_listening(port: int | None) -> bool:
    with socket.socket() as caller:
        return caller.connect_ex(("127.0.0.1", port)) == 0


def test_watching_changes_nothing_in_the_folder(folder: Path) -> None:
    def content() -> dict[str, tuple[int, bytes]]:
        files = (path for path in sorted(folder.rglob("*")) if path.is_file())
        return {str(path): (path.stat().st_mtime_ns, path.read_bytes()) for path in files}

    before = content()
    with served(folder) as another:
        first_state(another)
        ask(another, f"/{another.token}/")
    assert content() == before
