"""Commands of grainfit in the process of the tests, where each would take seconds to start."""

from __future__ import annotations

import io
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from subprocess import CompletedProcess
from unittest.mock import patch

import pytest

from grainfit.cli.interruption import interruption
from grainfit.cli.main import main


def grainfit_here(folder: Path, *arguments: str | Path) -> CompletedProcess[str]:
    """Run a command in a folder, with what it prints and its exit code."""
    words = ["grainfit", *map(str, arguments)]
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2))
    with (
        chdir(folder),
        redirect_stdout(out),
        redirect_stderr(err),
        patch.object(sys, "argv", words),
        # Signals and collections of garbage stay those of the tests.
        patch.object(interruption, "listen"),
        patch.object(interruption, "exit_at_once"),
        patch("gc.freeze"),
        pytest.raises(SystemExit) as stop,
    ):
        main()
    printed = (stream.buffer.getvalue().decode("utf-8") for stream in (out, err))
    return CompletedProcess(words, int(stop.value.code or 0), *printed)
