"""Files that are too large or may not be read are refused, before anything of them is read."""

from __future__ import annotations

import os
import re
import threading
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from grainfit.calibration_file.build import build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.errors import InputError, NotMeasurableError, StoreError
from grainfit.files import (
    LARGEST_PYTHON_FILE,
    LARGEST_RUN_OUTPUT,
    LARGEST_TABLE,
    TooLargeError,
    read_within,
)
from grainfit.measurement.particles import read_dump
from grainfit.options import messages as of_options
from grainfit.result import Result
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.stl import read_stl
from grainfit.solvers.own_model import messages, model_folder
from grainfit.solvers.own_model.command import Command
from grainfit.solvers.own_model.model_folder import ModelFolder
from grainfit.solvers.own_model.model_input import Templates
from grainfit.table_files.table import read_table

FILE = """
name = "sand"

[parameters]
friction = { min = 0.1, max = 0.9 }

[[test]]
%s
targets.angle = { value = 36, uncertainty = 0.4 }
"""
COMMAND = 'type = "command"\nfolder = "%s"\ncommand = ["true", "{{ friction }}"]'


@pytest.fixture
def little_memory() -> Iterator[None]:
    tracemalloc.start()
    yield
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 20_000_000


def problems_of(folder: Path, test: str) -> str:
    """The faults that `grainfit check` shows."""
    file = folder / "calibration.toml"
    file.write_text(FILE % test)
    try:
        return "\n".join(describe_plan(build_calibration(load_calibration_file(file))).problems)
    except InputError as error:
        return str(error)


def sparse(path: Path, size: int) -> Path:
    with path.open("wb") as file:
        file.truncate(size)
    return path


