"""Pictures that are given to the page that starts a calibration."""

from __future__ import annotations

import base64
import http.client
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from grainfit.interview.interview import Interview
from grainfit.local_pages.server import listen
from grainfit.photographs import messages as of_pictures
from grainfit.start_page import messages
from grainfit.start_page.server import StartServer
from tests.photographs.photographed_heap import HEAP

KEY = "heap.targets.angle_of_repose"


@pytest.fixture
def server(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[StartServer]:
    monkeypatch.chdir(folder)
    (folder / "my beads; 1.toml").write_text(HEAP)
    started = StartServer(Path("my beads; 1.toml"), listen(0))
    started.serve()
    yield started
    started.shutdown()
    started.server_close()


def asked(server: StartServer, method: str, path: str, body: str = "") -> tuple[int, bytes]:
    host = f"127.0.0.1:{server.socket.getsockname()[1]}"
    connection = http.client.HTTPConnection(host, timeout=120)
    connection.request(method, f"/{server.token}/{path}", body, {"Origin": f"http://{host}"})
    answer = connection.getresponse()
    found = answer.status, answer.read()
    connection.close()
    return found


def give(server: StartServer, path: Path | str, content: bytes | None = None) -> tuple[int, str]:
    content = Path(path).read_bytes() if content is None else content
    encoded = base64.b64encode(content).decode()
    body = json.dumps({"key": KEY, "name": str(path), "content": encoded})
    status, found = asked(server, "POST", "picture", body)
    return status, found.decode()


def angle(server: StartServer) -> dict:
    questions = json.loads(asked(server, "GET", "state")[1])["questions"]
    return next(one for one in questions if one["key"] == KEY)


def test_pictures_are_kept_measured_and_shown(server: StartServer) -> None:
    assert give(server, "heap_1.jpg")[0] == 200
    assert give(server, "heap_2.jpg")[0] == 200

    found = angle(server)
    assert found["answer"] == "my_beads_1_photos/heap_1.jpg; my_beads_1_photos/heap_2.jpg"
    assert "heap 2" in found["implies"]
    status, drawn = asked(server, "GET", f"overlay/1/{KEY}")
    assert (status, drawn[:4]) == (200, b"\x89PNG")
    assert asked(server, "GET", f"overlay/2/{KEY}")[0] == 404
    assert asked(server, "GET", "overlay/0/../beads.toml")[0] == 404
    target = Interview.open(server.path).setup().problem.targets[0]
    assert f"{target.value:.2f} ± {target.uncertainty:.2f} deg" in found["implies"]

    # Typed values take their place, and the file has nothing of the pictures any more.
    typed = Interview.open(server.path).answered(KEY, "25; 26; 27 deg")
    typed.save()
    assert "photos" not in typed.text
    assert messages.TYPED_ALREADY.is_in(give(server, "heap_1.jpg")[1])

    server.path.write_text("name = ")
    assert asked(server, "GET", f"overlay/1/{KEY}")[0] == 404


def test_what_is_no_picture_is_refused_and_not_kept(server: StartServer) -> None:
    before = server.path.read_text()

    assert give(server, "../../evil.sh", b"#!")[0] == 400
    assert "refused" in give(server, "broken.jpg", b"no picture")[1]
    assert asked(server, "POST", "picture", '{"key": "heap"}')[0] == 400

    assert server.path.read_text() == before
    assert not Path("my_beads_1_photos").exists()


def test_what_is_refused_is_named_as_it_was_given(server: StartServer) -> None:
    assert give(server, "heap_2.jpg")[0] == 200
    kept = Path("my_beads_1_photos")

    broken = json.loads(give(server, "of Monday.jpg", b"no picture")[1])["refused"]
    assert broken.startswith("of Monday.jpg: ")
    assert kept.name not in broken
    again = json.loads(give(server, "again.jpg", Path("heap_2.jpg").read_bytes())[1])["refused"]
    same = of_pictures.SAME_PICTURE(file="again.jpg", other="heap_2.jpg")
    assert same in again
    assert [path.name for path in kept.iterdir()] == ["heap_1.jpg"]
