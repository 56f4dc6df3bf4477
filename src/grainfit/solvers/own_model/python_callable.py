"""Run a Python function as a solver."""

from __future__ import annotations

import dis
import functools
import inspect
import traceback
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import CodeType, FunctionType, MethodType
from typing import Any

from typing_extensions import override

from grainfit.errors import InputError, RunFailedError, error_in_words
from grainfit.evaluation import Measured
from grainfit.evaluation.exchange import finite_parameters, read_responses
from grainfit.options.python_file import PythonFile
from grainfit.solvers.base import SeedUse, Solver, Workspace
from grainfit.solvers.own_model import messages
from grainfit.solvers.own_model.function_identity import identify
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
        the byte code; without either, the name alone. It includes what the function holds:
        enclosing variables, default arguments, arguments of a `functools.partial`, and attributes
        of the object that it is or is a method of. These may be data, functions (with their source
        and what they hold) and objects that can be pickled (with their attributes). A function that
        appends to a list that it holds therefore changes its identity; variables that its source
        declares ``nonlocal``, random generators, locks and open files are left out. Globals,
        modules and the source of classes are not included: give another identity when they change.
        Of objects that cannot be pickled only the type is, and a warning names them.

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
        identity, left_out = identify(self._function)
        if left_out:
            named = {"function": identity["function"], "left_out": ", ".join(left_out)}
            warnings.warn(messages.NOT_IN_IDENTITY(**named), stacklevel=2)
        return identity

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