def close(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Take away the right to list and to enter a folder, from root too."""
    if os.geteuid():
        folder.chmod(0)
        return

    def guarded(act: Callable[..., Any], closed: Callable[[Path], bool]) -> Callable[..., Any]:
        def guard(path: Any = ".", *arguments: Any, **keywords: Any) -> Any:
            if not isinstance(path, int) and closed(Path(os.fsdecode(path))):
                raise PermissionError(13, "Permission denied", os.fsdecode(path))
            return act(path, *arguments, **keywords)

        return guard

    for name in ("stat", "lstat"):
        inside = guarded(getattr(os, name), lambda path: folder in path.parents)
        monkeypatch.setattr(os, name, inside)
    listed = guarded(os.scandir, lambda path: folder in (path, *path.parents))
    monkeypatch.setattr(os, "scandir", listed)


def test_check_names_a_subfolder_that_may_not_be_entered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed = tmp_path / "model" / "results"
    closed.mkdir(parents=True)
    close(closed, monkeypatch)

    problem = problems_of(tmp_path, COMMAND % "model")

    closed.chmod(0o755)
    assert re.search(f"results: {messages.NOT_LISTED.matching(error='Permission denied')}", problem)


def test_check_names_a_model_in_a_folder_that_may_not_be_entered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed = tmp_path / "private"
    (closed / "model").mkdir(parents=True)
    close(closed, monkeypatch)

    problem = problems_of(tmp_path, COMMAND % "private/model")
    function = problems_of(tmp_path, 'type = "python"\nfunction = "private/model.py:f"')

    closed.chmod(0o755)
    assert of_options.NOT_THERE.is_in(problem, kind="folder")
    assert of_options.NOT_THERE.is_in(function, kind="file")


@pytest.mark.usefixtures("little_memory")
def test_the_root_of_all_files_is_no_model(tmp_path: Path) -> None:
    assert re.search(f"folder: {messages.ALL_FILES.pattern}", problems_of(tmp_path, COMMAND % "/"))


def test_a_model_with_too_many_folders_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model_folder, "MOST_MODEL_FILES", 3)
    (tmp_path / "a/b/c/d").mkdir(parents=True)
    with pytest.raises(InputError, match=messages.TOO_MANY_FILES.matching(most=3)):
        Command(tmp_path, ["true"]).check()


@pytest.mark.usefixtures("little_memory")
def test_nothing_of_a_model_that_is_too_large_is_read(tmp_path: Path) -> None:
    sparse(tmp_path / "dump", 1_000_000_000)
    model = Command(tmp_path, ["true"])

    assert model.depends_on(["friction"]) == ("friction",)
    with pytest.raises(InputError, match="holds 1000 MB"):
        model.model()


@pytest.mark.usefixtures("little_memory")
def test_a_python_file_that_is_too_large_is_refused(tmp_path: Path) -> None:
    code = "def f(p, seed): ...\n" + "x = 1\n" * (LARGEST_PYTHON_FILE // 6)
    (tmp_path / "model.py").write_text(code)

    problem = problems_of(tmp_path, 'type = "python"\nfunction = "model.py:f"')

    assert of_options.TOO_LARGE_TO_READ.is_in(
        problem, reason="it has 1.00002 MB, and at most 1 MB are read"
    )
    assert "not valid Python" not in problem


@pytest.mark.usefixtures("little_memory")
def test_a_table_that_is_too_large_is_refused(tmp_path: Path) -> None:
    sparse(tmp_path / "runs.csv", 1_000_000_000)

    problem = problems_of(tmp_path, 'type = "table"\nfile = "runs.csv"')

    assert "cannot be read: it has 1000 MB, and at most 20 MB are read." in problem


@pytest.mark.parametrize(
    ("read", "error"),
    [
        (read_table, InputError),
        (read_stl, InputError),
        (read_dump, NotMeasurableError),
        (Result.from_json, StoreError),
        (lambda path: Templates(ModelFolder(path.parent, ())).check(path.name), InputError),
    ],
)
@pytest.mark.usefixtures("little_memory")
def test_no_file_is_read_beyond_its_limit(
    tmp_path: Path, read: Callable[[Path], object], error: type[Exception]
) -> None:
    with pytest.raises(error, match="it has 20000 MB, and at most"):
        read(sparse(tmp_path / "file", 20_000_000_000))


@pytest.mark.usefixtures("little_memory")
def test_no_output_of_a_run_is_read_beyond_its_limit(tmp_path: Path) -> None:
    sparse(tmp_path / "series_flow.csv", 20_000_000_000)
    with pytest.raises(NotMeasurableError, match="it has 20000 MB, and at most 500 MB"):
        RunOutput(tmp_path).series("flow")
    sparse(tmp_path / "stages.csv", 20_000_000_000)
    with pytest.raises(NotMeasurableError, match="it has 20000 MB, and at most 20 MB"):
        _ = RunOutput(tmp_path).stages


def test_a_file_that_grows_is_read_up_to_its_limit() -> None:
    endless = Path("/dev/zero")
    if not endless.exists():
        pytest.skip("there is no /dev/zero")
    with pytest.raises(TooLargeError, match="it is too long, and at most 20 MB are read"):
        read_within(endless, LARGEST_TABLE, waiting=True)


@pytest.mark.usefixtures("little_memory")
def test_a_small_file_takes_little_memory_whatever_its_limit(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_within(path, LARGEST_RUN_OUTPUT) == b"12345"


def test_a_pipe_that_the_user_names_is_read_to_its_end(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    content = b"runs" * 1_000_000
    writer = threading.Thread(target=lambda: pipe.write_bytes(content), daemon=True)
    writer.start()
    assert read_within(pipe, LARGEST_TABLE, waiting=True) == content
    writer.join(timeout=10)


def test_nobody_waits_for_a_pipe_in_place_of_a_file(tmp_path: Path) -> None:
    pipe = tmp_path / "responses.json"
    os.mkfifo(pipe)
    with pytest.raises(OSError, match="pipe"):
        read_within(pipe, LARGEST_TABLE)


def test_a_file_of_the_largest_size_is_read(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_within(path, 5) == b"12345"
    with pytest.raises(TooLargeError):
        read_within(path, 4)
