"""`grainfit ask`: the interview in a terminal."""

import os
import pty
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

from typer.testing import CliRunner

from grainfit.cli import messages
from grainfit.cli.app import app
from grainfit.interview import messages as of_interview
from grainfit.interview.interview import Interview

BEFORE = "wheat\n?\n12 %\n4 mm\n\n\n\n\n"
LABORATORY = "3,12,tube\n1,packing\n"
HEAP = "20 mm\n\n\n\n600; 610 kg/m3\n\n\n\n"
TAKEN_BACK = "20 mm\n\n\n\n600; 610 kg/m3\nback\nnone\n30 deg\n\n\n"


def ask(folder: Path, typed: str, *options: str) -> tuple[str, int]:
    done = CliRunner().invoke(app, ["ask", str(folder / "w.toml"), *options], input=typed)
    return done.output, done.exit_code


def test_it_asks_to_the_end_and_shows_the_plan(tmp_path: Path) -> None:
    typed = BEFORE + LABORATORY + HEAP + "\n\n700 kg/m^3 ± 1 %\n\n"
    output, code = ask(tmp_path, typed, "--no-estimate")

    assert code == 0, output
    assert "a note for people" in output
    assert "2. Fill it from the top" in output
    assert "Mean 605 kg/m³ of 2 repeats" in output
    assert "packing.bulk_density" in output
    assert messages.READY.is_in(output)


def test_an_end_of_the_answers_keeps_them_and_it_goes_on_there(tmp_path: Path) -> None:
    output, code = ask(tmp_path, BEFORE + LABORATORY)
    assert messages.ANSWERS_KEPT.is_in(output)
    assert code == 130

    output, code = ask(tmp_path, TAKEN_BACK + "\n\n\n\n", "--no-estimate")
    assert code == 0, output
    assert "Which material" not in output
    assert of_interview.NOT_MEASURED.is_in(output, names="packing", verb="has")
    _, code = ask(tmp_path, "", "--sheet", str(tmp_path / "sheet.pdf"))
    assert code == 0
    assert (tmp_path / "sheet.pdf").read_bytes().startswith(b"%PDF")


def test_an_end_at_the_first_question_is_an_interruption_as_well(tmp_path: Path) -> None:
    output, code = ask(tmp_path, "")

    assert f"\n{messages.INTERRUPTED()}\n" in output
    assert code == 130


def test_a_wrong_answer_is_explained_and_asked_again(tmp_path: Path) -> None:
    output, _ = ask(tmp_path, "\nquux\nwheat\n\n4\n4 mm\n")

    assert output.count("Which material") == 3
    assert output.count("How large are the particles?") == 2
    assert of_interview.NO_UNIT.is_in(output, given=4)


def test_ctrl_c_on_a_terminal_keeps_the_answers(tmp_path: Path) -> None:
    leader, follower = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "grainfit", "ask", "w.toml", "--material", "rape seed"],
        cwd=tmp_path,
        stdin=follower,
        stdout=follower,
        stderr=follower,
        start_new_session=True,
        # As in a terminal, whatever the tests were started with.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    os.close(follower)
    try:
        _wait_for(leader, "How moist is it?")
        # Python loses a signal that comes just before it begins to read.
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _wait_for(leader, "Go on with")
    except BaseException:
        process.kill()
        raise
    assert process.wait(30) == 130
    os.close(leader)
    [material, *_] = Interview.open(tmp_path / "w.toml").questions()
    assert (material.answer, material.is_asked) == ("rape seed", True)


def _wait_for(terminal: int, words: str, seconds: float = 60.0) -> None:
    """Read a terminal until it shows some words."""
    seen, end = "", time.monotonic() + seconds
    while words not in " ".join(seen.split()):
        ready, _, _ = select.select([terminal], [], [], max(end - time.monotonic(), 0))
        assert ready, seen
        seen += os.read(terminal, 4096).decode(errors="replace")
