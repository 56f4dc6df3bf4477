"""Functions of the user that end Python, crash it, or never return."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.bulk_tests.own_scene import messages
from grainfit.bulk_tests.own_scene.trial import require_return
from grainfit.errors import RunFailedError
from grainfit.options.python_file import PythonFile


def function(folder: Path, body: str) -> PythonFile:
    (folder / "mine.py").write_text(f"import ctypes, os\n\ndef scene(seed):\n    {body}\n")
    return PythonFile(f"{folder / 'mine.py'}:scene")


@pytest.mark.parametrize(
    ("body", "how"),
    [
        ("os._exit(0)", "exit code 0"),
        ("os._exit(3)", "exit code 3"),
        ("ctypes.string_at(0)", "signal SIGSEGV"),
    ],
)
def test_a_function_that_ends_python_is_named(body: str, how: str, tmp_path: Path) -> None:
    with pytest.raises(RunFailedError) as caught:
        require_return(function(tmp_path, body), {"seed": 1})
    assert caught.value.reason == messages.ENDS_PYTHON(function="scene() in mine.py", how=how)


def test_a_function_that_never_returns_is_ended(tmp_path: Path) -> None:
    with pytest.raises(RunFailedError, match=messages.NEVER_RETURNS.pattern):
        require_return(function(tmp_path, "while True: pass"), {"seed": 1}, limit=1.0)


@pytest.mark.parametrize("body", ["return seed", "raise ValueError", "raise SystemExit(1)"])
def test_what_a_call_can_tell_is_left_to_it(body: str, tmp_path: Path) -> None:
    require_return(function(tmp_path, body), {"seed": 1})


def test_a_function_is_tried_once(tmp_path: Path) -> None:
    count = tmp_path / "count"
    tried = function(
        tmp_path,
        f"os.write(os.open({str(count)!r}, os.O_CREAT | os.O_APPEND | os.O_WRONLY), b'x'); os._exit(3)",
    )
    for _ in range(2):
        with pytest.raises(RunFailedError, match=messages.ENDS_PYTHON.pattern):
            require_return(tried, {"seed": 1})
    assert count.read_text() == "x"
