"""Answers of the interview: each is one edit of the calibration file."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration_file.photographed import PHOTOS
from grainfit.calibration_file.starter import file_without_tests, starter_test
from grainfit.errors import Fault, InputError
from grainfit.interview import messages
from grainfit.interview.equipment import equipment, ways
from grainfit.interview.file_text import (
    note,
    with_note,
    with_test,
    with_value,
    without_test,
    without_value,
)
from grainfit.interview.measured import ERROR, MEASURED, read_measured
from grainfit.interview.pictures import OF_PICTURES, named_pictures, takes_pictures
from grainfit.materials.material_classes import class_of_words, material_classes
from grainfit.materials.particle_shape import FAMILIES
from grainfit.materials.starting_materials import (
    StartingMaterial,
    material_of_class,
    near_materials,
    read_starting_material,
)
from grainfit.materials.wall_friction import USUAL_FRICTION
from grainfit.messages import Message
from grainfit.options.kinds import Choice, Flag, Quantity
from grainfit.units import LONGEST_QUANTITY, UnitError, example_with, to_unit

#: Notes that the file keeps as comments.
MATERIAL, MOISTURE, AT_HAND, ASKED = "material", "moisture of the sample", "at hand", "asked"
SPHERE = "sphere"
#: Key of the size of simulated apparatus, and its answer where they are as in the laboratory.
TWINS, AS_MEASURED = "twins", "as measured"
_HEAD = """\
# Calibration file of grainfit, written by its interview. 'grainfit ask FILE' in a terminal and
# 'grainfit start FILE' in the browser go on with it, and an editor does as well.
"""
#: Largest surface energy of a search where the class says none, and aspect ratio to begin with.
_COHESION, _ASPECT_RATIO = "0.05 J/m^2", 1.5
_DIAMETER = "particle.diameter"
#: Keys of a target that say nothing was measured yet.
_WIDTHS = {"uncertainty", "systematic", "tolerance", "weight", "statistic", "unit"}
_BARE = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_ENDS = re.compile(r"\s*(?:\bto\b|\.\.+|[…–—−]|(?:\s|(?<=\d))-(?=\s*[\d.]))\s*")
_UNIT_OF_ANGLE = re.compile(r"deg|°|rad")


def material_of(text: str) -> StartingMaterial | None:
    """Return the material that a file begins with; None where a person wrote it."""
    name = note(text, MATERIAL)
    if name in (classes := material_classes()):
        return material_of_class(classes[name], tomllib.loads(text).get("name", name))
    try:
        return read_starting_material(name) if name else None
    except InputError:
        return None


def new_file(given: str, solver: str) -> str:
    """Return the file of a material, before any test.

    Raises
    ------
    InputError
        It is no starting material, and its name says no class.
    """
    title = " ".join(given.split())
    if not title:
        raise InputError(messages.NO_MATERIAL.fault(MATERIAL))
    if title in material_classes():
        material = material_of_class(material_classes()[title], title)
    else:
        try:
            material = read_starting_material(title)
        except InputError:
            known = class_of_words(title)
            if known is None:
                instead = near_materials(title)
                fault = messages.UNKNOWN_MATERIAL.fault(MATERIAL, given=title, instead=instead)
                raise InputError(fault) from None
            material = material_of_class(known, title)
    body = file_without_tests(replace(material, title=_quotable(title)), solver)
    return f"{_HEAD}#\n# {MATERIAL}: {material.name}\n#\n{body}"


def set_name(text: str, given: str) -> str:
    """Return the text with the name of its material."""
    return with_value(text, ("name",), _quoted(" ".join(given.split())))


def set_note(text: str, name: str, given: str) -> str:
    """Return the text with a note."""
    return with_note(text, name, given) if given or note(text, name) else text


def set_diameter(text: str, given: str) -> str:
    """Return the text with another diameter, sieve classes, or the table of a sieve analysis."""
    path = ("particle", "diameter")
    if re.search(r"\.(csv|tsv|txt|dat)$", given, re.IGNORECASE):
        return with_value(text, path, f"{{ sieve_curve = {_quoted(given)} }}")
    parts = [part.split(":") for part in re.split(r"[;\n]", given) if part.strip()]
    if len(parts) == 1 and len(parts[0]) == 1:
        return with_value(text, path, _diameter(given))
    if any(len(part) != 2 for part in parts) or not parts:
        raise InputError(messages.NO_SIZES.fault(_DIAMETER, given=given))
    classes = ", ".join(
        f"{{ value = {_diameter(size)}, mass_fraction = {_number(_DIAMETER, share)} }}"
        for size, share in parts
    )
    return with_value(text, path, f"[{classes}]")


def set_density(text: str, given: str) -> str:
    """Return the text with a known density of the particles, or an interval."""
    ends = _ends("particle.density", given, messages.NO_DENSITY)
    numbers = [_number("particle.density", end, "kg/m^3") for end in ends]
    return with_value(text, ("particle", "density"), _value_or_interval(numbers))


def set_aspect_ratio(text: str, given: str) -> str:
    """Return the text with a known aspect ratio of clumps, or an interval."""
    ends = _ends("particle.aspect_ratio", given, messages.NO_ASPECT_RATIO)
    numbers = [_number("particle.aspect_ratio", end) for end in ends]
    return with_value(text, ("particle", "aspect_ratio"), _value_or_interval(numbers))


def set_wall_friction(text: str, given: str) -> str:
    """Return the text with a friction on walls, or the angle at which the material slides."""
    path, key = ("particle_wall", "sliding_friction"), "particle_wall.sliding_friction"
    if not _UNIT_OF_ANGLE.search(given):
        numbers = [_number(key, end) for end in _ends(key, given, messages.NO_WALL_FRICTION)]
        for one in numbers:
            if _BARE.fullmatch(one) and float(one) > USUAL_FRICTION:
                fault = messages.ANGLE_OR_FRICTION.fault(key, given=one, most=USUAL_FRICTION)
                raise InputError(fault)
        return with_value(text, path, _value_or_interval(numbers))
    angle, *error = map(str.strip, ERROR.split(given))
    if len(error) > 1 or len(_ENDS.split(angle)) > 1:
        raise InputError(messages.NO_WALL_FRICTION.fault(key, given=given))
    entries = f"measured_angle = {_angle(key, angle)}"
    if error:
        entries += f", uncertainty = {_angle(key, error[0])}"
    return with_value(text, path, f"{{ {entries} }}")


def set_shape(text: str, given: str) -> str:
    """Return the text with a family of clumps, or with spheres."""
    [name] = _chosen("particle.shape", [given], (SPHERE, *FAMILIES))
    particle = tomllib.loads(text).get("particle", {})
    if name == SPHERE:
        for key in ("shape", "aspect_ratio"):
            if key in particle:
                text = without_value(text, ("particle", key))
        return text
    text = with_value(text, ("particle", "shape"), _quoted(name))
    if "aspect_ratio" not in particle:
        text = with_value(text, ("particle", "aspect_ratio"), str(_ASPECT_RATIO))
    return text


def set_cohesion(text: str, given: str) -> str:
    """Return the text with a free surface energy, or without one."""
    [answer] = _chosen("cohesion", [given], ("no", "yes"))
    section, key = "particle_particle", "surface_energy"
    is_there = key in tomllib.loads(text).get(section, {})
    if answer == "yes" and not is_there:
        material = material_of(text)
        largest = (material and material.material_class.cohesion) or _COHESION
        return with_value(text, (section, key), f"{{ min = 0, max = {_quoted(largest)} }}")
    if answer == "no" and is_there:
        return without_value(text, (section, key))
    return text


def set_twins(text: str, given: str) -> str:
    """Return the text with smaller apparatus in the search, or with those of the laboratory."""
    path = ("strategy", TWINS)
    if given != AS_MEASURED:
        return with_value(text, path, _number(f"strategy.{TWINS}", given))
    is_there = TWINS in tomllib.loads(text).get(path[0], {})
    return without_value(text, path) if is_there else text


def set_at_hand(text: str, given: str) -> str:
    """Return the text with a note of what the laboratory has."""
    names = _chosen(AT_HAND, given.split(","), equipment())
    return with_note(text, AT_HAND, ", ".join(names))


def at_hand(text: str) -> list[str]:
    """Return what the laboratory has, by the note."""
    return [name for part in note(text, AT_HAND).split(",") if (name := part.strip())]


def set_tests(text: str, given: str, solver: str) -> str:
    """Return the text with these tests; those that a person wrote stay as they are.

    Raises
    ------
    InputError
        One of them is not known, or one that is left out has measured values.
    """
    known = {way.name for way in ways(at_hand(text))}
    present = named_tests(text)
    if not known:
        raise InputError(messages.NO_TESTS.fault("tests"))
    wanted = _chosen("tests", given.split(","), (*known, *(name for name, _ in present)))
    for number in reversed(range(len(present))):
        name, test = present[number]
        if name in wanted or name not in known:
            continue
        if is_measured(test):
            raise InputError(messages.TEST_IS_MEASURED.fault("tests", name=name))
        text = without_test(text, number)
    names = {name for name, _ in present}
    for name in wanted:
        if name not in names:
            text = with_test(text, starter_test(name, material_of(text), solver))
    return text


def named_tests(text: str) -> list[tuple[str, dict[str, Any]]]:
    """Return the tests of a file, each with its name."""
    found = tomllib.loads(text).get("test", []) if text else []
    return [(str(one.get("name", one.get("type"))), one) for one in found if isinstance(one, dict)]


def coarse_graining(text: str) -> float:
    """Return how many times as large as the real ones the particles of a file are."""
    particle = tomllib.loads(text).get("particle", {}) if text else {}
    found = particle.get("coarse_graining", 1)
    return float(found) if isinstance(found, int | float) else 1.0


def is_measured(test: dict[str, Any]) -> bool:
    """Return whether a test of a file has a target with a value, a table or photographs."""
    targets = test.get("targets", {})
    return any(isinstance(one, dict) and one.keys() - _WIDTHS for one in targets.values())


def set_option(text: str, number: int, test: dict[str, Any], option: str, given: str) -> str:
    """Return the text with an option of a test."""
    kind = next(k.kind for k in BUILT_IN[test["type"]].option_keys() if k.name == option)
    key = f"test[{number}].{option}"
    if isinstance(kind, Flag):
        given = {"yes": "true", "no": "false"}.get(given, given)
        [toml] = _chosen(key, [given], ("true", "false"))
    elif isinstance(kind, Choice):
        toml = _quoted(given)
    else:
        toml = _number(key, given, kind.unit or "" if isinstance(kind, Quantity) else "")
    return with_value(text, ("test", number, option), toml)


def set_measured(text: str, number: int, test: dict[str, Any], response: str, given: str) -> str:
    """Return the text with what was measured; tolerance and weight of a target stay."""
    path = ("test", number, "targets", response)
    unit = BUILT_IN[test["type"]].responses[response].unit
    before = test.get("targets", {}).get(response)
    pictures = named_pictures(given) if takes_pictures(test["type"], response) else []
    target: dict[str, Any] = {PHOTOS: pictures}
    if not pictures:
        target = read_measured(f"{path[0]}[{number}].targets.{response}", given, unit).target()
    if before is None:
        pairs = ", ".join(f"{key} = {_value(value)}" for key, value in target.items())
        return with_value(text, path, f"{{ {pairs} }}")
    # Key by key, so that comments beside the others stay.
    for key, value in target.items():
        text = with_value(text, (*path, key), _value(value))
    for key in (*MEASURED, *(() if pictures else OF_PICTURES)):
        if key in before and key not in target:
            text = without_value(text, (*path, key))
    return text


def without_measured(text: str, number: int, test: dict[str, Any], response: str) -> str:
    """Return the text without a target."""
    if list(test["targets"]) == [response]:
        return without_value(text, ("test", number, "targets"))
    return without_value(text, ("test", number, "targets", response))


def _chosen(key: str, given: Iterable[str], known: Iterable[str]) -> list[str]:
    names = [name for part in given if (name := part.strip())]
    known = list(dict.fromkeys(known))
    for name in names:
        if name not in known:
            row = ", ".join(known)
            raise InputError(messages.NO_CHOICE.fault(key, given=name, known=row))
    if not names:
        raise InputError(messages.NO_CHOICE.fault(key, given="", known=", ".join(known)))
    return list(dict.fromkeys(names))


def _diameter(given: str) -> str:
    if len(_ENDS.split(given)) > 1:
        raise InputError(messages.NO_SIZES.fault(_DIAMETER, given=given))
    return _number(_DIAMETER, given, "m", "3 mm")


def _angle(key: str, given: str) -> str:
    return _number(key, f"{given} deg" if _BARE.fullmatch(given) else given, "deg")


def _number(key: str, given: str, unit: str = "", example: str = "") -> str:
    """Return a number or a quantity as TOML.

    A bare number would be in SI units, which nobody means who types it; of angles nobody takes
    them for another unit.
    """
    given = given.strip()
    if ERROR.search(given):
        raise InputError(messages.NO_ERROR_HERE.fault(key, given=given))
    if not _BARE.fullmatch(given) or len(given) > LONGEST_QUANTITY:
        try:
            to_unit(given, unit)
        except UnitError as error:
            raise InputError(Fault(key, error.message, error.remedy)) from None
        return _quoted(given)
    if unit not in ("", "deg"):
        example = example or example_with(unit)
        raise InputError(messages.NO_UNIT.fault(key, given=given, example=example))
    return repr(int(given) if given.lstrip("+-").isdecimal() else float(given))


def _ends(key: str, given: str, refused: Message) -> list[str]:
    """Return a value, or both ends of an interval, the lower one with the unit of the other."""
    ends = _ENDS.split(given)
    if len(ends) > 2 or not all(ends) or ERROR.search(given):
        raise InputError(refused.fault(key, given=given))
    if len(ends) == 2 and _BARE.fullmatch(ends[0]):
        unit = re.sub(rf"^{_BARE.pattern}", "", ends[1]).strip()
        ends[0] = f"{ends[0]} {unit}".strip()
    return ends


def _value_or_interval(numbers: list[str]) -> str:
    """Return a value, or the interval between two, as TOML."""
    return numbers[0] if len(numbers) == 1 else f"{{ min = {numbers[0]}, max = {numbers[1]} }}"


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_value(one)}' for key, one in value.items())} }}"
    return json.dumps(value, ensure_ascii=False)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _quotable(title: str) -> str:
    """Return a title that a line of TOML takes as it is."""
    return re.sub(r'["\\\x00-\x1f\x7f]', " ", title)
