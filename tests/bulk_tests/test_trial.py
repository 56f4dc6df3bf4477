"""Functions of the user that end Python, crash it, or never return."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from grainfit.bulk_tests.own_scene import messages
from grainfit.bulk_tests.own_scene.trial import LIMIT, require_return
from grainfit.errors import RunFailedError
from grainfit.options.python_file import PythonFile

FORK = multiprocessing.get_context("fork")


def function(folder: Path, body: str) -> PythonFile:
    (folder / "mine.py").write_text(f"import ctypes, os\n\ndef scene(seed):\n    {body}\n")
    return PythonFile(f"{folder / 'mine.py'}:scene")


def reason(
    tried: PythonFile, limit: float = LIMIT, before: Callable[[], None] | None = None
) -> str:
    """Why a trial fails, in a process that has one thread, as that of a command; "" if it does not.

    With `before`, the trial is the second one, and that is called between the two.
    """

    def run(found: Connection) -> None:
        try:
            if before is not None:
                with pytest.raises(RunFailedError):
                    require_return(tried, {"seed": 1}, limit)
                before()
            require_return(tried, {"seed": 1}, limit)
            found.send("")
        except RunFailedError as error:
            found.send(error.reason)

    here, there = FORK.Pipe(duplex=False)
    process = FORK.Process(target=run, args=(there,))
    process.start()
    assert here.poll(LIMIT)
    found: str = here.recv()
    process.join()
    return found


@pytest.mark.parametrize(
    ("body", "how"),
    [
        ("os._exit(0)", "exit code 0"),
        ("os._exit(3)", "exit code 3"),
        ("ctypes.string_at(0)", "signal SIGSEGV"),
    ],
)
def test_a_function_that_ends_python_is_named(body: str, how: str, tmp_path: Path) -> None:
    found = reason(function(tmp_path, body))
    assert found == messages.ENDS_PYTHON(function="scene() in mine.py", how=how)


def test_a_function_that_never_returns_is_ended(tmp_path: Path) -> None:
    found = reason(function(tmp_path, "while True: pass"), limit=1.0)
    assert messages.NEVER_RETURNS.is_in(found)


@pytest.mark.parametrize("body", ["return seed", "raise ValueError", "raise SystemExit(1)"])
def test_what_a_call_can_tell_is_left_to_it(body: str, tmp_path: Path) -> None:
    assert reason(function(tmp_path, body)) == ""


def test_a_function_is_tried_once(tmp_path: Path) -> None:
    count = tmp_path / "count"
    body = f"os.close(os.open({str(count)!r}, os.O_CREAT | os.O_WRONLY)); os._exit(3)"
    found = reason(function(tmp_path, body), before=count.unlink)
    assert messages.ENDS_PYTHON.is_in(found)
    assert not count.exists()
