"""Questions of the interview, from the calibration file as it is."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration_file.targets import TargetTable
from grainfit.formatting import number, unit_for_people, with_unit
from grainfit.interview import messages
from grainfit.interview.answers import (
    AS_MEASURED,
    ASKED,
    MATERIAL,
    MOISTURE,
    SPHERE,
    TWINS,
    at_hand,
    material_of,
    named_tests,
)
from grainfit.interview.equipment import Way, equipment, way_of, ways
from grainfit.interview.file_text import note
from grainfit.interview.measured import typed
from grainfit.interview.pictures import is_of_pictures, on_pictures, overlays, takes_pictures
from grainfit.materials.particle_shape import FAMILIES
from grainfit.options.kinds import Choice, Flag
from grainfit.options.places import Findings, Place
from grainfit.options.tables import Key
from grainfit.problem import Target
from grainfit.units import example_with

_REPEATS = (
    "Repeats with their unit, and after ± what is wrong in all of them alike: "
    '"31; 32.5; 30 deg ± 0.5 deg". Of one value, ± is its uncertainty.'
)
_OR_PICTURES = (
    "Or pictures, each of a heap of its own, with the marker sheet or a round plate below it: "
    "heap_1.jpg; heap_2.jpg."
)
_DESCRIBED = {"no": "it falls apart", "yes": "it clings: fine or damp"}


@dataclass(frozen=True)
class Question:
    """A question, with the answer that the file has.

    Parameters
    ----------
    key : str
        Its name, such as ``"diameter"`` or ``"heap.targets.angle_of_repose"``.
    text : str
        The question.
    help : str
        What to give, and why it matters.
    group : str
        ``"material"``, ``"laboratory"``, ``"simulation"``, or the name of a test.
    answer : str
        The answer in the file, as one would type it; empty without one.
    options : mapping of str to str
        Names to choose from, with their meaning; empty for free text.
    several : bool
        Whether several of them can be chosen, with commas.
    usual : str
        In words, what holds without an answer.
    implies : str
        What the answer means: mean and uncertainty of repeats.
    entry : str
        How to type the answer, where several questions have it alike.
    takes_pictures : bool
        Whether photographs are an answer.
    overlays : tuple of str
        Pictures on which is drawn what was measured on those of the answer.
    is_asked : bool
        Whether it was answered, or passed over.
    """

    key: str
    text: str
    help: str = ""
    group: str = "material"
    answer: str = ""
    options: Mapping[str, str] = field(default_factory=dict)
    several: bool = False
    usual: str = ""
    implies: str = ""
    entry: str = ""
    takes_pictures: bool = False
    overlays: tuple[str, ...] = ()
    is_asked: bool = False


def questions_of(text: str, file: Path) -> Iterator[Question]:
    """Yield all questions that the text of a file leads to, in their order."""
    data = tomllib.loads(text) if text else {}
    asked = note(text, ASKED).split()
    found = [*_of_material(text, data)]
    if text:
        found += [*_of_laboratory(text)]
        for number, (name, test) in enumerate(named_tests(text)):
            found += [*_of_test(name, test, number, file)]
        found += [*_of_simulation(text, data)]
    for one in found:
        yield Question(**{**vars(one), "is_asked": one.key in asked})


def _of_material(text: str, data: Mapping[str, Any]) -> Iterator[Question]:
    yield Question(
        MATERIAL,
        "Which material is it?",
        "One of 'grainfit materials', a synonym, or any name that says the class: wood pellets, "
        "fine sand, whey powder. Published values come with their sources, else usual ranges.",
        answer=str(data.get("name", "")),
    )
    if not text:
        return
    particle, material = data.get("particle", {}), material_of(text)
    yield Question(
        "moisture",
        "How moist is it?",
        'Such as "12 % wet basis": a note for people. Published values hold for a moisture.',
        answer=note(text, MOISTURE),
        usual=material.moisture if material else "",
    )
    if "diameter" in particle:
        yield Question(
            "diameter",
            "How large are the particles?",
            'A diameter, "3 mm"; sieve classes by mass, "2 mm: 40 %; 3 mm: 60 %"; or the table of '
            "a sieve analysis, sieve.csv. Of particles that are no spheres, the diameter of a "
            "sphere of the same volume.",
            answer=_diameter(particle["diameter"]),
        )
        yield Question(
            "shape",
            "What shape are they?",
            "Spheres are fast: rolling friction stands for the shape then. Clumps take several "
            "times as long.",
            answer=_shape(particle.get("shape", SPHERE)),
            options={SPHERE: "a sphere", **{name: f.words for name, f in FAMILIES.items()}},
        )
    if isinstance(particle.get("shape"), str):
        yield Question(
            "aspect_ratio",
            "What is their aspect ratio?",
            "Largest extent over width, as on a photograph.",
            answer=_interval(particle.get("aspect_ratio", "")),
        )
    if "density" in particle:
        yield Question(
            "density",
            "Which density have the particles themselves?",
            'Of a pycnometer, "950 kg/m^3"; or the interval to search, "850 to 1050 kg/m^3". Not '
            "the bulk density.",
            answer=_interval(particle["density"]),
        )
    wall = data.get("particle_wall", {})
    if "sliding_friction" in wall:
        yield Question(
            "wall_friction",
            "At which angle does the material slide on your wall?",
            'Tilt a plate of the wall: "21 deg ± 1 deg"; or the friction itself, "0.35".',
            answer=_wall(wall["sliding_friction"]),
        )
    yield Question(
        "cohesion",
        "Does a handful keep its shape when you squeeze it?",
        "Dry and coarse material does not. If it does, cohesion is one more free parameter, and a "
        "shear tester is worth its price.",
        answer="yes" if "surface_energy" in data.get("particle_particle", {}) else "no",
        options=_DESCRIBED,
    )


def _of_laboratory(text: str) -> Iterator[Question]:
    yield Question(
        "at_hand",
        "What is at hand?",
        "It decides which tests can be measured. Known instruments bring their dimensions.",
        "laboratory",
        ", ".join(at_hand(text)),
        equipment(),
        several=True,
    )
    present = named_tests(text)
    possible = {way.name: _words(way) for way in ways(at_hand(text))}
    own = {name: "in the file" for name, _ in present if name not in possible}
    if possible or own:
        yield Question(
            "tests",
            "Which tests do you measure?",
            "Two that differ settle more than one that is measured often: something at rest and "
            "something that flows.",
            "laboratory",
            ", ".join(name for name, _ in present),
            {**possible, **own},
            several=True,
        )


def _words(way: Way) -> str:
    responses = ", ".join(name.replace("_", " ") for name in way.responses)
    return f"{way.title}: {responses}"


def _of_test(name: str, test: Mapping[str, Any], number: int, file: Path) -> Iterator[Question]:
    kind, way = BUILT_IN.get(str(test.get("type"))), _way(name, test)
    if kind is None or way is None:
        return
    keys = {key.name: key for key in kind.option_keys()}
    for option in way.options_of(test):
        yield _of_option(name, keys[option], test)
    targets = test.get("targets", {})
    listed = [*way.responses, *(r for r in targets if r in kind.responses)]
    for response in dict.fromkeys(listed):
        info, target = kind.responses[response], targets.get(response, {})
        pictures = takes_pictures(test["type"], response)
        found = None
        if is_of_pictures(target):
            place = ("test", number, "targets", response)
            found = on_pictures(file, place, test["type"], target)
        yield Question(
            f"{name}.targets.{response}",
            f"{info.words.partition(':')[0]}, measured{_such_as(info.unit)}:",
            f"{info.words}.{f' {_OR_PICTURES}' if pictures else ''}",
            name,
            typed(target),
            usual="not measured",
            implies="\n".join((found.result, *found.found))
            if found
            else implied(response, test["type"], target),
            entry=_REPEATS,
            takes_pictures=pictures,
            overlays=tuple(map(str, overlays(found))) if found else (),
        )


def _of_simulation(text: str, data: Mapping[str, Any]) -> Iterator[Question]:
    if not named_tests(text):
        return
    yield Question(
        TWINS,
        "How large are the simulated apparatus?",
        "A bucket of small particles takes hours a run. Smaller apparatus of the same form take "
        "seconds: they are searched with, the real ones are predicted from a series of sizes, and "
        "one run of each verifies them afterwards.",
        "simulation",
        str(data.get("strategy", {}).get("twins", AS_MEASURED)),
        {
            AS_MEASURED: "for small ones",
            "1500": "particles at most, smaller than in the laboratory: fast",
            "3000": "particles at most: slower, and nearer to the real ones",
        },
    )


def _such_as(unit: str) -> str:
    return f" (such as {example_with(unit)})" if unit else ""


def _way(name: str, test: Mapping[str, Any]) -> Way | None:
    return way_of(str(test.get("type")), str(test.get("apparatus", "")), name)


def _of_option(name: str, key: Key, test: Mapping[str, Any]) -> Question:
    key, options = key.in_words(), {}
    if isinstance(key.kind, Choice):
        options = dict.fromkeys(key.kind.options, "")
    elif isinstance(key.kind, Flag):
        options = {"true": "yes", "false": "no"}
    value = test.get(key.name, "")
    return Question(
        f"{name}.{key.name}",
        f"{key.name.replace('_', ' ').capitalize()}:",
        key.description,
        name,
        str(value).lower() if isinstance(value, bool) else str(value),
        options,
        usual=key.default.replace('"', ""),
    )


def implied(response: str, test: str, target: Any) -> str:
    """Return what a target means: mean, standard uncertainty, and tolerance."""
    if not isinstance(target, dict) or not typed(target) or is_of_pictures(target):
        return ""
    info = BUILT_IN[test].responses[response]
    found = TargetTable(info.possible).read(target, Place(Findings(), (response,)))
    if not isinstance(found, Target):
        return ""
    unit = unit_for_people(info.unit)
    shown = {
        "value": with_unit(number(found.value), unit),
        "error": with_unit(number(found.standard_uncertainty, 2), unit),
        "width": f"± {with_unit(number(found.tolerance, 2), unit)}",
    }
    if "measurements" in target:
        return messages.REPEATS(count=len(target["measurements"]), **shown)
    return f"{messages.ONE_VALUE(**shown)} {messages.REPEAT_IT()}"


def _diameter(value: Any) -> str:
    if isinstance(value, list):
        return "; ".join(f"{one.get('value')}: {one.get('mass_fraction')}" for one in value)
    if isinstance(value, dict):
        return str(value.get("sieve_curve", "a distribution, in the file"))
    return str(value)


def _shape(value: Any) -> str:
    return value if isinstance(value, str) else "spheres of its own, in the file"


def _interval(value: Any) -> str:
    if isinstance(value, dict):
        return f"{value.get('min')} to {value.get('max')}"
    return str(value)


def _wall(value: Any) -> str:
    if isinstance(value, dict) and "photos" in value:
        return "measured on photographs"
    if isinstance(value, dict) and "measured_angle" in value:
        error = value.get("uncertainty", "")
        return f"{value['measured_angle']}{f' ± {error}' if error else ''}"
    return _interval(value)
