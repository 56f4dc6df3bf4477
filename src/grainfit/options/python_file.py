"""Load a Python function from a file, referred to as ``"path/to/file.py:function"``."""

from __future__ import annotations

import ast
import hashlib
import sys
import threading
import warnings
from collections.abc import Collection
from functools import cached_property
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from grainfit.errors import InputError
from grainfit.files import LARGEST_PYTHON_FILE, TooLargeError, read_within
from grainfit.one_line import OneLine
from grainfit.options import messages


class PythonFile(OneLine):
    """A function in a file, checked without executing anything, and loaded at its first call.

    Parameters
    ----------
    reference : str
        ``"path/to/file.py:function"``.
    folder : Path, optional
        Base folder of relative paths; the current folder by default.

    Raises
    ------
    InputError
        The reference has another form.
    """

    def __init__(self, reference: str, folder: Path | None = None) -> None:
        path, colon, function = reference.rpartition(":")
        if not (colon and path.endswith(".py") and function.isidentifier()):
            raise InputError(messages.NO_REFERENCE.fault("function", reference=reference))
        self.path = ((folder or Path()) / path).absolute()
        self.function = function
        self._lock = threading.Lock()
        self._loaded: Any = None

    @cached_property
    def source(self) -> bytes:
        """Contents of the file when first read, so that the hashed code is the executed code.

        Raises
        ------
        InputError
            The file cannot be read, or is too large to be code.
        """
        try:
            return read_within(self.path, LARGEST_PYTHON_FILE)
        except TooLargeError as error:
            fault = messages.TOO_LARGE_TO_READ.fault("", reason=error.strerror)
            raise InputError(fault, str(self.path)) from error
        except OSError as error:
            fault = messages.CANNOT_BE_READ.fault("", reason=error.strerror)
            raise InputError(fault, str(self.path)) from error

    def __reduce__(self) -> tuple[Any, ...]:
        return _with_source, (f"{self.path}:{self.function}", self.source)

    def identity(self) -> dict[str, str]:
        """Return the names of the file and the function, and the hash of the whole file."""
        return {
            "file": self.path.name,
            "function": self.function,
            "source": hashlib.sha256(self.source).hexdigest(),
        }

    def check(self) -> None:
        """Raise `InputError` unless the file is Python and has the function at its top level.

        Nothing in the file is executed.
        """
        tree = self._tree()
        names = _top_level_names(tree)
        # A star import can bring in any name.
        if self.function not in names and "*" not in names:
            known = _available(tree)
            fault = messages.NO_SUCH_FUNCTION.fault("", function=self.function, remedy=known)
            raise InputError(fault, str(self.path))

    def unknown_arguments(self, known: Collection[str]) -> list[str]:
        """Return the arguments that the function needs beside known ones, which have their names.

        Nothing in the file is executed: empty also where only that would tell.

        Raises
        ------
        InputError
            See `check`.
        """
        found = self._definition()
        return [] if found is None else _needed(found.args, known)

    def code(self) -> CodeType | None:
        """Return the code of the function; None where only executing the file would tell.

        Raises
        ------
        InputError
            See `check`.
        """
        found = self._definition()
        if found is None:
            return None
        module = compile(ast.Module([found], []), str(self.path), "exec")
        return next(
            (c for c in module.co_consts if isinstance(c, CodeType) and c.co_name == self.function),
            None,
        )

    def _definition(self) -> ast.FunctionDef | None:
        """Return the definition of the function, if it is plainly the one that is called."""
        tree = self._tree()
        binding = [node for node in tree.body if _top_level_names(node) & {self.function, "*"}]
        match binding:
            case [*_, ast.FunctionDef(name=self.function, decorator_list=[]) as found]:
                return found
        return None

    def _tree(self) -> ast.Module:
        source = self.source
        try:
            with warnings.catch_warnings():
                # Python shows warnings about the code when the file is executed.
                warnings.simplefilter("ignore")
                return ast.parse(source, str(self.path))
        except (RecursionError, MemoryError):
            raise InputError(messages.NESTED_TOO_DEEPLY.fault(""), str(self.path)) from None
        except (SyntaxError, ValueError) as error:
            line = getattr(error, "lineno", None)
            place = f"line {line}" if line else ""
            fault = messages.NOT_PYTHON.fault(place, reason=error.args[0])
            raise InputError(fault, str(self.path)) from error

    def __call__(self, *arguments: Any) -> Any:
        """Call the function, executing its file before the first call."""
        return self.load()(*arguments)

    def load(self) -> Any:
        """Return the object of this name in the file; the first call executes the file."""
        with self._lock:
            if self._loaded is None:
                self._loaded = getattr(self._execute(), self.function)
        return self._loaded

    def _execute(self) -> ModuleType:
        module = ModuleType(f"grainfit_user_{hashlib.sha256(self.source).hexdigest()[:16]}")
        module.__file__ = str(self.path)
        # Data classes and pickle need the module in sys.modules.
        sys.modules[module.__name__] = module
        # At the end, so that modules next to the file are found and hide no installed package.
        if str(self.path.parent) not in sys.path:
            sys.path.append(str(self.path.parent))
        exec(compile(self.source, str(self.path), "exec"), module.__dict__)
        return module


def _with_source(reference: str, source: bytes) -> PythonFile:
    """Rebuild a function in another process: of the contents that were hashed in the first."""
    function = PythonFile(reference)
    function.__dict__["source"] = source
    return function


def _needed(arguments: ast.arguments, known: Collection[str]) -> list[str]:
    """Return the arguments without a default that cannot be given by a known name."""
    by_place = [*arguments.posonlyargs, *arguments.args]
    needed = by_place[: len(by_place) - len(arguments.defaults)]
    defaults = zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    needed += [argument for argument, default in defaults if default is None]
    unknown = [a.arg for a in needed if a.arg not in known and a not in arguments.posonlyargs]
    nameless = [f"{a.arg} by position only" for a in needed if a in arguments.posonlyargs]
    return nameless + unknown


def _top_level_names(tree: ast.AST) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            names.update(alias.asname or alias.name for alias in node.names)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
    return names


def _available(tree: ast.Module) -> str:
    functions = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    if not functions:
        return "It defines no functions."
    return f"It defines: {', '.join(functions)}."
