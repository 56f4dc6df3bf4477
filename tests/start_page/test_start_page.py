"""The page from nothing to a running calibration, in a browser and over its port."""

from __future__ import annotations

import http.client
import json
import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

import needs
from benchmarks import chromium
from benchmarks.axe import LAPTOP, PHONE, violations
from grainfit.campaign.folder_lock import hold
from grainfit.campaign.store.store import RunStore
from grainfit.cards.other_programs.edem import EDEM
from grainfit.errors import InputError
from grainfit.interview import messages as asked
from grainfit.interview.interview import Interview
from grainfit.local_pages.server import listen
from grainfit.result import Result
from grainfit.result.parts import RunCounts
from grainfit.start_page import messages
from grainfit.start_page.server import StartServer
from grainfit.verdict.rule import Status

# Chromium, the atlas and simulations share a few cores.
expect.set_options(timeout=60_000)
MODEL = """
import time

def drum(parameters, seed):
    time.sleep(0.05)
    return {"angle": 20 + 40 * parameters["friction"] + (seed % 7) / 50}
"""
OWN = """
name = "sand"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
function = "model.py:drum"
targets.angle = { value = 36, uncertainty = 0.4 }
[strategy]
max_runs = 7
"""


@pytest.fixture
def server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[StartServer]:
    monkeypatch.chdir(tmp_path)
    started = StartServer(Path("pellets.toml"), listen(0))
    started.serve()
    yield started
    started.shutdown()
    started.server_close()


def fill(page: Page, label: str, given: str) -> None:
    field = page.get_by_label(label)
    field.fill(given)
    field.press("Tab")
    expect(page.locator("#saved")).to_have_text("Kept in the file")


@needs.CHROMIUM
def test_from_nothing_to_an_estimate_and_a_plan(server: StartServer) -> None:
    with chromium.browser() as browser:
        faults: list[str] = []
        page = browser.new_page(viewport=LAPTOP)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        page.goto(server.address)
        fill(page, "Which material", "wood pellets")
        expect(page.locator("#questions")).to_contain_text("usual ranges of pellets")
        page.get_by_label("How large").fill("6")
        expect(page.locator("#questions")).to_contain_text("6 has no unit")
        # What is wrong is not in the file, and is there again after a reload.
        page.reload()
        expect(page.get_by_label("How large")).to_have_value("6")
        expect(page.locator("#questions")).to_contain_text("6 has no unit")
        fill(page, "How large", "6 mm")
        for name in ("tube or pipe", "phone or camera"):
            page.get_by_label(name).check()
            expect(page.locator("#saved")).to_have_text("Kept in the file")
        page.get_by_label("heap: lifted cylinder").check()
        angle = page.get_by_label("Angle of repose, measured")
        angle.fill("31; 33; 32 deg ± 0.5 deg")
        expect(page.locator("#questions")).to_contain_text("Mean 32° of 3 repeats")
        assert "31 deg" not in Interview.open(server.path).text
        expect(page.locator("#estimate")).to_contain_text("sliding_friction")
        angle.press("Tab")
        expect(page.locator("#plan")).to_contain_text("DEM runs")
        # What stays open is said once, by the estimate.
        expect(page.locator("#plan .open-parameters")).not_to_have_count(0)
        expect(page.locator("#plan .open-parameters").first).to_be_hidden()
        expect(page.locator("#file-text")).to_contain_text('measurements = ["31 deg"')
        assert violations(page) == []
        page.set_viewport_size(PHONE)
        page.emulate_media(color_scheme="dark")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert violations(page) == []
        angle.fill("")
        angle.press("Tab")
        expect(page.locator("#estimate-box")).to_be_hidden()
        # By the atlas no longer: what stays open is said by the plan again.
        expect(page.locator("body")).not_to_have_class("estimated")
        assert faults == []


