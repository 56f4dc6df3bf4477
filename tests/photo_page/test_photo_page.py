"""The page on which a photograph is corrected by hand, in a browser and over its port."""

from __future__ import annotations

import http.client
import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

import grainfit as gf
import needs
from benchmarks import chromium
from benchmarks.axe import LAPTOP, PHONE, violations
from grainfit.local_pages.server import listen
from grainfit.photo_page.server import PhotoServer
from grainfit.photographs import messages
from grainfit.photographs.by_hand import by_hand_path
from tests.photographs.drawn_pictures import cone
from tests.photographs.rendered_pictures import Shot, save

# One measurement takes a second of a processor that is shared.
expect.set_options(timeout=60_000)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PhotoServer]:
    path = tmp_path_factory.mktemp("heap") / "heap.jpg"
    save(Shot(cone(25.0, 9.0, 1), elevation=6.0, distance=1.1, plate_radius=0.29), path, exif=True)
    started = PhotoServer(path, listen(0), plate="580 mm")
    started.serve()
    yield started
    started.shutdown()
    started.server_close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium.browser() as started:
        yield started


def value(page: Page) -> float:
    return float((page.locator(".photo-value").text_content() or "").partition("°")[0])


@needs.CHROMIUM
def test_what_is_dragged_is_measured_saved_and_used_again(
    server: PhotoServer, browser: Browser
) -> None:
    faults: list[str] = []
    page = browser.new_page(viewport=LAPTOP)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
    page.goto(server.address)
    expect(page.locator(".photo-value")).to_be_visible()
    before = value(page)
    assert violations(page) == []

    # With the mouse: the front of the plate line downward, as of a camera that is higher.
    front = page.locator(".handle").nth(2)
    box = front.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 8, steps=3)
    page.mouse.up()
    expect(page.locator("#value")).to_contain_text("plate line drawn by hand")
    expect(page.locator("#state")).to_be_empty()
    dragged = value(page)
    assert dragged > before + 0.2
    # With the keyboard, on a telephone.
    page.set_viewport_size(PHONE)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.get_by_role("radio", name="Axis").check()
    page.locator(".handle").focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#value")).to_contain_text("axis drawn by hand")
    expect(page.locator("#state")).to_be_empty()
    assert violations(page) == []

    page.get_by_role("button", name="Save").click()
    expect(page.locator("#saved")).to_contain_text("heap.jpg.by_hand.json")
    found = gf.photo(server.picture.path)
    assert found.angle_of_repose.value == pytest.approx(value(page), abs=0.03)
    assert messages.BY_HAND.is_in(str(found.summary()), drawn="plate line, axis")

    # Both parts back to the program: nothing is kept.
    for part in ("Axis", "Plate line"):
        page.get_by_role("radio", name=part).check()
        page.get_by_role("button", name="Leave this part").click()
    expect(page.locator("#value")).not_to_contain_text("by hand")
    page.get_by_role("button", name="Save").click()
    expect(page.locator("#saved")).to_contain_text("no file is kept")
    assert not by_hand_path(server.picture.path).exists()
    assert value(page) == pytest.approx(before, abs=0.01)
    assert faults == []


def ask(server: PhotoServer, path: str, body: str | None = None, **headers: str) -> int:
    port = server.socket.getsockname()[1]
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    connection.request("GET" if body is None else "POST", path, body, headers)
    status = connection.getresponse().status
    connection.close()
    return status


def test_only_the_page_itself_can_measure_and_save(server: PhotoServer) -> None:
    port = server.socket.getsockname()[1]
    own = {"Origin": f"http://127.0.0.1:{port}"}
    token = server.token
    drawn = json.dumps({"axis": [[400, 200]]})

    assert ask(server, f"/{token}/picture") == 200
    assert ask(server, "/wrong/picture") == 404
    assert ask(server, f"/{token}/picture", Host=f"evil.example:{port}") == 403
    assert ask(server, f"/{token}/../heap.jpg") == 404
    assert ask(server, f"/{token}/save", drawn) == 403
    assert ask(server, f"/{token}/save", drawn, Origin="http://evil.example") == 403
    assert ask(server, f"/{token}/save", '{"axis": [["<b>", 1]]}', **own) == 400
    assert ask(server, f"/{token}/save", "[" * 100_000, **own) == 400
    assert ask(server, f"/{token}/measure", " " * 300_000, **own) == 413
    assert not by_hand_path(server.picture.path).exists()


def test_a_folder_or_two_pictures_are_not_edited(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from grainfit.cli.app import app

    done = CliRunner().invoke(app, ["photo", "--edit", str(tmp_path)])

    assert isinstance(done.exception, gf.InputError)
