"""Pass parameter values and a seed to a custom model, by templates and files to include."""

from __future__ import annotations

import json
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeVar

import jinja2
import jinja2.nodes
from jinja2.sandbox import SandboxedEnvironment

from grainfit.errors import Fault, InputError
from grainfit.formatting import variable_name
from grainfit.solvers.own_model.prime_seed import PRIME_SEEDS, prime_seeds

#: File for programs that read JSON: values by dotted name, and the seeds.
JSON_NAME = "parameters.json"
#: File for LAMMPS and LIGGGHTS to ``include``: ``variable NAME equal VALUE`` in each line.
INCLUDE_NAME = "parameters.inc"

_Result = TypeVar("_Result")
_SEED = "seed"
_ALL = "parameters"
_RESERVED = (_SEED, *PRIME_SEEDS, _ALL)


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


def template_context(values: Mapping[str, float], seed: int) -> dict[str, Any]:
    """Return the context of templates: ``particle.density``, ``seed``, ``parameters["x"]``.

    Raises
    ------
    InputError
        A template or a solver cannot distinguish two names, or a name is reserved.
    """
    require_distinct(values)
    root = SimpleNamespace()
    for name, value in values.items():
        *sections, key = name.split(".")
        table = root
        for section in sections:
            table = vars(table).setdefault(section, SimpleNamespace())
        vars(table)[key] = value
    return {**vars(root), _ALL: dict(values), **_seeds(seed)}


def require_distinct(values: Mapping[str, float]) -> None:
    """Raise `InputError` unless templates and solvers can distinguish all names."""
    faults = []
    seen: dict[str, str] = {}
    for name in values:
        root = name.split(".")[0]
        if root in _RESERVED:
            faults.append(Fault(name, f"{root!r} is reserved.", "Give it another name."))
        elif variable_name(name) in _RESERVED:
            words = f"is the solver variable {variable_name(name)}, which is reserved."
            faults.append(Fault(name, words, "Give it another name."))
        other = seen.setdefault(variable_name(name), name)
        if other != name:
            faults.append(
                Fault(name, f"is the same solver variable as {other}.", "Rename one of them.")
            )
        if any(longer.startswith(f"{name}.") for longer in values):
            faults.append(Fault(name, "is the beginning of another name too.", "Rename it."))
    if faults:
        raise InputError(faults)


class Templates:
    """Jinja2 templates of a model, in which an undefined name is an error.

    Parameters
    ----------
    read : callable
        Returns the contents of a file of the model by name.
    source : str
        The model's folder, for messages.
    """

    def __init__(self, read: Callable[[str], bytes], source: str) -> None:
        self._source = source
        self._read = read

        def load(name: str) -> str | None:
            try:
                return read(name).decode("utf-8")
            except InputError:
                return None

        # A template may come from somebody else; it must only format values.
        self._environment = SandboxedEnvironment(
            undefined=jinja2.StrictUndefined,
            keep_trailing_newline=True,
            loader=jinja2.FunctionLoader(load),
        )

    def check(self, name: str) -> None:
        """Check that a file is a valid template, without filling it in.

        Raises
        ------
        InputError
            The file is not a text, or has a syntax error; the message gives the line.
        """
        self._guarded(name, lambda: self._parse(self._read(name).decode("utf-8"), name))

    def check_text(self, text: str, where: str) -> None:
        """Raise `InputError` unless a text is a valid template."""
        self._guarded(where, lambda: self._parse(text, where))

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
                    word = kind.__name__.lower()
                    raise jinja2.TemplateAssertionError(
                        f"No {word} named {node.name!r}.", node.lineno, name
                    )

    def fill(self, name: str, context: Mapping[str, Any]) -> str:
        """Fill in a file of the model.

        Raises
        ------
        InputError
            The template is not valid, or names a parameter that has no value.
        """
        return self._guarded(name, lambda: self._environment.get_template(name).render(context))

    def fill_text(self, text: str, where: str, context: Mapping[str, Any]) -> str:
        """Fill in a text; see `fill`."""
        return self._guarded(where, lambda: self._environment.from_string(text).render(context))

    def _guarded(self, name: str, act: Callable[[], _Result]) -> _Result:
        try:
            return act()
        except jinja2.TemplateSyntaxError as error:
            where = error.name or name
            fault = Fault(f"{where}, line {error.lineno}", f"is not a valid template: {error}.")
        except jinja2.TemplateNotFound as error:
            fault = Fault(name, f"there is no template {error.name!r} in the folder.")
        except UnicodeDecodeError:
            fault = Fault(name, "is not a text in UTF-8.", "Only texts can be templates.")
        # An expression in a template can raise any exception.
        except Exception as error:
            fault = Fault(f"{name}{_line(error)}", f"cannot be filled in: {error}.")
        raise InputError(fault, self._source)


def _line(error: Exception) -> str:
    """Return the line of the template in which an error occurred, if it is known."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == "<template>"]
    return f", line {lines[-1]}" if lines else ""