@needs.CHROMIUM
def test_a_start_runs_and_leads_to_the_page_that_follows_it(server: StartServer) -> None:
    server.path.write_text(OWN)
    Path("model.py").write_text(MODEL)
    with chromium.browser() as browser:
        page = browser.new_page(viewport=LAPTOP)
        page.goto(server.address)
        page.get_by_role("button", name="Start the calibration").click()
        with page.expect_popup() as followed:
            page.locator("#watch").click()
        expect(followed.value.locator("#name")).to_have_text("sand")
        expect(page.locator("#followed")).to_contain_text("It has ended: undecided.")
        expect(page.locator("#offers")).to_contain_text(EDEM.title)
        with page.expect_download() as handed:
            page.get_by_role("link", name="JSON").click()
        card = json.loads(handed.value.path().read_text())
        with page.expect_download() as handed:
            page.get_by_role("link", name="PDF").click()
        assert handed.value.suggested_filename == "pellets_sheet.pdf"
        assert handed.value.path().read_bytes().startswith(b"%PDF")
        assert violations(page) == []
    assert card["parameters"][0]["name"] == "friction"
    assert fetch(server, "hand-over/../result.json")[0] == 404
    # The card of a solver lacks what an own model does not have.
    status, words = fetch(server, "hand-over/liggghts")
    assert status == 409
    assert "youngs_modulus" in words
    assert (server.work_folder / "result.json").exists()


def fetch(server: StartServer, path: str) -> tuple[int, str]:
    return ask(server, "GET", f"/{server.token}/{path}")


def post(server: StartServer, path: str, body: str = "{}", **headers: str) -> tuple[int, str]:
    return ask(server, "POST", path, body, **headers)


def ask(
    server: StartServer, method: str, path: str, body: str = "", **headers: str
) -> tuple[int, str]:
    port = server.socket.getsockname()[1]
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    connection.request(method, path, body, headers)
    answer = connection.getresponse()
    found = answer.status, answer.read().decode()
    connection.close()
    return found


def test_only_the_page_itself_changes_or_starts_anything(server: StartServer) -> None:
    own = {"Origin": f"http://127.0.0.1:{server.socket.getsockname()[1]}"}
    answer = json.dumps({"key": "material", "given": "wheat"})
    token = server.token

    assert post(server, f"/{token}/answer", answer)[0] == 403
    assert post(server, f"/{token}/answer", answer, Origin="http://evil.example")[0] == 403
    assert post(server, "/wrong/answer", answer, **own)[0] == 404
    assert post(server, f"/{token}/run", "{}")[0] == 403
    assert post(server, f"/{token}/answer", '{"key": 1}', **own)[0] == 400
    assert post(server, f"/{token}/answer", "[" * 100_000, **own)[0] == 400
    assert post(server, f"/{token}/answer", " " * 300_000, **own)[0] == 413
    assert not server.path.exists()
    assert post(server, f"/{token}/answer", answer, **own)[0] == 200
    assert "wheat" in server.path.read_text()


def test_what_is_refused_is_said_and_an_editor_may_come_between(server: StartServer) -> None:
    own = {"Origin": f"http://127.0.0.1:{server.socket.getsockname()[1]}"}

    def said(what: str, key: str = "", given: str = "") -> dict:
        body = json.dumps({"key": key, "given": given})
        return json.loads(post(server, f"/{server.token}/{what}", body, **own)[1])

    assert "comes before" in said("answer", "diameter", "3 mm")["refused"]
    assert asked.NOTHING_AT_HAND.is_in(said("answer", "material", "wheat")["left"][0])
    server.path.write_text(server.path.read_text() + "\n# from an editor\n")
    assert "# from an editor" in said("answer", "diameter", "4 mm")["text"]
    for odd in ("\ud800", "9" * 5000, "2:1"):
        assert "refused" in said("answer", "diameter", odd)
        assert "refused" in said("try", "wall_friction", odd)
    server.path.write_text("name = ")
    assert "refused" in said("answer", "diameter", "5 mm")
    assert "fault" in server.state()
    assert server.path.read_text() == "name = "


