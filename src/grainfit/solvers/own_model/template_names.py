"""Find the names that a Jinja2 template reads, from its syntax tree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from jinja2 import nodes

#: Names that Jinja2 itself gives within loops, blocks and macros.
_OF_JINJA = frozenset({"loop", "self", "super", "caller", "varargs", "kwargs"})
#: Parts of a template that are not evaluated in every run.
_PERHAPS: Mapping[type[nodes.Node], tuple[str, ...]] = {
    nodes.If: ("body", "elif_", "else_"),
    nodes.CondExpr: ("expr1", "expr2"),
    nodes.And: ("right",),
    nodes.Or: ("right",),
    nodes.Macro: ("body",),
    nodes.CallBlock: ("body",),
}

#: ``particle.density`` and ``particle["density"]`` alike: ("particle", "density").
Path = tuple[str, ...]


@dataclass(frozen=True)
class Use:
    """Name that a template reads.

    Parameters
    ----------
    path : tuple of str
        The name and its attributes.
    line : int
        Line of the template.
    is_certain : bool
        True if every run reads it, False within conditions and macros.
    """

    path: Path
    line: int
    is_certain: bool


@dataclass(frozen=True)
class TemplateNames:
    """Names in a template.

    Parameters
    ----------
    text : str
        The template without its expressions.
    uses : tuple of Use
        Names that it reads, each where it is first.
    own : frozenset of str
        Names that it sets itself, and those of Jinja2.
    optional : frozenset of tuple of str
        Names that it tests, for example for being defined.
    loose_keys : frozenset of str
        Attributes and texts that may belong to any object.
    has_computed_keys : bool
        Whether it reads attributes whose names it computes.
    templates : tuple of str
        Templates that it includes or imports.
    """

    text: str
    uses: tuple[Use, ...]
    own: frozenset[str]
    optional: frozenset[Path]
    loose_keys: frozenset[str]
    has_computed_keys: bool
    templates: tuple[str, ...]


def names_in(tree: nodes.Template) -> TemplateNames:
    """Return the names in a template.

    The names that a template sets are taken as set everywhere in it.
    """
    first: dict[tuple[Path, bool], Use] = {}
    for use in _uses(tree, is_certain=tree.find(nodes.Extends) is None):
        first.setdefault((use.path, use.is_certain), use)
    uses = tuple(first.values())
    own = frozenset(_own(tree))
    through_own_names = {key for use in uses if use.path[0] in own for key in use.path[1:]}
    return TemplateNames(
        "\n".join(node.data for node in tree.find_all(nodes.TemplateData)),
        uses,
        own | _OF_JINJA,
        frozenset(_optional(tree)),
        frozenset({*_loose_keys(tree), *through_own_names}),
        any(not isinstance(node.arg, nodes.Const) for node in tree.find_all(nodes.Getitem)),
        tuple(_templates(tree)),
    )


def _path(node: nodes.Node) -> Path:
    """Return the name and attributes that an expression reads; empty for any other."""
    if isinstance(node, nodes.Name) and node.ctx == "load":
        return (node.name,)
    key = _key(node)
    base = _path(node.node) if isinstance(node, nodes.Getattr | nodes.Getitem) and key else ()
    return (*base, key) if base else ()


def _key(node: nodes.Node) -> str:
    if isinstance(node, nodes.Getattr):
        return node.attr
    if isinstance(node, nodes.Getitem) and isinstance(node.arg, nodes.Const):
        return node.arg.value if isinstance(node.arg.value, str) else ""
    return ""


def _uses(node: nodes.Node, *, is_certain: bool) -> Iterator[Use]:
    if path := _path(node):
        yield Use(path, node.lineno, is_certain)
        return
    perhaps = _PERHAPS.get(type(node), ())
    for child in node.iter_child_nodes(exclude=perhaps):
        yield from _uses(child, is_certain=is_certain)
    if perhaps:
        for child in node.iter_child_nodes(only=perhaps):
            yield from _uses(child, is_certain=False)


def _loose_keys(node: nodes.Node) -> Iterator[str]:
    """Yield attributes of anything but names, and texts: ``thing | attr("density")``."""
    if _path(node):
        return
    if key := _key(node):
        yield key
    if isinstance(node, nodes.Const) and isinstance(node.value, str):
        yield node.value
    for child in node.iter_child_nodes():
        yield from _loose_keys(child)


def _own(tree: nodes.Template) -> Iterator[str]:
    yield from (node.name for node in tree.find_all(nodes.Name) if node.ctx != "load")
    yield from (node.name for node in tree.find_all(nodes.Macro))
    yield from (node.target for node in tree.find_all(nodes.Import))
    for node in tree.find_all(nodes.FromImport):
        yield from (name if isinstance(name, str) else name[1] for name in node.names)


def _optional(tree: nodes.Template) -> Iterator[Path]:
    yield from filter(None, (_path(node.node) for node in tree.find_all(nodes.Test)))
    for node in tree.find_all(nodes.Filter):
        if node.name in ("default", "d") and node.node is not None and (path := _path(node.node)):
            yield path


def _templates(tree: nodes.Template) -> Iterator[str]:
    for statement in tree.find_all(nodes.Stmt):
        reference = getattr(statement, "template", None)
        if isinstance(reference, nodes.Expr):
            yield from _loose_keys(reference)
