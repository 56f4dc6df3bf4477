"""Take the pictures of a watch page and of a report, docs/images/watch.png and report.png.

python tools/page_pictures.py            both
python tools/page_pictures.py --report   that of the report alone, which simulates nothing

Looks at the pages with Chromium: at a watch page of examples/glass_beads after some runs, two at a
time, which then stops, and at the report of docs/recorded/beads as this version evaluates it.
"""

from __future__ import annotations

import argparse
import io
import json
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from grainfit.work_folder.saved_calibration import SavedCalibration

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
_RECORDED = ROOT / "docs" / "recorded" / "beads"
_FILE = ROOT / "examples" / "glass_beads" / "calibration.toml"
_RUNS = 8
#: The first screen of a report ends before its times, which are those of this machine.
_HEIGHT, _ANSWER = 945, 664
_LARGEST = 150_000
#: ms; of a busy machine.
_PATIENCE = 600_000.0


def main() -> None:
    """Write the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--report", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"))
        page = browser.new_page(viewport={"width": 1200, "height": _HEIGHT})
        page.set_default_timeout(_PATIENCE)
        if not given.report:
            _take_watch_page(page, Path(folder) / "running.grainfit")
        _take_report(page, Path(folder) / "glass_beads.grainfit")
        browser.close()


def _take_watch_page(page: Page, work: Path) -> None:
    """Write the picture of the page of a calibration that runs, and stop the calibration."""
    command = [sys.executable, "-m", "grainfit", "run", str(_FILE), "--workers", "2"]
    command += ["--workdir", str(work), "--watch"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=subprocess.STDOUT, text=True) as run:
        assert run.stdout is not None
        for line in run.stdout:
            if found := re.search(r"http://\S+", line):
                page.goto(found.group().rstrip("."))
                break
        while run.poll() is None and len(SavedCalibration.open(work).evaluations) < _RUNS:
            page.wait_for_timeout(1000)
        page.get_by_text("A first verdict follows").wait_for(state="hidden")
        page.wait_for_timeout(5000)
        _take(page, "watch")
        run.send_signal(signal.SIGINT)
        run.stdout.read()


def _take_report(page: Page, work: Path) -> None:
    """Write the picture of the report of the recorded runs."""
    shutil.copytree(_RECORDED, work)
    result = json.loads((work / "result.json").read_text(encoding="utf-8"))
    # Without those of the version that recorded them, intervals and biases are computed.
    text = json.dumps(result | {"intervals": {}})
    (work / "result.json").write_text(text, encoding="utf-8")
    subprocess.run([sys.executable, "-m", "grainfit", "report", str(work)], check=True)
    page.set_viewport_size({"width": 1200, "height": _ANSWER})
    page.goto((work / "report.html").as_uri())
    page.wait_for_timeout(2000)
    _take(page, "report")


def _take(page: Page, name: str) -> None:
    """Write what is seen of a page, with as many colours as the file may have."""
    taken = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    for colours in (256, 128, 64):
        taken.quantize(colours).save(IMAGES / f"{name}.png", optimize=True)
        if (IMAGES / f"{name}.png").stat().st_size <= _LARGEST:
            return
    raise SystemExit(f"{name}.png is larger than {_LARGEST} bytes")


if __name__ == "__main__":
    main()
