"""Progress in a terminal, in a log file and in a notebook."""

from __future__ import annotations

import io
import sys
from dataclasses import replace

import pytest
from rich.console import Console

import grainfit as gf
from grainfit.calibration.live_progress import LiveProgress
from grainfit.calibration.runs_to_come import RunsToCome
from grainfit.campaign.pending import PendingRun

BEGUN = gf.Progress("design", 3, 2, 1, RunsToCome(5.0), 60.0, 0.0123, (), {"other": 4})
PROBLEM = gf.Problem(
    [gf.Parameter("friction", 0.1, 0.9)], [gf.Target("angle", 30.0, tolerance=0.5)]
)
WORDS = "design: 3 done, 2 running, 1 failed, about 5 (3 to 8) to come, best run within 1.2%"


def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return {"angle": 60 * parameters["friction"]}


def shown(*steps: gf.Progress, terminal: bool) -> str:
    file = io.StringIO()
    console = Console(file=file, force_terminal=terminal, width=70, color_system=None)
    with LiveProgress(console) as bar:
        for step in steps:
            bar.update(step)
    return file.getvalue()


def test_a_terminal_shows_a_bar_and_the_words_in_full() -> None:
    text = shown(BEGUN, replace(BEGUN, notices=("[red]look\x1b[31m",)), terminal=True)
    assert "━" * 10 in text
    assert "36 s to 1 min 36 s left" in " ".join(text.replace("\n", " ").split())
    assert "[red]look\\x1b[31m" in text
    assert text.count("Warm start from 4 earlier runs") == 1


def test_a_log_file_has_a_line_for_each_stage() -> None:
    later = replace(BEGUN, done=4)
    verified = replace(BEGUN, stage="verification", notices=("look",))
    lines = shown(BEGUN, later, verified, terminal=False).splitlines()
    assert [line.partition(",")[0] for line in lines] == [
        "Warm start from 4 earlier runs: other (4).",
        "design: 3 done",
        "look",
        "verification: 3 done",
    ]
    assert lines[1].startswith(WORDS)


def test_runs_that_wait_for_a_worker_are_told_apart() -> None:
    waiting = tuple(PendingRun(name, "drum", "submitted") for name in "abcde")
    [line] = shown(replace(BEGUN, warm_start_runs={}, pending=waiting), terminal=False).splitlines()
    assert ", 2 running, 3 waiting, " in line


def test_progress_has_every_evaluation_and_what_is_expected_of_the_answer() -> None:
    steps: list[gf.Progress] = []
    result = gf.calibrate(PROBLEM, simulate, on_progress=steps.append)
    design = [step for step in steps if step.stage == "design"]
    assert {step.best_expected_deviation for step in design} == {None}
    assert len(steps[-1].evaluations) == result.runs.total
    expected = steps[-1].best_expected_deviation
    assert expected == pytest.approx(0.0, abs=0.001)
    words = shown(replace(BEGUN, best_expected_deviation=0.0456), terminal=False)
    assert "best run within 1.2%, answer expected within 4.6%" in words


def test_calibrate_shows_its_progress_where_it_is_asked_to(
    capsys: pytest.CaptureFixture[str],
) -> None:
    steps: list[gf.Progress] = []
    gf.calibrate(PROBLEM, simulate, progress=True, on_progress=steps.append)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("design: 0 done")
    assert steps[-1].stage == "verification"
    gf.calibrate(PROBLEM, simulate)
    assert capsys.readouterr().err == ""


NOTEBOOK = (
    "import grainfit as gf\nimport tempfile\nfolder = tempfile.mkdtemp()\n"
    "problem = gf.Problem([gf.Parameter('friction', 0.1, 0.9)],"
    " [gf.Target('angle', 30.0, tolerance=0.5)])\n"
    "import time\n"
    "def simulate(at, seed):\n    time.sleep(0.05)\n    return {'angle': 60 * at['friction']}",
    "result = gf.calibrate(problem, simulate, progress=True, name='<b>beads</b>', workdir=folder)",
    "result",
    "gf.show(folder)",
)


def test_a_notebook_shows_a_bar_and_the_result_as_a_table() -> None:
    nbclient = pytest.importorskip("nbclient", reason="pip install 'grainfit[test]'")
    nbformat = pytest.importorskip("nbformat", reason="pip install 'grainfit[test]'")
    pytest.importorskip("ipykernel", reason="pip install 'grainfit[test]'")
    pytest.importorskip("ipywidgets", reason="pip install 'grainfit[notebook]'")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(c) for c in NOTEBOOK])
    spec = {"display_name": "p", "language": "python", "name": "python3"}
    notebook.metadata["kernelspec"] = spec
    client = nbclient.NotebookClient(notebook, timeout=60, kernel_name="python3")
    client.create_kernel_manager()
    client.km.kernel_spec.argv[0] = sys.executable
    client.execute()

    widgets = [state for state in client.widget_state.values() if "outputs" in state]
    drawn = str(widgets or client.nb.cells[1].outputs)
    assert "application/vnd.jupyter.widget-view+json" in str(client.nb.cells[1].outputs)
    assert "done" in drawn
    (shown_result,) = client.nb.cells[2].outputs
    html = shown_result.data["text/html"]
    assert "<table>" in html
    assert "&lt;b&gt;beads&lt;/b&gt;: calibrated" in html
    assert '<td style="text-align: right">30 ± 0.5</td>' in html
    tables, *figures = [output.data for output in client.nb.cells[3].outputs]
    assert "calibrated" in tables["text/html"]
    assert all("application/vnd.plotly.v1+json" in figure for figure in figures)
    assert len(figures) == 2
