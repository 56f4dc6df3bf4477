"""Pass parameter values and a seed to a custom model, by templates and files to include."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import jinja2
import jinja2.nodes

from grainfit.errors import Fault, InputError, RunFailedError
from grainfit.files import LARGEST_TEMPLATE
from grainfit.formatting import variable_name
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model import fill_templates, messages
from grainfit.solvers.own_model.fill_templates import ALL_VALUES, fault_of, fill, open_environment
from grainfit.solvers.own_model.model_folder import ModelFolder
from grainfit.solvers.own_model.prime_seed import PRIME_SEEDS, prime_seeds
from grainfit.solvers.own_model.template_names import TemplateNames, names_in
from grainfit.solvers.process.process import run_process

#: File for programs that read JSON: values by dotted name, and the seeds.
JSON_NAME = "parameters.json"
#: File for LAMMPS and LIGGGHTS to ``include``: ``variable NAME equal VALUE`` in each line.
INCLUDE_NAME = "parameters.inc"

_SEED = "seed"
#: Names of the seeds of a run.
SEEDS = (_SEED, *PRIME_SEEDS)
#: Names in templates that no parameter can have.
RESERVED = (*SEEDS, ALL_VALUES)

#: Limits of templates. They take milliseconds and a few MB unless there is a fault in a loop.
_SECONDS = 60.0
_BYTES = 2 * 2**30
#: Parts of templates that only insert values, and the longest template that is searched for others.
_SIMPLE = frozenset(
    getattr(jinja2.nodes, name)
    for name in ("Output", "TemplateData", "Name", "Getattr", "Getitem", "Const")
)
_LONGEST_SIMPLE = 2**20
#: Files of the process in the run folder. A model's own files are never hidden.
_REQUEST, _ANSWER, _LOG = ".templates.json", ".filled.json", ".templates.log"


def write_parameters(folder: Path, values: Mapping[str, float], seed: int) -> None:
    """Write the values and the seed as files for a model to read."""
    seeds = _seeds(seed)
    (folder / JSON_NAME).write_text(
        json.dumps({**values, **seeds}, indent=1) + "\n", encoding="utf-8"
    )
    lines = [f"variable {variable_name(name)} equal {value!r}" for name, value in values.items()]
    lines += [f"variable {name} equal {value}" for name, value in seeds.items()]
    (folder / INCLUDE_NAME).write_text("\n".join(lines) + "\n", encoding="utf-8")


def _seeds(seed: int) -> dict[str, int]:
    return {_SEED: seed, **prime_seeds(seed)}


def require_distinct(values: Mapping[str, float]) -> None:
    """Raise `InputError` unless templates and solvers can distinguish all names."""
    faults = []
    seen: dict[str, str] = {}
    for name in values:
        root = name.split(".")[0]
        if root in RESERVED:
            faults.append(messages.RESERVED_NAME.fault(name, root=root))
        elif variable_name(name) in RESERVED:
            variable = variable_name(name)
            faults.append(messages.RESERVED_VARIABLE.fault(name, variable=variable))
        other = seen.setdefault(variable_name(name), name)
        if other != name:
            faults.append(messages.SAME_VARIABLE.fault(name, other=other))
        if any(longer.startswith(f"{name}.") for longer in values):
            faults.append(messages.BEGINS_ANOTHER.fault(name))
    InputError.raise_for(faults)


class Templates:
    """Jinja2 templates of a model, in which an undefined name is an error.

    Parameters
    ----------
    model : ModelFolder
        The model.
    """

    def __init__(self, model: ModelFolder) -> None:
        self._model = model
        self._read = partial(model.read, largest=LARGEST_TEMPLATE)
        self._environment = open_environment(self._read)

    def check(self, name: str) -> None:
        """Check that a file is a valid template, without filling it in.

        Raises
        ------
        InputError
            The file is not a text, or has a syntax error; the message gives the line.
        """
        self._checked(name, lambda: self._read(name).decode("utf-8"))

    def check_text(self, text: str, where: str) -> None:
        """Raise `InputError` unless a text is a valid template."""
        self._checked(where, lambda: text)

    def names(self, text: bytes) -> TemplateNames | None:
        """Return the names in a template; None if it is not valid, as `check` says."""
        try:
            return names_in(self._environment.parse(text.decode("utf-8")))
        except Exception:
            return None

    @property
    def known_names(self) -> frozenset[str]:
        """Names that Jinja2 gives every template, such as ``range``."""
        return frozenset(self._environment.globals)

    def _checked(self, name: str, read: Callable[[], str]) -> None:
        try:
            self._parse(read(), name)
        except InputError:
            raise
        except Exception as error:
            raise InputError(Fault(*fault_of(error, name)), str(self._model.path)) from error

    def _parse(self, text: str, name: str) -> None:
        """Parse only: Jinja2 evaluates constants when it compiles; 9**(9**9) takes forever."""
        tree = self._environment.parse(text, name)
        known: Mapping[str, Any]
        for kind, known in (
            (jinja2.nodes.Filter, self._environment.filters),
            (jinja2.nodes.Test, self._environment.tests),
        ):
            for node in tree.find_all(kind):
                if node.name not in known:
                    named = kind.__name__.lower()
                    raise jinja2.TemplateAssertionError(
                        f"No {named} named {node.name!r}.", node.lineno, name
                    )

    def fill(
        self,
        files: Mapping[str, str],
        texts: Mapping[str, str],
        values: Mapping[str, float],
        seed: int,
        workspace: Workspace,
    ) -> list[str]:
        """Fill in files of a run folder, and texts.

        Templates that only insert values are filled in at once. All others, which can contain
        loops, get a process with limits of time and memory.

        Parameters
        ----------
        files : mapping of str to str
            Name of each filled-in file in the run folder, by the name of its template in the model.
        texts : mapping of str to str
            Texts by their place in the calibration file.
        values : mapping of str to float
            Values of all parameters.
        seed : int
            Insertion seed.
        workspace : Workspace
            The run folder, a copy of the model, and the limits of the run.

        Returns
        -------
        list of str
            The texts, filled in.

        Raises
        ------
        InputError
            A template is not valid, names a parameter that has no value, or needs too much memory.
        RunFailedError
            It takes too long, or the run is cancelled.
        """
        require_distinct(values)
        request = {
            "model": str(self._model.path),
            "files": dict(files),
            "texts": dict(texts),
            "values": dict(values),
            "seeds": _seeds(seed),
        }
        contents = [*map(self._read, files), *(os.fsencode(text) for text in texts.values())]
        if all(map(self._only_inserts_values, contents)):
            found = fill(request, workspace.folder, lambda _where: None)
        else:
            found = self._fill_in_process(request, workspace)
        if "fault" in found:
            raise InputError(Fault(*found["fault"]), str(self._model.path))
        return list(found["texts"])

    def _only_inserts_values(self, contents: bytes) -> bool:
        """Return True if the time to fill in a template is limited by its length."""
        if len(contents) > _LONGEST_SIMPLE:
            return False
        try:
            tree = self._environment.parse(contents.decode("utf-8"))
        except Exception:
            return False
        return all(type(node) in _SIMPLE for node in tree.find_all(jinja2.nodes.Node))

    def _fill_in_process(self, request: Mapping[str, Any], workspace: Workspace) -> dict[str, Any]:
        folder = workspace.folder
        program = [sys.executable, "-P", fill_templates.__file__]
        timeout = min(workspace.timeout or _SECONDS, _SECONDS)
        try:
            (folder / _REQUEST).write_text(json.dumps(request), encoding="utf-8")
            run_process(
                [*program, _REQUEST, _ANSWER, str(_BYTES)],
                replace(workspace, timeout=timeout),
                log_name=_LOG,
            )
            found: dict[str, Any] = json.loads((folder / _ANSWER).read_text(encoding="utf-8"))
        except RunFailedError as error:
            raise self._error_of(error, timeout) from error
        finally:
            for name in (_REQUEST, _ANSWER, _LOG):
                with suppress(OSError):
                    (folder / name).unlink()
        return found

    def _error_of(self, error: RunFailedError, timeout: float) -> Exception:
        """Return the error of a process that filled in no templates."""
        if error.kind in ("cancelled", "machine"):
            return error
        *_, where = error.log_tail.splitlines() or ["templates"]
        if error.kind == "timeout":
            reason = messages.FILLING_TOO_LONG(where=where, timeout=timeout)
            return RunFailedError(reason, kind="timeout")
        fault = messages.NOT_FILLED_IN.fault("templates", reason=error.reason)
        return InputError(fault, str(self._model.path))
