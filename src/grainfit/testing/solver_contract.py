# ruff: noqa: D102 (the names of tests say what they test)
"""Contract of solver adapters, as tests to inherit.

Write a test class for a custom solver, in a file that pytest finds::

    from grainfit.testing.solver_contract import SolverContract

    class TestMySolver(SolverContract):
        @pytest.fixture
        def solver(self):
            return MySolver(...)

        @pytest.fixture
        def parameters(self):
            return {"particle.density": 2100.0}

and pytest runs all tests below. Inherit `ProcessSolverContract` when runs are processes.
"""

from __future__ import annotations

import json
import math
import shutil
import threading
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import psutil
import pytest

from grainfit.errors import GrainfitError, RunFailedError
from grainfit.evaluation import Curve, Response, scalars
from grainfit.solvers.base import Solver, Workspace

#: A run must end within this time after it is cancelled, s.
SOON = 5.0
_UNKNOWN = "no_such_parameter"


class SolverContract:
    """Tests of a solver, on which a campaign relies; subclasses define the fixtures.

    Attributes
    ----------
    refuses_unknown_names : bool
        Whether the solver knows its parameters. A custom function may take any.
    """

    refuses_unknown_names = True

    @pytest.fixture
    def solver(self) -> Solver:
        """Return the solver under test; one run should take a few seconds at most."""
        raise NotImplementedError

    @pytest.fixture
    def parameters(self) -> dict[str, float]:
        """Return values of all free parameters with which a run succeeds."""
        raise NotImplementedError

    @pytest.fixture
    def watched(self) -> list[Path]:
        """Folders that belong to the user and must stay as they are."""
        return []

    @pytest.fixture
    def elsewhere(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        """An empty current folder, which must stay empty."""
        folder = tmp_path / "current folder"
        folder.mkdir()
        monkeypatch.chdir(folder)
        return folder

    @pytest.fixture
    def workspaces(self, tmp_path: Path, elsewhere: Path) -> Workspaces:  # noqa: ARG002
        """Return a function that makes a new workspace with every call."""
        return Workspaces(tmp_path / "the user's runs")

    def test_check_finds_nothing_missing_and_leaves_nothing(
        self, solver: Solver, elsewhere: Path
    ) -> None:
        solver.check()

        assert list(elsewhere.iterdir()) == []

    def test_has_a_name_and_a_version(self, solver: Solver, elsewhere: Path) -> None:
        assert solver.name
        assert solver.version() == solver.version()
        assert list(elsewhere.iterdir()) == []

    def test_definition_is_json_and_always_the_same(
        self, solver: Solver, parameters: dict[str, float]
    ) -> None:
        first = json.dumps(
            solver.definition(parameters, 7).to_json(), sort_keys=True, allow_nan=False
        )
        backwards = dict(reversed(parameters.items()))
        again = json.dumps(
            solver.definition(backwards, 7).to_json(), sort_keys=True, allow_nan=False
        )

        assert first == again

    def test_definition_changes_with_every_parameter_and_the_seed(
        self, solver: Solver, parameters: dict[str, float]
    ) -> None:
        wanted = [(parameters, 7), (parameters, 8)]
        wanted += [({**parameters, name: 0.99 * parameters[name]}, 7) for name in parameters]
        definitions = {
            json.dumps(solver.definition(values, seed).to_json(), sort_keys=True)
            for values, seed in wanted
        }

        assert len(definitions) == 2 + len(parameters)

    def test_definition_holds_no_path_of_this_machine(
        self, solver: Solver, parameters: dict[str, float], watched: list[Path], tmp_path: Path
    ) -> None:
        places = [str(path) for path in (*watched, tmp_path, Path.home(), Path.cwd())]
        for text in _texts(solver.definition(parameters, 7).to_json()):
            assert not any(place in text for place in places if place != "/")
            assert not Path(text).is_absolute()

    def test_run_gives_the_responses_that_it_promises(
        self, solver: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        responses = solver.run(parameters, 7, workspaces.new())

        assert responses
        if solver.response_names is not None:
            assert set(responses) == set(solver.response_names)
        # A curve is finite, or it is none.
        assert all(isinstance(found, Response | Curve) for found in responses.values())
        for response in scalars(responses).values():
            assert math.isfinite(response.value)
            assert math.isfinite(response.standard_error)
            assert response.standard_error >= 0

    def test_run_is_repeatable_also_beside_another_one(
        self, solver: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        alone = solver.run(parameters, 7, workspaces.new())
        with ThreadPoolExecutor(2) as pool:
            runs = [pool.submit(solver.run, parameters, s, workspaces.new()) for s in (7, 8)]
            beside = runs[0].result()
            runs[1].result()

        assert beside == alone

    def test_run_writes_in_its_own_folder_only(
        self,
        solver: Solver,
        parameters: dict[str, float],
        workspaces: Workspaces,
        watched: list[Path],
        elsewhere: Path,
    ) -> None:
        before = [_contents(folder) for folder in watched]
        workspace = workspaces.new()
        solver.run(parameters, 7, workspace)

        assert list(elsewhere.iterdir()) == []
        assert list(workspaces.folder.iterdir()) == [workspace.folder]
        assert [_contents(folder) for folder in watched] == before
        if not solver.uses_folder:
            assert list(workspace.folder.iterdir()) == []

    def test_run_leaves_its_parameters_alone(
        self, solver: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        given = dict(parameters)
        solver.definition(given, 7)
        solver.run(given, 7, workspaces.new())

        assert given == parameters

    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
    def test_value_that_is_not_finite_is_refused(
        self,
        solver: Solver,
        parameters: dict[str, float],
        workspaces: Workspaces,
        value: float,
    ) -> None:
        name = next(iter(parameters))
        with pytest.raises(GrainfitError, match=name):
            solver.definition({**parameters, name: value}, 7)
        with pytest.raises(GrainfitError):
            solver.run({**parameters, name: value}, 7, workspaces.new())

    def test_unknown_name_is_refused(
        self, solver: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        wrong = {**parameters, _UNKNOWN: 1.0}
        for act in (solver.definition, partial(solver.run, workspace=workspaces.new())):
            if self.refuses_unknown_names:
                with pytest.raises(GrainfitError, match=_UNKNOWN):
                    act(wrong, 7)
            else:
                assert act(wrong, 7)

    def test_missing_parameter_is_refused(
        self, solver: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        name = next(iter(parameters))
        fewer = {other: value for other, value in parameters.items() if other != name}
        with pytest.raises(GrainfitError):
            solver.run(fewer, 7, workspaces.new())

    def test_run_that_is_cancelled_before_it_starts_does_not_happen(
        self, solver: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        workspace = workspaces.new()
        workspace.cancelled.set()
        with pytest.raises(RunFailedError) as caught:
            solver.run(parameters, 7, workspace)

        assert caught.value.kind == "cancelled"

    def test_folder_that_was_removed_does_not_come_back(
        self, solver: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        if not solver.uses_folder:
            pytest.skip("the solver writes nothing")
        workspace = workspaces.new()
        shutil.rmtree(workspaces.folder)
        with pytest.raises((OSError, RunFailedError)):
            solver.run(parameters, 7, workspace)

        assert not workspaces.folder.exists()


class ProcessSolverContract(SolverContract):
    """Further tests of solvers whose runs are processes: they can be ended."""

    @pytest.fixture
    def endless(self) -> Solver:
        """Return a solver like the one under test whose runs take longer than 10 s."""
        raise NotImplementedError

    def test_run_under_way_ends_soon_after_it_is_cancelled(
        self, endless: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        workspace = workspaces.new()
        told: list[float] = []

        def stop() -> None:
            told.append(time.monotonic())
            workspace.cancelled.set()

        timer = threading.Timer(1.0, stop)
        timer.start()
        try:
            with pytest.raises(RunFailedError) as caught:
                endless.run(parameters, 7, workspace)
        finally:
            timer.cancel()

        assert caught.value.kind == "cancelled"
        assert time.monotonic() - told[0] < SOON
        assert _stay_in(workspace.folder) == []

    def test_run_ends_at_its_time_out(
        self, endless: Solver, parameters: dict[str, float], workspaces: Workspaces
    ) -> None:
        workspace = workspaces.new(timeout=1.0)
        started = time.monotonic()
        with pytest.raises(RunFailedError, match="time-out of 1 s") as caught:
            endless.run(parameters, 7, workspace)

        # Not a fault of the machine: an immediate second try would take as long.
        assert caught.value.kind == "timeout"
        assert 1.0 <= time.monotonic() - started < 1.0 + SOON
        assert _stay_in(workspace.folder) == []


class Workspaces:
    """Make workspaces with separate folders whose names contain blanks and quotes.

    Parameters
    ----------
    folder : Path
        Parent of their folders.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._made = 0

    def new(self, timeout: float | None = 300.0) -> Workspace:
        """Make a workspace with an empty folder."""
        self._made += 1
        folder = self.folder / f'run "{self._made}"'
        folder.mkdir(parents=True)
        return Workspace(folder, timeout)


def _texts(data: Any) -> Iterator[str]:
    if isinstance(data, str):
        yield data
    elif isinstance(data, Mapping):
        for key, value in data.items():
            yield str(key)
            yield from _texts(value)
    elif isinstance(data, (list, tuple)):
        for value in data:
            yield from _texts(value)


def _contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def _stay_in(folder: Path) -> list[int]:
    """Processes that stay active in a folder; helpers of MPI take a moment to notice the end."""
    deadline = time.monotonic() + SOON
    while (found := _processes_in(folder)) and time.monotonic() < deadline:
        time.sleep(0.05)
    return found


def _processes_in(folder: Path) -> list[int]:
    """Processes, other than this one, that still work in a folder."""
    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            if process.cwd() == str(folder):
                found.append(process.pid)
    return found
