"""The published JSON Schema accepts what the program accepts, and knows every key."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from grainfit.calibration_file.layout import LAYOUT
from grainfit.calibration_file.schema import calibration_file_schema, schema_path
from grainfit.calibration_file.starter import starter_file
from grainfit.solvers.registry import types_of_test

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")
REFERENCE = Path(__file__).parents[2] / "docs" / "reference" / "calibration_file"

VALIDATOR = jsonschema.Draft202012Validator(calibration_file_schema())


def test_the_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(calibration_file_schema())


def test_the_packaged_schema_is_up_to_date() -> None:
    packaged = json.loads(schema_path().read_text(encoding="utf-8"))
    assert packaged == calibration_file_schema(), (
        "run: python -c 'from grainfit.calibration_file.schema import write_schema as w; w()'"
    )


def test_every_example_and_the_starter_file_are_accepted() -> None:
    texts = [path.read_text(encoding="utf-8") for path in EXAMPLES.rglob("*.toml")]
    for text in [*texts, starter_file()]:
        VALIDATOR.validate(tomllib.loads(text))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[wall]", "[walls]"),
        ("poissons_ratio = 0.22", "poisson_ratio = 0.22"),
        ("poissons_ratio = 0.22", "poissons_ratio = 0.6"),
        ("poissons_ratio = 0.22", "poissons_ratio = [0.1, 0.2]"),
        ("poissons_ratio = 0.22", "poissons_ratio = true"),
        ('diameter = "10 mm"', 'diameter = "wide"'),
        ("min = 0.449", "minimum = 0.449"),
        ("min = 0.449, max", "max"),
        ('type = "heap"', 'type = "heep"'),
        ('solver = "lammps"', 'solver = "lamps"'),
        ('solver = "lammps"', ""),
        ("targets.angle_of_repose", "targets.angle_of_rest"),
        ('value = "22 deg"', 'valu = "22 deg"'),
        ('value = "22 deg"', 'value = "22 deg", measurements = [1, 2]'),
        ('name = "glass beads"', ""),
        ("[[test]]", "[test]"),
    ],
)
def test_mistakes_are_rejected(old: str, new: str) -> None:
    assert GLASS_BEADS.count(old) == 1
    assert VALIDATOR.is_valid(tomllib.loads(GLASS_BEADS))
    assert not VALIDATOR.is_valid(tomllib.loads(GLASS_BEADS.replace(old, new)))


def keys_of(schema: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Every key with its schema, wherever in the file."""
    found = dict(schema.get("properties", {}))
    inner = [*found.values(), *schema.get("anyOf", []), *schema.get("oneOf", [])]
    inner += [schema[word] for word in ("items", "additionalProperties") if schema.get(word)]
    for part in inner:
        found |= keys_of(part)
    return found


def test_every_key_has_a_description_for_the_editor() -> None:
    keys = keys_of(LAYOUT.schema())
    assert len(keys) > 50
    assert [name for name, schema in keys.items() if not schema.get("description")] == []


def test_every_example_value_in_the_schema_is_good() -> None:
    for name, schema in keys_of(LAYOUT.schema()).items():
        for example in schema.get("examples", []):
            good = jsonschema.Draft202012Validator(schema).is_valid(example)
            assert good, f"{name}: the example {example!r} does not fit its own schema"


def test_every_key_is_in_the_reference() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in REFERENCE.rglob("*.md"))
    keys = keys_of(LAYOUT.schema())
    assert [key for key in keys if f"`{key}`" not in text and f"[{key}]" not in text] == []


def test_the_keys_of_all_tests_name_every_type() -> None:
    lines = (REFERENCE / "test.md").read_text(encoding="utf-8").splitlines()
    [row] = [line for line in lines if line.startswith("| `type` |") and "Required" in line]
    assert set(re.findall(r'`"(\w+)"`', row)) == set(types_of_test())
