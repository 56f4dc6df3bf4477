"""Run any program as a solver: a folder with input files, and a command to start in it."""

from __future__ import annotations

import os
import shlex
import shutil
import sysconfig
from collections.abc import Collection, Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import Any

from typing_extensions import override

from grainfit.errors import Fault, InputError, RunFailedError, SolverNotFoundError
from grainfit.evaluation import Measured
from grainfit.evaluation.exchange import finite_parameters
from grainfit.files import is_file, log_tail
from grainfit.formatting import variable_name
from grainfit.options.python_file import PythonFile
from grainfit.solvers.base import SeedUse, Solver, Workspace
from grainfit.solvers.own_model import messages
from grainfit.solvers.own_model.evaluation import (
    RESPONSES_NAME,
    evaluation_log,
    measure_with,
    require,
    responses_in,
)
from grainfit.solvers.own_model.mentions import Mentions, read_mentions
from grainfit.solvers.own_model.model_folder import ModelFolder
from grainfit.solvers.own_model.model_input import (
    INCLUDE_NAME,
    JSON_NAME,
    Templates,
    require_distinct,
    write_parameters,
)
from grainfit.solvers.process import messages as process_messages
from grainfit.solvers.process.line_buffering import line_buffering
from grainfit.solvers.process.process import LOG_NAME, recorded_faults, run_process

_TEMPLATE_SUFFIX = ".j2"


