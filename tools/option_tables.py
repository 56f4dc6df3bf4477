"""Write the tables of options in docs/reference/calibration_file from their declarations.

Instruments are in docs/instruments.md, from their files, and checks in docs/command_line.md.

python tools/option_tables.py

Responses and options of each built-in test, the options of the [strategy] section, and those of
particle size distributions, stand between two comments of a page each; a new test gets its page.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from pathlib import Path

from grainfit.bulk_tests.instrument import Instrument, instrument_names, read_instrument
from grainfit.bulk_tests.registry import BUILT_IN, OWN_SCENE
from grainfit.calibration_file.checks.registry import all_checks
from grainfit.calibration_file.strategy_section import CALIBRATION_KEYS
from grainfit.formatting import unit_for_people
from grainfit.materials.diameters import DISTRIBUTION
from grainfit.materials.size_distributions import LogNormal, RosinRammler
from grainfit.options.fields import option_keys
from grainfit.options.kinds import Choice, Quantity, Whole
from grainfit.options.tables import Key
from grainfit.solvers.file_entry import TestType
from grainfit.solvers.registry import types_of_test
from grainfit.strategies.registry import DEFAULT_STRATEGY, strategies

DOCS = Path(__file__).parents[1] / "docs"
FOLDER = DOCS / "reference" / "calibration_file"
TESTS = {**BUILT_IN, OWN_SCENE.type: OWN_SCENE}
_NONE = "–"
_PARTS = re.compile(r"(?<=Parts: )\w+(, \w+)*(?=\.)")
_STRATEGY, _SIZES, _INSTRUMENTS = "[strategy]", "particle sizes", "instruments"
_CHECKS = "checks"


def pages() -> dict[Path, str]:
    """Return every page that has such tables, as the options are declared now."""
    written = {
        FOLDER / "particle.md": (_SIZES, _size_tables()),
        FOLDER / "strategy.md": (_STRATEGY, _strategy_tables()),
        DOCS / "instruments.md": (_INSTRUMENTS, _instruments()),
        DOCS / "command_line.md": (_CHECKS, _checks()),
    }
    written |= {page_of(name): (name, _test_tables(types_of_test()[name])) for name in TESTS}
    return {page: _with_tables(page, *tables) for page, tables in written.items()}


def page_of(name: str) -> Path:
    """Return the page of a test."""
    return FOLDER / "tests" / f"{name}.md"


def _with_tables(page: Path, name: str, tables: str) -> str:
    begin, end = f"<!-- {name}: written by tools/option_tables.py -->", f"<!-- end of {name} -->"
    if page.is_file():
        text = page.read_text(encoding="utf-8")
    else:
        title = f'# `type = "{name}"`: {TESTS[name].title}' if name in TESTS else ""
        text = f"{title}\n\n{begin}\n{end}\n"
    to_docs = "../" * len(page.relative_to(DOCS).parent.parts)
    linked = re.sub(r"\]\((?=\w+\.md)", f"]({to_docs}", tables)
    pattern = f"{re.escape(begin)}.*{re.escape(end)}"
    return re.sub(pattern, lambda _: f"{begin}\n\n{linked}\n\n{end}", text, flags=re.DOTALL)


def _checks() -> str:
    rows = ((f"`{check.name}`", str(check.severity), check.about) for check in all_checks())
    return _table(("check", "severity", "finds"), rows)


def _instruments() -> str:
    return "\n\n".join(_instrument(read_instrument(name)) for name in instrument_names())


def _instrument(instrument: Instrument) -> str:
    options = (
        (f"`{key} = {it.toml}`", re.sub(r"(https://\S+)", r"<\1>", it.source))
        for key, it in instrument.options.items()
    )
    prints = (
        (printed.name, f"`{printed.response}`" if printed.response else _NONE, printed.remark)
        for printed in instrument.prints
    )
    return "\n\n".join(
        [
            f"## `{instrument.name}`: {instrument.title}",
            f'`type = "{instrument.type}"`. {" ".join(instrument.procedure)}',
            _table(("dimension", "source"), options),
            _table(("the report prints", "response", ""), prints),
        ]
    )


def _test_tables(kind: TestType) -> str:
    assert kind.bulk_test is not None
    responses = [
        (f"`{name}`", unit_for_people(info.unit) or _NONE, f"{info.words}.")
        for name, info in kind.bulk_test.responses.items()
    ]
    responses += [
        (f"`{name}`", unit_for_people(info.unit) or _NONE, f"Curve: {info.description}.")
        for name, info in kind.bulk_test.curves.items()
    ]
    options = (
        (
            f"`{key.name}`",
            _possible(key),
            "required" if key.required else key.default or _NONE,
            _PARTS.sub(lambda parts: re.sub(r"(\w+)", r"`\1`", parts[0]), key.description),
        )
        for key in kind.keys
    )
    table = _table(("key", "possible", "default", "meaning"), options)
    if not kind.bulk_test.responses:
        return f"Responses are those that your own function returns.\n\n{table}"
    words = "Give a target for one of them, or for several."
    return "\n\n".join([_table(("response", "unit", "meaning"), responses), words, table])


def _possible(key: Key) -> str:
    kind = key.kind
    if isinstance(kind, Choice):
        return ", ".join(f'`"{word}"`' for word in kind.options)
    if isinstance(kind, Quantity | Whole):
        return kind.limits()
    return _NONE


def _size_tables() -> str:
    """Return the tables of the options of a particle size distribution, then of each form."""
    parts = [_key_table(DISTRIBUTION.keys)]
    for form in (LogNormal, RosinRammler):
        parts += [f"`{form.key} = {{ ... }}`", _key_table(option_keys(form))]
    return "\n\n".join(parts)


def _strategy_tables() -> str:
    """Return the tables of the options of every calibration, then of each strategy."""
    words = "How runs are chosen, see [the method](method.md)."
    name = ("`name`", f'`"{DEFAULT_STRATEGY}"`', words)
    parts = [_strategy_table(CALIBRATION_KEYS, name)]
    for strategy in strategies().values():
        summary = (strategy.__doc__ or "").splitlines()[0]
        parts += [
            f'`name = "{strategy.name}"`. {summary}',
            _strategy_table(option_keys(strategy)),
        ]
    return "\n\n".join(parts)


def _key_table(keys: Iterable[Key]) -> str:
    rows = (
        (f"`{key.name}`", f"`{key.example}`", key.default or _NONE, key.description) for key in keys
    )
    return _table(("key", "such as", "default", "meaning"), rows)


def _strategy_table(keys: Iterable[Key], *first: tuple[str, ...]) -> str:
    rows = ((f"`{key.name}`", key.default, key.description) for key in keys)
    return _table(("key", "default", "meaning"), [*first, *rows])


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [_line(head), "|---" * len(head) + "|", *map(_line, rows)]
    return "\n".join(lines)


def _line(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Write the pages."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    for page, text in pages().items():
        page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