def ended(server: StartServer, status: Status, **parameters: float) -> None:
    """Leave what a calibration of the present file does that has ended, with an answer or none."""
    about = {"provenance": {"file": server.path.name, "text": server.path.read_text()}}
    server.work_folder.mkdir()
    with closing(RunStore.in_folder(server.work_folder)) as store:
        store.begin_calibration("c", "sand", {}, about=about)
        store.end_calibration("c", status)
    result = Result(
        status=status,
        parameters=parameters,
        responses={},
        runs=RunCounts(),
        rayleigh_time_step=None,
        rayleigh_time_step_before=None,
        rayleigh_time_step_limits=None,
        wall_seconds=1.0,
        utilisation=1.0,
        probability_all_met=None,
        name="sand",
        identity="c",
        strategy="sequential",
        seed=1,
        version="0.2.0",
    )
    result.to_json(server.work_folder / "result.json")


@needs.CHROMIUM
def test_cards_are_offered_of_an_answer_and_said_to_be_of_an_earlier_file(
    server: StartServer,
) -> None:
    server.path.write_text(OWN)
    ended(server, "calibrated", friction=0.5)
    found = server.run_state()
    assert EDEM.name in found["offers"]
    assert not found["earlier"]
    # A remark changes nothing that was calibrated.
    server.path.write_text(f"{OWN}# of Monday\n")
    assert not server.run_state()["earlier"]
    server.path.write_text(OWN.replace("36", "40"))
    found = server.run_state()
    assert messages.EARLIER_FILE.is_in(found["earlier"])
    with chromium.browser() as browser:
        page = browser.new_page(viewport=LAPTOP)
        page.goto(server.address)
        expect(page.locator("#hand-box")).to_contain_text(found["earlier"])
        expect(page.locator("#followed")).to_contain_text("earlier file")


def test_no_link_leads_to_a_work_folder_that_was_deleted(server: StartServer) -> None:
    server.path.write_text(OWN)
    ended(server, "calibrated", friction=0.5)
    watch = server.run_state()["watch"]
    assert watch
    shutil.rmtree(server.work_folder)
    assert server.run_state()["watch"] == ""
    # The page that was opened follows the next one.
    ended(server, "calibrated", friction=0.5)
    assert server.run_state()["watch"] == watch


def test_no_cards_are_offered_without_an_answer(server: StartServer) -> None:
    server.path.write_text(OWN)
    ended(server, "interrupted")
    assert server.run_state()["state"] == "interrupted"
    assert server.run_state()["offers"] == {}
    assert fetch(server, f"hand-over/{EDEM.name}")[0] == 404


@needs.CHROMIUM
def test_a_page_that_is_opened_again_knows_that_the_calibration_runs(server: StartServer) -> None:
    server.path.write_text(OWN)
    Path("model.py").write_text(MODEL)
    ended(server, "calibrated", friction=0.5)
    with chromium.browser() as browser:
        page = browser.new_page(viewport=LAPTOP)
        with hold(server.work_folder):
            page.goto(server.address)
            expect(page.locator("#watch")).to_contain_text("It runs")
            expect(page.locator("#plan")).to_contain_text("DEM runs")
            expect(page.locator("#run")).to_be_hidden()
            expect(page.locator("#hand-box")).to_be_hidden()
            with pytest.raises(InputError, match=messages.RUNS_ALREADY.pattern):
                server.start_run("")
        expect(page.locator("#run")).to_be_visible()
        # It is started in a terminal.
        with hold(server.work_folder):
            expect(page.locator("#run")).to_be_hidden()


@needs.CHROMIUM
def test_a_hidden_page_asks_nothing_until_it_is_shown(server: StartServer) -> None:
    with chromium.browser() as browser:
        page = browser.new_page(viewport=LAPTOP)
        page.clock.install()
        page.goto(server.address)
        page.evaluate("Object.defineProperty(document, 'hidden', { get: () => window.isAway })")
        page.evaluate("window.isAway = true; document.dispatchEvent(new Event('visibilitychange'))")
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.clock.run_for(60_000)
        assert asked == []
        with page.expect_request("**/run"):
            page.evaluate(
                "window.isAway = false; document.dispatchEvent(new Event('visibilitychange'))"
            )


