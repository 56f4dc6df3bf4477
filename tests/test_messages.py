"""Catalogues of messages: every text is filled in as it is written, and none is left over."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from string import Formatter

import pytest

from grainfit.errors import Fault, GrainfitError
from grainfit.messages import Message

SOURCE = Path(__file__).parents[1] / "src"
CATALOGUES = sorted((SOURCE / "grainfit").rglob("*messages.py"))


def errors_below(kind: type[Exception]) -> list[type[Exception]]:
    below = kind.__subclasses__()
    return [kind, *below, *(one for each in below for one in errors_below(each)[1:])]


def messages_of(catalogue: Path) -> dict[str, Message]:
    name = ".".join(catalogue.relative_to(SOURCE).with_suffix("").parts)
    found = vars(import_module(name))
    return {key: value for key, value in found.items() if isinstance(value, Message)}


ALL = {(str(path), name): found for path in CATALOGUES for name, found in messages_of(path).items()}


def catalogues_of(tree: ast.Module) -> dict[str, str]:
    """Return the files of the catalogues that a module imports, by their names there."""
    return {
        one.asname or one.name: str(path)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module
        for one in node.names
        if (path := SOURCE / Path(*node.module.split("."), f"{one.name}.py")) in CATALOGUES
    }


@cache
def uses(path: Path) -> tuple[tuple[tuple[str, str], ast.Call | None, int], ...]:
    """Return each message that a module of the package uses: its key, the call, and the line."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    catalogues = catalogues_of(tree)
    called = {id(node.func): node for node in ast.walk(tree) if isinstance(node, ast.Call)}
    faults = {
        id(node.value): called.get(id(node))
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and node.attr == "fault"
    }
    placed = {
        id(node.args[0]): node
        for node in called.values()
        if node.args and isinstance(node.func, ast.Attribute) and node.func.attr == "fault"
    }
    filled = faults | placed | called
    return tuple(
        (key, filled.get(id(node)), node.lineno)
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)
        if (key := (catalogues.get(node.value.id, ""), node.attr)) in ALL
    )


def modules_with_messages() -> list[Path]:
    found = sorted((SOURCE / "grainfit").rglob("*.py"))
    return [path for path in found if "messages" in path.read_text(encoding="utf-8")]


def test_every_message_is_filled_in_with_the_fields_that_it_has() -> None:
    wrong = []
    for path in modules_with_messages():
        for key, call, line in uses(path):
            if call is None or any(keyword.arg is None for keyword in call.keywords):
                continue  # Passed on as a whole, or filled in from a mapping.
            given = {keyword.arg for keyword in call.keywords}
            # Of a place, not of the message.
            given -= {"near"} - ALL[key].fields
            if given != ALL[key].fields:
                wrong.append(f"{path.name}:{line} {key[1]}: {given ^ ALL[key].fields}")
    assert not wrong


def test_every_message_of_a_catalogue_is_used() -> None:
    used = {key for path in modules_with_messages() for key, _, _ in uses(path)}
    assert not [name for (path, name) in ALL.keys() - used]


ERRORS = (Fault, *errors_below(GrainfitError))


def written_out(call: ast.Call) -> str:
    """Return the words of a fault or an error that stand in the call itself."""
    name = ast.unparse(call.func)
    place = 1 if name == "Fault" else 0
    if name not in {one.__name__ for one in ERRORS} or len(call.args) <= place:
        return ""
    given = call.args[place]
    literals = [
        node.value
        for text in ([given.body, given.orelse] if isinstance(given, ast.IfExp) else [given])
        for node in (text.values if isinstance(text, ast.JoinedStr) else [text])
        if isinstance(node, ast.Constant)
    ]
    return re.sub(r"\W", "", "".join(map(str, literals)))


def says(text: ast.AST) -> str:
    """Return a sentence that stands in a text."""
    parts = text.values if isinstance(text, ast.JoinedStr) else [text]
    literal = "".join(str(one.value) if isinstance(one, ast.Constant) else "..." for one in parts)
    return literal if len(re.findall(r"[a-z]{2,}", literal)) > 4 else ""


