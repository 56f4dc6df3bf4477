"""Follow one parameter through the calls of the package, and count the stays of its way.

A stay is a module that a call passes the parameter on to. The way is
read from the code alone, call after call as the functions are written, each function once: names
that are assigned from the parameter are the parameter; a call whose target the code does not name
(a callback, a method that several classes have) is not followed.

python tools/walks.py grainfit.report.page:write_report:source
"""

from __future__ import annotations

import argparse
import ast
from collections import defaultdict
from collections.abc import Iterator, Set
from dataclasses import dataclass, field
from pathlib import Path

try:
    from tools.house import ROOT, modules
except ImportError:  # Run as a script, from this folder.
    from house import ROOT, modules  # type: ignore[no-redef]

#: Calls that give a value another form.
_FORMS = ("Path", "str", "list", "tuple", "dict", "replace")
Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass
class House:
    """Definitions of the package by name.

    Parameters
    ----------
    functions : dict
        Functions and methods by module and dotted name.
    names : dict
        Meaning of the names that a module imports: module, and name in it.
    methods : dict
        Keys of `functions` of all methods of a name.
    """

    functions: dict[tuple[str, str], Function] = field(default_factory=dict)
    names: dict[str, dict[str, tuple[str, str]]] = field(default_factory=dict)
    methods: dict[str, list[tuple[str, str]]] = field(default_factory=lambda: defaultdict(list))

    @classmethod
    def read(cls, source: Path) -> House:
        """Read the package below a folder."""
        house, known = cls(), modules(source)
        for module, path in known.items():
            tree = ast.parse(path.read_text(encoding="utf-8"))
            house.names[module] = dict(_imported_names(tree, known))
            for node in tree.body:
                if isinstance(node, Function):
                    house.functions[module, node.name] = node
                elif isinstance(node, ast.ClassDef):
                    house._add_class(module, node)
        return house

    def _add_class(self, module: str, node: ast.ClassDef) -> None:
        for member in node.body:
            if isinstance(member, Function):
                key = (module, f"{node.name}.{member.name}")
                self.functions[key] = member
                self.methods[member.name].append(key)

    def target(self, call: ast.Call, module: str, name: str) -> tuple[str, str] | None:
        """Return the function that a call in a function runs; None if the code does not say."""
        parts = ast.unparse(call.func).split(".")
        if not all(part.isidentifier() for part in parts):
            parts = ["", parts[-1]]
        home, first = self.names[module].get(parts[0], (module, parts[0]))
        if not first and len(parts) > 1:
            first, parts = parts[1], parts[1:]
        found = (home, ".".join([first, *parts[1:]]))
        if parts[0] in ("self", "cls"):
            found = (module, f"{name.split('.')[0]}.{parts[-1]}")
        for key in (found, (home, f"{first}.__init__")):
            if key in self.functions:
                return key
        # A method that paths have, too, is most likely theirs.
        is_known = len(parts) > 1 and not hasattr(Path, parts[-1])
        owners = self.methods.get(parts[-1], []) if is_known else []
        return owners[0] if len(owners) == 1 else None


def _imported_names(
    tree: ast.Module, known: dict[str, Path]
) -> Iterator[tuple[str, tuple[str, str]]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                meaning = (inner, "") if inner in known else (node.module, alias.name)
                yield alias.asname or alias.name, meaning


def walk(house: House, start: str) -> list[str]:
    """Return the stays of a parameter, as names of modules.

    Parameters
    ----------
    house : House
        The package.
    start : str
        ``MODULE:FUNCTION:PARAMETER``.
    """
    module, function, parameter = start.split(":")
    stays: list[str] = []
    _visit(house, (module, function), {parameter}, stays, set())
    return stays


def _visit(
    house: House,
    key: tuple[str, str],
    entered: Set[str],
    stays: list[str],
    seen: set[tuple[str, str]],
) -> None:
    if key in seen:
        return
    seen.add(key)
    module, name = key
    names = {*entered}
    if stays[-1:] != [module]:
        stays.append(module)
    for node in _in_order(house.functions[key].body):
        if isinstance(node, ast.Call):
            target = house.target(node, module, name)
            if target is not None and (inner := {*_entered(house, node, target, names)}):
                _visit(house, target, inner, stays, seen)
        elif assigned := _assigned(node):
            targets, value = assigned
            if _is_still(value, names):
                names |= {one.id for one in ast.walk(targets) if isinstance(one, ast.Name)}


def _in_order(body: list[ast.stmt]) -> Iterator[ast.AST]:
    """Yield the nodes of a function as they are computed: arguments before their call."""
    for statement in body:
        yield from _below(statement)


def _below(node: ast.AST) -> Iterator[ast.AST]:
    for child in ast.iter_child_nodes(node):
        yield from _below(child)
    yield node


def _entered(
    house: House, call: ast.Call, target: tuple[str, str], names: set[str]
) -> Iterator[str]:
    """Yield the names under which the parameter enters the target of a call."""
    arguments = house.functions[target].args
    places = [one.arg for one in (*arguments.posonlyargs, *arguments.args)]
    is_member = places[:1] in (["self"], ["cls"])
    if is_member and isinstance(call.func, ast.Attribute) and _mentions(call.func.value, names):
        yield places[0]
    places = places[1:] if is_member else places
    for place, given in zip(places, call.args, strict=False):
        if _mentions(given, names):
            yield place
    by_name = {*places, *(one.arg for one in arguments.kwonlyargs)}
    for keyword in call.keywords:
        if keyword.arg in by_name and _mentions(keyword.value, names):
            yield str(keyword.arg)


def _assigned(node: ast.AST) -> tuple[ast.AST, ast.AST] | None:
    match node:
        case ast.Assign(targets=[target], value=value):
            return target, value
        case ast.AnnAssign(target=target, value=ast.expr() as value):
            return target, value
        case ast.NamedExpr(target=target, value=value):
            return target, value
        case ast.withitem(context_expr=value, optional_vars=ast.expr() as target):
            return target, value
        case ast.For(target=target, iter=value) | ast.comprehension(target=target, iter=value):
            return target, value
    return None


def _is_still(value: ast.AST, names: set[str]) -> bool:
    """Return whether a value is the parameter, in another form at most: not what was made of it."""
    if isinstance(value, ast.Call):
        return ast.unparse(value.func) in _FORMS and any(_is_still(a, names) for a in value.args)
    if isinstance(value, (ast.BoolOp, ast.BinOp, ast.IfExp, ast.Tuple, ast.List)):
        return _mentions(value, names)
    return isinstance(value, ast.Name) and value.id in names


def _mentions(value: ast.AST, names: set[str]) -> bool:
    return any(isinstance(node, ast.Name) and node.id in names for node in ast.walk(value))


def main() -> None:
    """Print the stays of a parameter."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("start", metavar="MODULE:FUNCTION:PARAMETER")
    parser.add_argument("--source", type=Path, default=ROOT / "src", help="folder of the package")
    given = parser.parse_args()
    stays = walk(House.read(given.source), given.start)
    print("\n".join(stays), f"{len(stays)} stays", sep="\n")


if __name__ == "__main__":
    main()