@needs.CHROMIUM
def test_a_start_waits_for_what_is_refused_and_an_ended_page_says_so(server: StartServer) -> None:
    server.path.write_text(
        OWN.replace("[parameters]", '[particle]\ndiameter = "3 mm"\n[parameters]')
    )
    Path("model.py").write_text(MODEL)
    with chromium.browser() as browser:
        page = browser.new_page(viewport=LAPTOP)
        page.goto(server.address)
        diameter, saved = page.get_by_label("How large are the particles"), page.locator("#saved")
        diameter.fill("abc")
        diameter.press("Tab")
        expect(saved).to_have_text("Not kept")
        page.get_by_label("moist").fill("2 %")
        page.get_by_label("moist").press("Tab")
        expect(page.locator("#file-text")).to_contain_text("2 %")
        expect(saved).to_have_text("Not kept")
        page.locator("#run").click()
        expect(page.locator("#plan-state")).to_contain_text("Not started")
        expect(diameter).to_be_focused()
        assert not server.is_running
        fill(page, "How large are the particles", "4 mm")
        server.shutdown()
        server.server_close()
        diameter.fill("5 mm")
        diameter.press("Tab")
        expect(saved).to_have_text("Not kept")
        expect(page.locator("#questions")).to_contain_text("The page has ended")


@needs.CHROMIUM
def test_every_refused_draft_stays_red_until_it_is_corrected(server: StartServer) -> None:
    with chromium.browser() as browser:
        page = browser.new_page(viewport=LAPTOP)
        page.goto(server.address)
        fill(page, "Which material", "wheat")
        fill(page, "How large", "5 mm")
        diameter, friction = page.get_by_label("How large"), page.get_by_label("slide on your wall")
        saved = page.locator("#saved")
        for field, wrong in ((diameter, "6,5 mm"), (friction, "0,3")):
            field.fill(wrong)
            field.press("Tab")
            expect(field).to_have_attribute("aria-invalid", "true")
        moisture = page.get_by_label("moist")
        moisture.fill("2 %")
        moisture.press("Tab")
        expect(page.locator("#file-text")).to_contain_text("2 %")
        # What is refused is asked for again, and each answer takes a moment.
        page.wait_for_timeout(1000)
        expect(diameter).to_have_attribute("aria-invalid", "true")
        expect(friction).to_have_attribute("aria-invalid", "true")
        friction.fill("0.3")
        friction.press("Tab")
        expect(page.locator("#file-text")).to_contain_text("0.3")
        expect(saved).to_have_text("Not kept")
        expect(diameter).to_have_attribute("aria-invalid", "true")
        expect(page.locator("#q-diameter-said")).to_have_class("refused")
        # As one types: what was refused by then is kept before it is tried out.
        diameter.fill("5 m")
        expect(page.locator("#q-diameter-said")).to_contain_text("5 m")
        diameter.press("End")
        diameter.press("m")
        diameter.press("Tab")
        expect(saved).to_have_text("Kept in the file")
        expect(page.locator("#q-diameter-said")).to_have_class("implies")
        expect(diameter).to_have_attribute("aria-invalid", "false")


def test_a_prediction_is_verified_at_full_size_once(server: StartServer) -> None:
    server.path.write_text(OWN)
    Path("model.py").write_text(MODEL.replace("0.05", "0.5"))
    ended(server, "predicted")
    assert server.state()["run"]["state"] == "predicted"
    assert server.state()["run"]["ended"] == "predicted, full size pending"
    server.start_run("--full-size")
    assert server._run is not None
    process = server._run._process
    try:
        assert process.args[-2:] == [str(server.path), "--full-size"]
        assert server.state()["run"]["state"] == ""
        with pytest.raises(Exception, match=messages.RUNS_ALREADY.pattern):
            server.start_run("")
    finally:
        process.terminate()
        process.wait(60)