def test_the_words_of_every_check_are_in_a_catalogue() -> None:
    found = []
    for path in (SOURCE / "grainfit").rglob("*.py"):
        for function in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(function, ast.FunctionDef) and any(
                ast.unparse(one).startswith("check(") for one in function.decorator_list
            ):
                texts = [
                    node
                    for statement in function.body[1:]
                    for node in ast.walk(statement)
                    if isinstance(node, ast.JoinedStr | ast.Constant)
                ]
                found += [f"{path.name}: {said}" for text in texts if (said := says(text))]
    assert found == []


def test_the_words_of_every_error_are_in_a_catalogue() -> None:
    found = []
    for path in (SOURCE / "grainfit").rglob("*.py"):
        if path not in CATALOGUES and "testing" not in path.parts:
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and (words := written_out(node)):
                    found.append(f"{path.relative_to(SOURCE)}:{node.lineno} {words}")
    assert found == []


def test_a_message_is_found_whatever_fills_it_in() -> None:
    message = Message("{name} is {value:g} mm (a+b).", "Give {limit}.")
    assert message.is_in("1: " + message(name="x\ny", value=3, limit=2))
    assert message.is_in("x is\n  3 mm (a+b).")
    assert not message.is_in("x is 3 cm (a+b).")
    with pytest.raises(ValueError, match=message.pattern):
        raise ValueError("radius is 3 mm (a+b).")


def test_a_message_without_text_cannot_be_made() -> None:
    with pytest.raises(AssertionError):
        Message(" ")


#: A literal of an assertion that has as many words in a row as a message is prose of it.
WORDS = 4


def runs_of_words(text: str) -> set[tuple[str, ...]]:
    words = re.findall(r"[^\W\d_][\w'-]*(?:[._]\w+)*", text)
    return {tuple(words[at : at + WORDS]) for at in range(len(words) - WORDS + 1)}


def prose_of_messages() -> set[tuple[str, ...]]:
    templates = [text for message in ALL.values() for text in (message.text, message.remedy)]
    literals = (literal for text in templates for literal, *_ in Formatter().parse(text))
    return {run for literal in literals for run in runs_of_words(literal)}


def asserted_literals(tree: ast.AST) -> Iterator[ast.Constant]:
    """Yield the literals that a text has to contain or to match."""
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "match":
            found = [*ast.walk(node.value)]
        elif isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.In):
            found = [*ast.walk(node.left)]
        else:
            continue
        yield from (
            one for one in found if isinstance(one, ast.Constant) and isinstance(one.value, str)
        )


def test_tests_ask_for_messages_by_their_names() -> None:
    prose = prose_of_messages()
    found = [
        f"{path.relative_to(SOURCE.parent)}:{literal.lineno} {literal.value!r}"
        for path in sorted((SOURCE.parent / "tests").rglob("*.py"))
        for literal in asserted_literals(ast.parse(path.read_text(encoding="utf-8")))
        if runs_of_words(re.sub(r"\\(.)", r"\1", literal.value)) & prose
    ]
    assert not found, "messages have names: see Message.is_in and Message.matching"


def test_a_value_that_ends_with_a_full_stop_gets_no_other() -> None:
    message = Message("{path} cannot be read: {why}. So it is left out.", "{remedy}.")
    values = {"path": "a..b", "why": "It is empty.", "remedy": "Fill it."}
    said = message(**values)
    assert said == "a..b cannot be read: It is empty. So it is left out. Fill it."
    assert message.fault("", **values).remedy == "Fill it."
    assert message.is_in(said, **values)
    assert message.is_in(said)
    assert Message("Files: {names}.csv")(names="a.") == "Files: a..csv"


@pytest.mark.parametrize(
    "catalogue",
    [path for path in CATALOGUES if path.parent.name != "cli"],
    ids=lambda path: str(path.parent.relative_to(SOURCE)),
)
def test_no_message_that_python_shows_too_names_an_option_of_the_command_line(
    catalogue: Path,
) -> None:
    for name, message in messages_of(catalogue).items():
        # Within a whole command, an option is true everywhere.
        others = f"{message.text} {message.remedy}"
        others = re.sub(r"'grainfit [^']*'|(docker run|createdb) .*", "", others)
        assert " --" not in others, name
        assert "(--" not in others, name
