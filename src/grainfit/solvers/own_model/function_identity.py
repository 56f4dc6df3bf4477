"""Identity of a Python function: its name, its code, and the data that it holds."""

from __future__ import annotations

import ast
import copyreg
import functools
import hashlib
import inspect
import json
import sys
import textwrap
from collections.abc import Iterator, Mapping
from tokenize import TokenError
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

#: Modules of objects that change while a function runs: they are no data.
_STATE = ("_io", "_thread", "itertools", "numpy.random", "random", "threading")
#: Most objects, functions, lists and dicts within each other.
_DEEPEST = 150


def identify(function: Any) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the identity of a function, a method, a partial, or a callable object.

    Also return which objects that it holds are left out, each as name and type.
    """
    reader = _Reader()
    return reader.identity(function), tuple(dict.fromkeys(reader.left_out))


class _Reader:
    """Reads what a function holds as JSON that is the same in every process."""

    def __init__(self) -> None:
        self.left_out: list[str] = []
        # The objects are kept, so that no other one has the id of one of them.
        self._known: dict[int, tuple[Any, Any]] = {}

    def identity(self, function: Any, outer: tuple[int, ...] = ()) -> dict[str, Any]:
        """Return name, code and data of something that can be called."""
        if isinstance(function, functools.partial):
            return {
                **self.identity(function.func, outer),
                "given": self._hash([function.args, function.keywords], outer),
            }
        described = function if hasattr(function, "__qualname__") else type(function)
        identity = {
            "function": f"{described.__module__}.{described.__qualname__}",
            "source": _source_hash(function),
        }
        layers = list(_layers(function))
        outer = (*outer, *map(id, layers), id(getattr(function, "__self__", None)))
        held = [data for layer in layers if (data := _held_data(layer))]
        return {**identity, "data": self._hash(held, outer)} if held else identity

    def _hash(self, value: Any, outer: tuple[int, ...]) -> str:
        return hashlib.sha256(json.dumps(self._plain(value, outer, "")).encode()).hexdigest()

    def _plain(self, value: Any, outer: tuple[int, ...], name: str) -> Any:
        """Return data as JSON; what is no data as its type."""
        if value is None:
            return None
        if isinstance(value, (np.ndarray, np.generic)):
            return self._array(np.asarray(value), outer, name)
        for kind in (bool, int, float, complex, str, bytes):
            if isinstance(value, kind):
                return [kind.__name__, kind.__repr__(value)]
        if id(value) in outer:
            return _type_name(value)
        if not isinstance(value, (list, tuple, Mapping, set, frozenset)):
            return self._object(value, outer, name)
        outer = (*outer, id(value))
        if isinstance(value, (list, tuple)):
            return ["sequence", [self._plain(item, outer, name) for item in value]]
        if isinstance(value, Mapping):
            items = [
                ["sequence", [self._plain(key, outer, name), self._plain(item, outer, str(key))]]
                for key, item in value.items()
            ]
        else:
            items = [self._plain(item, outer, name) for item in value]
        return ["unordered", sorted(items, key=json.dumps)]

    def _array(self, array: np.ndarray[Any, Any], outer: tuple[int, ...], name: str) -> Any:
        # The bytes of an array of objects are memory addresses.
        if array.dtype.hasobject:
            content = self._plain(array.tolist() if array.ndim else array.item(), outer, name)
        else:
            content = hashlib.sha256(array.tobytes()).hexdigest()
        return ["array", str(array.dtype), list(array.shape), content]

    def _object(self, value: Any, outer: tuple[int, ...], name: str) -> Any:
        """Return another function or object as a hash; its type where that is all it has."""
        if _is_state(value):
            return _type_name(value)
        if id(value) not in self._known:
            self._known[id(value)] = (value, self._object_anew(value, outer, name))
        return self._known[id(value)][1]

    def _object_anew(self, value: Any, outer: tuple[int, ...], name: str) -> Any:
        if isinstance(value, type):
            return ["class", f"{value.__module__}.{value.__qualname__}"]
        try:
            found = self._content(value, outer) if len(outer) <= _DEEPEST else None
        except Exception:
            # Anything may be raised: classes tell their data in ways of their own.
            found = None
        if found is None:
            self.left_out.append(f"{name} ({_type_name(value)})".strip())
        return [_type_name(value), found] if found else _type_name(value)

    def _content(self, value: Any, outer: tuple[int, ...]) -> Any:
        """Return what a function or an object consists of; empty if it has no data."""
        is_function = isinstance(value, (FunctionType, MethodType, functools.partial))
        if is_function or hasattr(value, "__wrapped__"):
            return self.identity(value, (*outer, id(value)))
        found = _reduced(value)
        return found and self._hash(found, (*outer, id(value)))


def _type_name(value: Any) -> str:
    return f"{type(value).__module__}.{type(value).__qualname__}"


def _is_state(value: Any) -> bool:
    module = str(type(value).__module__)
    return isinstance(value, ModuleType) or any(f"{module}.".startswith(f"{m}.") for m in _STATE)


def _reduced(value: Any) -> list[Any]:
    """Return what an object consists of, as it is told to be pickled; empty if it has no data."""
    reduce = copyreg.dispatch_table.get(type(value))
    found = value.__reduce_ex__(4) if reduce is None else reduce(value)
    if isinstance(found, str):
        return [f"{getattr(value, '__module__', '')}.{found}"]
    make, arguments, *state = found
    made_by = getattr(make, "__qualname__", _type_name(make))
    is_plain = made_by == "__newobj__"
    content = [list(part) if isinstance(part, Iterator) else part for part in state[:3]]
    if is_plain and len(arguments) == 1 and not any(content):
        return []
    return [made_by, arguments, content]


def _layers(function: Any) -> Iterator[Any]:
    """Yield the callable object, its function, and the functions that decorators wrapped."""
    if not inspect.isroutine(function) and not isinstance(function, type):
        called = type(function).__call__
        if isinstance(called, FunctionType) or not hasattr(function, "__wrapped__"):
            yield function
            function = called
        else:
            # A compiled function: what it holds besides are caches.
            function = function.__wrapped__
    while function is not None:
        yield function
        function = getattr(function, "__wrapped__", None)


def _held_data(layer: Any) -> dict[str, Any]:
    """Return the values that a function holds, or the attributes of an object, by name."""
    if not inspect.isroutine(layer):
        return _attributes(layer)
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
        "object": None if isinstance(owner, type) else _attributes(owner),
    }
    return {name: values for name, values in held.items() if values}


def _attributes(owner: Any) -> dict[str, Any]:
    """Return the attributes of an object by name, also those in slots."""
    if isinstance(owner, type):
        return dict(owner.__dict__)
    # What differs from object to object: of those in slots, it is not in __dict__.
    found = object.__getstate__(owner)
    parts = found if isinstance(found, tuple) else (found,)
    return {name: value for part in parts if part for name, value in part.items()}


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