class Command(Solver):
    """Solver for custom models: a folder, and a command that simulates in a copy of it.

    For each run the folder's files are copied (see `ModelFolder`), the templates among them are
    filled in, and all values are written to ``parameters.json`` (``{"particle.density": 2100.0,
    ..., "seed": 7}``) and to ``parameters.inc`` (``variable particle_density equal 2100.0``, for
    LAMMPS and LIGGGHTS to include). Then the command is started in the copy, without a shell. The
    responses are read from a JSON file that it wrote, or returned by a Python function that
    evaluates the folder in a separate process.

    Templates and the command's arguments are Jinja2: ``{{ particle.density }}``, ``{{ seed }}``,
    ``{{ parameters["any name"] }}``, and ``{{ prime_seed }}``
    (`grainfit.solvers.own_model.prime_seed`).

    Parameters
    ----------
    folder : path
        Folder of the model.
    command : sequence of str
        Program and arguments. A program without a slash is searched on the PATH, next to the
        running Python and in the folder; one with a slash in the folder.
    parameters : mapping of str to float, optional
        Fixed values, passed to the model with the free parameters.
    templates : sequence of str
        File name patterns. ``deck.in.j2`` becomes ``deck.in``; other names are kept.
    responses : str
        JSON file that the command writes: ``{"name": value}`` or
        ``{"name": {"value": ..., "standard_error": ...}}``.
    evaluate : str or sequence of str, optional
        ``"evaluate.py:measure"``, used instead of ``responses``: a file, in the folder unless the
        path is absolute, and a function in it, ``measure(folder: Path) -> dict`` of response
        name to a number, a pair of value and standard error, or a `Response`. The responses of
        several functions are joined.
    response_names : sequence of str, optional
        Responses that every run must give.
    name : str
        Display name.

    Raises
    ------
    InputError
        The command is empty, program or responses are outside the folder, or the evaluation names
        no function in a file.
    """

    def __init__(
        self,
        folder: str | Path,
        command: Sequence[str],
        *,
        parameters: Mapping[str, float] | None = None,
        templates: Sequence[str] = (f"*{_TEMPLATE_SUFFIX}",),
        responses: str = RESPONSES_NAME,
        evaluate: str | Sequence[str] | None = None,
        response_names: Sequence[str] | None = None,
        name: str = "command",
    ) -> None:
        if isinstance(command, str) or not command or not all(command):
            raise InputError(messages.NO_COMMAND.fault("command", command=command))
        if not Path(command[0]).is_absolute() and ".." in Path(command[0]).parts:
            # In the run folder the same relative path would be another file.
            raise InputError(messages.PROGRAM_OUTSIDE.fault("command", program=command[0]))
        if Path(responses).is_absolute() or ".." in Path(responses).parts:
            raise InputError(messages.RESPONSES_OUTSIDE.fault("responses", file=responses))
        self.name = name
        self._command = tuple(command)
        self._fixed = finite_parameters(parameters or {})
        self._templates = tuple(templates)
        self._responses = responses
        self._references = (evaluate,) if isinstance(evaluate, str) else tuple(evaluate or ())
        self._response_names = None if response_names is None else tuple(response_names)
        self._model = ModelFolder(Path(folder).absolute(), self._is_overwritten)
        self._functions()

    @property
    @override
    def response_names(self) -> tuple[str, ...] | None:
        return self._response_names

    @override
    def check(self) -> None:
        """Raise an error if no run can succeed; no code of the user is executed.

        Raises
        ------
        InputError
            The folder or a file is missing or cannot be copied, a template has a syntax error, or
            the evaluation's file does not define the function.
        SolverNotFoundError
            The program is not found.
        """
        self._model.check()
        filler = self._filler()
        for number, argument in enumerate(self._command[1:], start=1):
            filler.check_text(argument, f"command[{number}]")
        for name in self._template_files():
            filler.check(name)
        self._require_matches()
        for function in self._functions():
            function.check()
        self._require_program()

    @override
    def executes(self) -> tuple[str, ...]:
        where = f"in a copy of {self._model.path.resolve()}"
        program = _on_path(self._command[0]) or self._command[0]
        lines = [f"{shlex.join([program, *self._command[1:]])}   ({where})"]
        for function in self._functions():
            path = function.path.resolve()
            lines.append(f"{path}:{function.function}   ({where}, in a Python process)")
        return tuple(lines)

    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the values of all parameters, free and fixed.

        Raises
        ------
        InputError
            A value is not finite, nothing in the model mentions a free parameter, or a template
            reads a name that is no parameter.
        """
        values = self._values(parameters)
        require_distinct(values)
        undefined = [found.fault for found in self._mentions.undefined(values)]
        meant = self._meant(values)
        unmentioned = self._unmentioned([name for name in parameters if name not in meant])
        if faults := undefined + unmentioned:
            raise InputError(faults, str(self._model.path))
        return values

    @override
    def depends_on(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return the parameters that the model mentions; all if it cannot be read.

        A name that is misspelt in a template counts: the check refuses it, and says what is meant.
        """
        try:
            meant = self._meant([*self._fixed, *names])
            return tuple(name for name in names if name in meant or name in self._mentions)
        except InputError:
            # `check` says why.
            return tuple(names)

    @property
    @override
    def seed_use(self) -> SeedUse:
        try:
            return "read" if self._mentions.has_seed else "unread"
        except InputError:
            # `check` says why.
            return "read"

    @override
    def raw_output(self, folder: Path) -> Sequence[Path]:
        """Return the files that the command wrote, without logs, which state times."""
        model = {name.removesuffix(_TEMPLATE_SUFFIX) for name in self._model.files()}
        written = {
            str(path.relative_to(folder)): path for path in folder.rglob("*") if is_file(path)
        }
        return [
            path
            for name, path in sorted(written.items())
            if name not in model
            and not self._is_overwritten(name)
            and not self._is_template(name)
            and not path.name.startswith((".", "log."))
            and path.suffix not in (".log", ".json", ".png")
        ]

    def model(self) -> Mapping[str, Any]:
        """Return the command and the contents of all files."""
        return {
            "solver": self.name,
            "command": list(self._command),
            "templates": list(self._templates),
            "responses": None if self._references else self._responses,
            **self._contents,
        }

    @override
    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> Mapping[str, Measured]:
        if workspace.cancelled.is_set():
            raise RunFailedError(process_messages.STOPPED(), kind="cancelled")
        values = self._values(parameters)
        if faults := self._unmentioned(parameters):
            raise InputError(faults, str(self._model.path))
        with recorded_faults(workspace):
            command = self._prepare(values, int(seed), workspace)
            seconds = run_process(command, workspace, line_buffering())
            if not self._references:
                return self._read_responses(workspace.folder)
            return measure_with(
                self._functions(), self._model.path, workspace, seconds, self._response_names
            )

    def _values(self, parameters: Mapping[str, float]) -> dict[str, float]:
        return {**self._fixed, **finite_parameters(parameters)}

    def _functions(self) -> list[PythonFile]:
        """Return the functions that evaluate a run; none where the command writes responses."""
        return [PythonFile(reference, self._model.path) for reference in self._references]

    def _filler(self) -> Templates:
        return Templates(self._model)

    # --- what the model is -------------------------------------------------------------------

    def _is_template(self, name: str) -> bool:
        return any(fnmatchcase(name, pattern) for pattern in self._templates)

    def _template_files(self) -> list[str]:
        return [name for name in self._model.files() if self._is_template(name)]

    def _is_overwritten(self, name: str) -> bool:
        """Return True for files (from a run of the model by hand) that each run overwrites."""
        # Also a model without an evaluation may have the log of one.
        logs = {evaluation_log(number) for number in range(1, max(1, len(self._references)) + 1)}
        if name in {JSON_NAME, INCLUDE_NAME, LOG_NAME, *logs}:
            return True
        if name == (RESPONSES_NAME if self._references else self._responses):
            return True
        template = name + _TEMPLATE_SUFFIX
        return self._is_template(template) and is_file(self._model.path / template)

    @cached_property
    def _contents(self) -> dict[str, Any]:
        """Contents of the model when first read."""
        return self._contents_now()

    def _contents_now(self) -> dict[str, Any]:
        identities = [function.identity() for function in self._functions()]
        # A single function is not in a list, as in the runs of earlier versions.
        evaluate = identities if len(identities) > 1 else next(iter(identities), None)
        return {"files": self._model.hashes(), "evaluate": evaluate}

    @cached_property
    def _mentions(self) -> Mentions:
        """Names of parameters in the model when first read."""
        folder = self._model.path
        evaluations = {os.path.relpath(function.path, folder) for function in self._functions()}
        return read_mentions(self._model, self._command, self._template_files(), evaluations)

    # --- checks ------------------------------------------------------------------------------

    def _require_matches(self) -> None:
        default = f"*{_TEMPLATE_SUFFIX}"
        faults = [
            messages.NO_TEMPLATE.fault("templates", pattern=pattern)
            for pattern in self._templates
            if pattern != default
            and not any(fnmatchcase(name, pattern) for name in self._model.files())
        ]
        if faults:
            raise InputError(faults, str(self._model.path))

    def _meant(self, names: Collection[str]) -> set[str]:
        """Return the parameters that are meant by names in templates that are none."""
        return {name for found in self._mentions.undefined(names) for name in found.meant}

    def _unmentioned(self, names: Iterable[str]) -> list[Fault]:
        """Return a fault for each parameter that the model does not use: it would fit noise."""
        return [
            messages.UNMENTIONED.fault(
                name,
                name=name,
                include=INCLUDE_NAME,
                variable=variable_name(name),
                json=JSON_NAME,
            )
            for name in names
            if name not in self._mentions
        ]

    def _require_program(self) -> None:
        program = self._command[0]
        if _on_path(program):
            return
        path = self._model.path / program
        template = Path(f"{path}{_TEMPLATE_SUFFIX}")
        found = next((file for file in (path, template) if is_file(file)), None)
        if found is None:
            raise SolverNotFoundError(messages.NO_PROGRAM(program=program, folder=self._model.path))
        if not os.access(found, os.X_OK):
            fault = messages.NOT_EXECUTABLE.fault(found.name, path=shlex.quote(str(found)))
            raise InputError(fault, str(self._model.path))

    # --- a run -------------------------------------------------------------------------------

    def _prepare(self, values: Mapping[str, float], seed: int, workspace: Workspace) -> list[str]:
        """Prepare the run folder; return the command."""
        require_distinct(values)
        if self._contents_now() != self._contents:
            reason = messages.CHANGED_MODEL(folder=self._model.path)
            raise RunFailedError(reason, kind="machine")
        folder = workspace.folder
        self._model.copy(folder)
        files = {name: name.removesuffix(_TEMPLATE_SUFFIX) for name in self._template_files()}
        texts = {
            f"command[{number}]": argument
            for number, argument in enumerate(self._command[1:], start=1)
        }
        arguments = self._filler().fill(files, texts, values, seed, workspace)
        for name, target in files.items():
            shutil.copymode(self._model.path / name, folder / target)
        write_parameters(folder, values, seed)
        return [_on_path(self._command[0]) or str(folder / self._command[0]), *arguments]

    def _read_responses(self, folder: Path) -> Mapping[str, Measured]:
        known = {name.removesuffix(_TEMPLATE_SUFFIX) for name in self._model.files()}
        found = responses_in(
            folder / self._responses,
            self._responses,
            self._response_names,
            known | {JSON_NAME, INCLUDE_NAME},
        )
        require(found, self._response_names, self._responses, log_tail(folder / LOG_NAME))
        return found


def _on_path(program: str) -> str | None:
    """Find a program on the PATH, or next to the running Python, where pip installs programs."""
    if "/" in program:
        return shutil.which(program) if Path(program).is_absolute() else None
    return shutil.which(program) or shutil.which(program, path=sysconfig.get_path("scripts"))
