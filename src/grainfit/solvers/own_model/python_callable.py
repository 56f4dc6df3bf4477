"""Run a Python function as a solver."""

from __future__ import annotations

import ast
import dis
import functools
import hashlib
import inspect
import json
import sys
import textwrap
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from tokenize import TokenError
from types import CodeType, FunctionType, MethodType
from typing import Any

import numpy as np
from typing_extensions import override

from grainfit.errors import InputError, RunFailedError, error_in_words
from grainfit.evaluation import Measured
from grainfit.evaluation.exchange import finite_parameters, read_responses
from grainfit.options.python_file import PythonFile
from grainfit.solvers.base import SeedUse, Solver, Workspace
from grainfit.solvers.own_model import messages
from grainfit.solvers.process import messages as process_messages
from grainfit.solvers.process.faults import machine_error

Function = Callable[..., Mapping[str, Any]]

_TRACEBACK_LINES = 20


class PythonCallable(Solver):
    """Solver that calls a Python function in this process, possibly from several threads.

    The function cannot be stopped during a call, neither by cancelling nor by a time-out. Use a
    `Command` for simulations that take long or may crash.

    Parameters
    ----------
    function : callable
        ``function(parameters: dict[str, float], seed: int) -> dict``: responses by name, each a
        number, a pair of value and standard error, or a `Response`. A function of the parameters
        alone, ``function(parameters)``, is deterministic.
    response_names : sequence of str, optional
        Responses that every run must give.
    name : str
        Display name.
    identity : str, optional
        Identity of the function, such as ``"funnel model 3"``: runs of equal identity, parameters
        and seed are the same run and are not repeated. By default it consists of the module, the
        qualified name, and a hash of the source code; without source (an interactive session), of
        the byte code; without either, the name alone. It includes the plain data that the function
        holds: enclosing variables, default arguments, arguments of a `functools.partial`, and
        attributes of the object that it is or is a method of, if they are numbers, strings, None,
        NumPy arrays, or lists, tuples, dicts and sets of these. A function that appends to such a
        list therefore changes its identity; variables that its source declares ``nonlocal`` are
        left out. Globals, other functions and other objects are not included: give another
        identity when they change.

    Raises
    ------
    InputError
        The function cannot be called.
    """

    uses_folder = False

    def __init__(
        self,
        function: Function,
        response_names: Sequence[str] | None = None,
        name: str = "python",
        identity: str | None = None,
    ) -> None:
        if not callable(function):
            raise InputError(messages.NO_FUNCTION.fault("simulate", function=function))
        self.name = name
        self._function = function
        self._response_names = None if response_names is None else tuple(response_names)
        self._identity = identity

    @classmethod
    def from_file(
        cls,
        reference: str,
        response_names: Sequence[str] | None = None,
        name: str = "python",
        folder: Path | None = None,
    ) -> PythonCallable:
        """Create a solver from a function in a file, ``"path/to/file.py:function"``.

        The file is executed when the first run starts, not before. The identity of runs depends on
        the whole file.

        Raises
        ------
        InputError
            The reference has another form.
        """
        return cls(PythonFile(reference, folder), response_names, name)

    @property
    @override
    def response_names(self) -> tuple[str, ...] | None:
        return self._response_names

    @override
    def check(self) -> None:
        if isinstance(self._function, PythonFile):
            self._function.check()

    @override
    def executes(self) -> tuple[str, ...]:
        if not isinstance(self._function, PythonFile):
            return ()
        path = self._function.path.resolve()
        return (f"{path}:{self._function.function}   (within grainfit itself)",)

    def model(self) -> Mapping[str, Any]:
        """Return the function's identity."""
        return {"solver": self.name, "function": self._function_identity}

    def run_parameters(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters; check that they are finite."""
        return finite_parameters(parameters)

    @functools.cached_property
    def _function_identity(self) -> Any:
        if self._identity is not None:
            return self._identity
        if isinstance(self._function, PythonFile):
            return self._function.identity()
        return _identity(self._function)

    @property
    @override
    def seed_use(self) -> SeedUse:
        return self._seed_use

    @functools.cached_property
    def _seed_use(self) -> SeedUse:
        match self._function:
            case PythonFile() as file:
                code = file.code()
                return "read" if code is None else _seed_use(code, 0)
            case FunctionType(__code__=code):
                # That of a decorated function is the code of what it was replaced with.
                return _seed_use(code, 0)
            case MethodType(__func__=FunctionType(__code__=code)):
                return _seed_use(code, 1)
        return "read"

    @override
    def run(
        self, parameters: Mapping[str, float], seed: int, workspace: Workspace
    ) -> Mapping[str, Measured]:
        values = finite_parameters(parameters)
        if workspace.cancelled.is_set():
            raise RunFailedError(process_messages.STOPPED(), kind="cancelled")
        arguments = (values,) if self._seed_use == "none" else (values, int(seed))
        try:
            found = self._function(*arguments)
        except RunFailedError:
            raise
        # A function that calls sys.exit must not end the whole calibration.
        except (Exception, SystemExit) as error:
            tail = "\n".join("".join(traceback.format_exc()).splitlines()[-_TRACEBACK_LINES:])
            if reason := machine_error(error):
                raise RunFailedError(reason, tail, "machine") from error
            raise RunFailedError(error_in_words(error), tail, "evaluation") from error
        return read_responses(found, self._response_names, "the function")


def _seed_use(code: CodeType, bound: int) -> SeedUse:
    """Return whether code reads its seed, the second argument after those that are bound."""
    arguments = code.co_varnames[bound : code.co_argcount]
    if code.co_flags & inspect.CO_VARARGS or not arguments:
        return "read"
    if len(arguments) == 1:
        return "none"
    seed = arguments[1]
    # Several variables may be one argument of an instruction.
    named = (str(instruction.argrepr) for instruction in dis.get_instructions(code))
    mentioned = {name.strip() for names in named for name in names.split(",")}
    by_name = {"locals", "vars", "eval", "exec"}.intersection(code.co_names)
    return "read" if seed in {*mentioned, *code.co_cellvars} or by_name else "unread"


def _identity(function: Any) -> dict[str, Any]:
    """Return name and code of a function, a method, a partial, or a callable object."""
    if isinstance(function, functools.partial):
        return {
            **_identity(function.func),
            "given": _data_hash([function.args, function.keywords]),
        }
    described = function if hasattr(function, "__qualname__") else type(function)
    identity = {
        "function": f"{described.__module__}.{described.__qualname__}",
        "source": _source_hash(function),
    }
    held = [data for layer in _layers(function) if (data := _held_data(layer))]
    return {**identity, "data": _data_hash(held)} if held else identity


def _layers(function: Any) -> Iterator[Any]:
    """Yield the callable object, its function, and the functions that decorators wrapped."""
    if not inspect.isroutine(function) and not isinstance(function, type):
        yield function
        function = type(function).__call__
    while function is not None:
        yield function
        function = getattr(function, "__wrapped__", None)


def _held_data(layer: Any) -> dict[str, Any]:
    """Return the values that a function holds, or the attributes of an object, by name."""
    if not inspect.isroutine(layer):
        return dict(getattr(layer, "__dict__", {}))
    code = getattr(layer, "__code__", None)
    names = code.co_freevars if code is not None else ()
    cells = dict(zip(names, getattr(layer, "__closure__", None) or (), strict=False))
    changing = _declared_nonlocal(code) if code is not None else set()
    owner = getattr(layer, "__self__", None) if inspect.ismethod(layer) else None
    held = {
        "closure": {
            name: _cell_contents(cell) for name, cell in cells.items() if name not in changing
        },
        "defaults": getattr(layer, "__defaults__", None),
        "keyword defaults": getattr(layer, "__kwdefaults__", None),
        "object": None if isinstance(owner, type) else dict(getattr(owner, "__dict__", {})),
    }
    return {name: values for name, values in held.items() if values}


def _declared_nonlocal(code: CodeType) -> set[str]:
    """Return enclosing variables that a function assigns to: state, not part of its identity."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(code)))
    except (OSError, SyntaxError, TokenError):
        # No source, or a lambda within a longer statement, which cannot assign variables.
        return set()
    found = (node.names for node in ast.walk(tree) if isinstance(node, ast.Nonlocal))
    return {name for names in found for name in names}


def _cell_contents(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:
        # A variable that has no value yet.
        return None


def _data_hash(value: Any) -> str:
    return hashlib.sha256(json.dumps(_plain(value)).encode()).hexdigest()


def _plain(value: Any, outer: tuple[int, ...] = ()) -> Any:
    """Return data as JSON that is the same in every process; other objects as their type."""
    if value is None:
        return None
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain_array(np.asarray(value), outer)
    for kind in (bool, int, float, complex, str, bytes):
        if isinstance(value, kind):
            return [kind.__name__, kind.__repr__(value)]
    if not isinstance(value, (list, tuple, Mapping, set, frozenset)) or id(value) in outer:
        return f"{type(value).__module__}.{type(value).__qualname__}"
    outer = (*outer, id(value))
    if isinstance(value, (list, tuple)):
        return ["sequence", [_plain(item, outer) for item in value]]
    items = value.items() if isinstance(value, Mapping) else value
    return ["unordered", sorted((_plain(item, outer) for item in items), key=json.dumps)]


def _plain_array(array: np.ndarray[Any, Any], outer: tuple[int, ...]) -> Any:
    # The bytes of an array of objects are memory addresses.
    if array.dtype.hasobject:
        content = _plain(array.tolist(), outer) if array.ndim else _plain(array.item(), outer)
    else:
        content = hashlib.sha256(array.tobytes()).hexdigest()
    return ["array", str(array.dtype), list(array.shape), content]


def _source_hash(function: Any) -> str | None:
    routine = inspect.unwrap(function)
    if not inspect.isroutine(routine):
        routine = type(routine).__call__
    try:
        text = inspect.getsource(routine)
        if routine.__name__ == "<lambda>":
            # Its source is the whole line, which may hold another one.
            text += repr(_instructions(routine.__code__))
        return hashlib.sha256(text.encode()).hexdigest()
    except (OSError, TypeError, SyntaxError, TokenError):
        # Also where the file has changed, or holds more than Python, since it was executed.
        code = getattr(routine, "__code__", None)
    return None if code is None else hashlib.sha256(repr(_instructions(code)).encode()).hexdigest()


def _instructions(code: CodeType) -> tuple[Any, ...]:
    """Return byte code and constants, without file names and line numbers."""
    # The meaning of byte code depends on the version of Python.
    version = sys.version_info[:2]
    return (version, code.co_code.hex(), code.co_names, [_constant(c) for c in code.co_consts])


def _constant(constant: Any) -> Any:
    if isinstance(constant, CodeType):
        return _instructions(constant)
    # The order of a set differs from process to process.
    return sorted(map(repr, constant)) if isinstance(constant, frozenset) else repr(constant)
