"""Layout of the whole calibration file, and the rules that span its sections."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration_file import messages
from grainfit.calibration_file.cluster import CLUSTER, cluster_options
from grainfit.calibration_file.parameters import FixedOrFree, OwnParameter
from grainfit.calibration_file.strategy_section import StrategySection, strategy_keys
from grainfit.calibration_file.tests_section import Tests, with_instrument
from grainfit.calibration_file.walls import TestWalls, WallTable, declared_walls, note_unused_walls
from grainfit.contact_models.base import Kind
from grainfit.contact_models.registry import (
    MATERIAL_PARAMETERS,
    default_models,
    inactive_parameters,
    no_effect,
    non_default_models,
    selectable_models,
)
from grainfit.errors import InputError
from grainfit.materials.diameters import Diameters
from grainfit.materials.parameters import MaterialParameter
from grainfit.materials.particle_shape import ASPECT_RATIO, FAMILIES, aspect_ratio_faults
from grainfit.materials.shape_option import Shapes
from grainfit.materials.sizes import LARGEST_FACTOR, ParticleSizes
from grainfit.materials.walls import PLAIN, WALL_SECTIONS, on_wall, plain_name, wall_of
from grainfit.options.kinds import Choice, Quantity, Text
from grainfit.options.kinds import Kind as OptionKind
from grainfit.options.places import Findings, Place, show
from grainfit.options.tables import Key, Named, Table, Values
from grainfit.problem import Parameter
from grainfit.solvers.own_model.prime_seed import PRIME_SEEDS
from grainfit.solvers.registry import types_of_test

MATERIAL_SECTIONS = {
    "particle": "The particles.",
    "wall": "The walls; [wall.NAME] is a wall with a name.",
    "particle_particle": "Contacts between particles.",
    "particle_wall": "Contacts between particles and walls; [particle_wall.NAME] with one of them.",
}
_DIAMETER, _SHAPE, _FACTOR = "diameter", "shape", "coarse_graining"
#: Keys of ``[particle]`` that make up the simulated particles, and are no parameters.
_PARTICLES = (_DIAMETER, _SHAPE, _FACTOR)
#: Sections of tests, each a list.
_TESTS = ("test", "holdout")
_KINDS: dict[Kind, str] = {
    "contact": "normal and tangential force",
    "cohesion": "cohesion",
    "rolling": "resistance to rolling",
}
#: Names that custom parameters cannot have: templates and decks of custom models already use them.
_RESERVED = (
    "seed",
    *PRIME_SEEDS,
    "parameters",
    *MATERIAL_SECTIONS,
    *(name.replace(".", "_") for name in MATERIAL_PARAMETERS),
)


def _material_key(parameter: MaterialParameter) -> Key:
    unit = f", {parameter.unit}" if parameter.unit else ""
    default = "" if parameter.default is None else f" {parameter.default:g} by default."
    if parameter.name == ASPECT_RATIO:
        # The default is that of spheres, which have no shape to give it for.
        default = " Required with a shape by name."
    return Key(
        parameter.key,
        FixedOrFree(parameter),
        f"{parameter.description}{unit}: a value, or {{ min, max }} when free.{default}",
        example=parameter.example,
    )


def _homes(wall: str = PLAIN) -> dict[str, str]:
    """Right sections of keys that users may put into a wrong one, in those of a wall."""
    homes = {
        **dict.fromkeys(_PARTICLES, "[particle]"),
        "name": "the top of the file, above all sections",
    }
    homes |= dict.fromkeys(strategy_keys(), "[strategy]")
    homes |= {key.name: "[cluster]" for key in CLUSTER}
    homes |= {key.name: "[[test]]" for test in BUILT_IN.values() for key in test.option_keys()}
    homes |= dict.fromkeys(
        ("type", "solver", "ranks", "timeout", "executable", "targets", "repeats"), "[[test]]"
    )
    homes["walls"] = "[[test]]"
    for name in MATERIAL_PARAMETERS:
        section, _, key = on_wall(name, wall).rpartition(".")
        homes[key] = f"{homes[key]} or [{section}]" if key in homes else f"[{section}]"
    return homes


def _material_table(section: str, wall: str = PLAIN) -> Table:
    keys = [
        _material_key(parameter.of_wall(wall) if wall else parameter)
        for parameter in MATERIAL_PARAMETERS.values()
        if parameter.section == section
    ]
    if section == "particle":
        diameter = Key(
            _DIAMETER,
            Diameters(),
            "Particle diameter, or a list of { value, mass_fraction }.",
            example='"10 mm"',
        )
        families = ", ".join(f"{name} ({f.words})" for name, f in FAMILIES.items())
        shape = Key(
            _SHAPE,
            Shapes(),
            f"Particles that are clumps of spheres: {families}, or {{ spheres = [...] }}; the "
            "diameter is that of a sphere of equal volume.",
            default="none: particles are spheres",
            example='"two_spheres"',
        )
        factor = Key(
            _FACTOR,
            Quantity("", lowest=1.0, highest=LARGEST_FACTOR),
            "Simulated particles are this many times as large as the real ones, in the same "
            "geometry.",
            default="1",
            example="2",
        )
        keys[:0] = [diameter, shape, factor]
    return Table(tuple(keys), homes=_homes(wall))


def _material_kind(section: str) -> OptionKind:
    """Return the layout of a section: walls can have names."""
    table = _material_table(section)
    if section not in WALL_SECTIONS:
        return table
    reserved = [p.key for p in MATERIAL_PARAMETERS.values() if p.section in WALL_SECTIONS]
    return WallTable(table, partial(_material_table, section), (*MATERIAL_SECTIONS, *reserved))


def _contact_model_keys() -> tuple[Key, ...]:
    return tuple(
        Key(
            kind,
            Choice(names),
            f"Model of {_KINDS[kind]}.",
            default=_usual_words(kind),
            example=f'"{next(name for name in names if name not in default_models(kind))}"',
        )
        for kind, names in selectable_models().items()
    )


def _usual_words(kind: Kind) -> str:
    usual = " or ".join(f'"{name}"' for name in default_models(kind))
    return usual if len(default_models(kind)) == 1 else f"{usual}, by the parameter given"


LAYOUT = Table(
    (
        Key("name", Text(), "Name of the calibration, for people.", True, '"glass beads"'),
        *(
            Key(section, _material_kind(section), description)
            for section, description in MATERIAL_SECTIONS.items()
        ),
        Key(
            "parameters",
            Named(OwnParameter(), reserved=_RESERVED),
            "Further parameters, of your own model.",
        ),
        Key(
            "contact_models",
            Table(_contact_model_keys(), homes=_homes()),
            "Contact models that replace the usual ones; all optional.",
        ),
        Key("test", Tests(), "The bulk tests that were measured."),
        Key(
            "holdout",
            Tests("holdout"),
            "Tests that take no part in the fit, and are predicted afterwards.",
        ),
        Key(
            "strategy",
            StrategySection(_homes()),
            "Strategy and options of the search; all optional.",
        ),
        Key(
            "cluster",
            Table(CLUSTER, cluster_options, _homes()),
            "Cluster jobs for the runs; without it, they run on this machine.",
        ),
    ),
    homes=_homes(),
)


#: Layout of a file from before the laboratory.
PLANNED_LAYOUT = replace(
    LAYOUT,
    keys=tuple(
        replace(key, kind=Tests("plan")) if key.name == "test" else key for key in LAYOUT.keys
    ),
)


def read_document(document: dict[str, Any], place: Place, *, planned: bool = False) -> Values:
    """Read a whole file and note every fault.

    Parameters
    ----------
    document : dict
        As returned by `tomllib`.
    place : Place
        The top of the file.
    planned : bool
        Whether measured values may be missing.
    """
    values: Values = (PLANNED_LAYOUT if planned else LAYOUT).read(document, place)
    if "test" not in document:
        place.at("test").fault(messages.NO_TEST)
    _note_names_of_holdouts(document, place)
    simulated = _simulated(document)
    if simulated:
        declared = declared_walls(values)
        for one in simulated:
            one.note_faults(declared, place)
        _note_missing_material(simulated, values, place)
        _note_parameters_without_effect(values, place)
        _note_impossible_shape(values, place)
        _note_impossible_tests(simulated, values, place)
        if len(simulated) == sum(len(document.get(section, ())) for section in _TESTS):
            _note_useless_parameters(simulated, values, place)
            note_unused_walls([w for one in simulated for w in one.used(declared)], values, place)
    if not any(isinstance(value, Parameter) or value is None for value in _parameters(values)):
        place.fault(messages.NOTHING_FREE)
    return values


def chosen_models(values: Values) -> tuple[str, ...]:
    """Return the contact models that a file chooses, without those that act anyway."""
    return non_default_models(_named_models(values))


def _named_models(values: Values) -> tuple[str, ...]:
    table = values.get("contact_models") or {}
    return tuple(name for name in table.values() if name is not None)


def simulated_sizes(values: Values) -> ParticleSizes | None:
    """Return the sizes of the simulated particles; None where a file has none, or faulty ones."""
    particle = values.get("particle") or {}
    sizes: ParticleSizes | None = particle.get(_DIAMETER)
    factor, shape = particle.get(_FACTOR, 1.0), particle.get(_SHAPE)
    if sizes is None or factor is None or (_SHAPE in particle and shape is None):
        return None
    return replace(sizes, shape=shape).coarse_grained(factor)


def material_values(values: Values) -> Values:
    """Return what the sections of the material hold, by dotted name; None where it is faulty.

    Sizes are no values of parameters: they are those of `simulated_sizes`.
    """
    found: Values = {}
    for section in MATERIAL_SECTIONS:
        for key, value in (values.get(section) or {}).items():
            if isinstance(value, dict):
                found |= {f"{section}.{key}.{own}": entry for own, entry in value.items()}
            elif section != "particle" or key not in _PARTICLES:
                found[f"{section}.{key}"] = value
    return found


def _parameters(values: Values) -> list[Any]:
    """Values of all material and own parameters; None where one, or a section, is faulty."""
    own = values.get("parameters", {})
    found = [*material_values(values).values()]
    found += [None] if own is None else own.values()
    return found + [None for section in MATERIAL_SECTIONS if values.get(section, {}) is None]


def _simulated(document: dict[str, Any]) -> list[TestWalls]:
    """Return the bulk tests of a file, hold-outs included."""
    known = {name: kind.bulk_test for name, kind in types_of_test().items()}
    tables = {section: document.get(section) for section in _TESTS}
    return [
        TestWalls(index, test, table, section)
        for section, tests in tables.items()
        if isinstance(tests, list)
        for index, table in enumerate(tests)
        if isinstance(table, dict)
        and isinstance(table.get("type"), str)
        and (test := known.get(table["type"])) is not None
    ]


def _note_names_of_holdouts(document: dict[str, Any], place: Place) -> None:
    """Note hold-outs with the name of a fitted test: their runs and responses go by it."""
    names: dict[str, list[Any]] = {}
    for section in _TESTS:
        tables = document.get(section)
        names[section] = [
            table.get("name", table.get("type")) if isinstance(table, dict) else None
            for table in (tables if isinstance(tables, list) else ())
        ]
    for index, name in enumerate(names["holdout"]):
        if isinstance(name, str) and name in names["test"]:
            place.at("holdout", index, "name").fault(messages.NAME_OF_A_TEST, name=show(name))


def _words(simulated: list[TestWalls]) -> str:
    names = list(dict.fromkeys(one.test.type for one in simulated))
    return f"the {' and the '.join(names)} test{'s' if len(names) > 1 else ''}"


def _note_missing_material(simulated: list[TestWalls], values: Values, place: Place) -> None:
    without_effect = inactive_parameters(chosen_models(values))
    declared = declared_walls(values)
    needed = {
        on_wall(name, wall)
        for one in simulated
        for name, parameter in MATERIAL_PARAMETERS.items()
        if parameter.default is None and name not in without_effect
        for wall in ([PLAIN] if wall_of(name) is None else one.used(declared))
    }
    named = [wall for wall in declared if wall != PLAIN]
    for section in MATERIAL_SECTIONS:
        for wall in (PLAIN, *(named if section in WALL_SECTIONS else ())):
            path = (section, wall) if wall else (section,)
            keys = [
                key
                for key in _material_table(section, wall).keys
                if key.name == _DIAMETER or on_wall(f"{section}.{key.name}", wall) in needed
            ]
            _note_missing_keys(path, keys, simulated, values, place)


def _note_missing_keys(
    path: tuple[str, ...],
    keys: list[Key],
    simulated: list[TestWalls],
    values: Values,
    place: Place,
) -> None:
    """Note a section that is missing, or keys that it lacks."""
    *around, last = path
    outer = values.get(around[0], {}) if around else values
    if not keys or outer is None:
        return
    if last not in outer:
        names = ", ".join(key.name for key in keys)
        words = _words(simulated)
        verb = "need" if words.endswith("s") else "needs"
        # A wall is looked for where its other section is.
        other = next((section for section in WALL_SECTIONS if section != path[0]), path[0])
        place.at(*path).fault(
            messages.NO_SECTION,
            what=words.capitalize(),
            verb=verb,
            section=".".join(path),
            names=names,
            near=(other, last) if around else (),
        )
    elif outer[last] is not None:
        for key in keys:
            if key.name not in outer[last]:
                key.note_missing(place.at(*path))


def _note_parameters_without_effect(values: Values, place: Place) -> None:
    # Those that would act anyway too: of a kind with several, the others are not meant.
    chosen = _named_models(values)
    without_effect = inactive_parameters(chosen)
    for name, value in sorted(material_values(values).items()):
        # What could not be read has been noted.
        if plain_name(name) in without_effect and value is not None:
            fault = no_effect(name, chosen)
            place.at(*name.split(".")).refuse(fault)


def _note_impossible_shape(values: Values, place: Place) -> None:
    """Note an aspect ratio that is missing, has no effect, or is out of the range of the shape."""
    particle = values.get("particle") or {}
    shape, given = particle.get(_SHAPE), ASPECT_RATIO.partition(".")[2]
    if _SHAPE in particle and shape is None:
        return
    if given not in particle:
        if shape is not None and shape.has_aspect_ratio:
            remedy = "Give a value, such as 1.5, or an interval { min = 1.0, max = 2.0 }."
            place.at("particle", given).fault(
                messages.MISSING_FOR_SHAPE, shape=shape, remedy=remedy
            )
        return
    ratio = particle[given]
    ends = (ratio.minimum, ratio.maximum) if isinstance(ratio, Parameter) else (ratio,)
    for end in ends:
        faults = [] if end is None else aspect_ratio_faults(shape, end)
        for fault in faults:
            place.at("particle", given).refuse(fault)
        if faults:
            return


def _note_useless_parameters(simulated: list[TestWalls], values: Values, place: Place) -> None:
    words = _words(simulated)
    verb = "have" if words.endswith("s") else "has"
    for name in values.get("parameters") or ():
        place.at("parameters", name).fault(messages.PARAMETER_OF_NO_TEST, words=words, verb=verb)


def _note_impossible_tests(simulated: list[TestWalls], values: Values, place: Place) -> None:
    """Note impossible geometries, which only the test itself can find from sizes and options."""
    sizes = simulated_sizes(values)
    if sizes is None:
        return
    for one in simulated:
        # Faults of the instrument and of the single options are noted already.
        noted = Place(Findings(place.findings.folder))
        whole, _ = with_instrument(one.table, noted)
        keys = one.test.option_keys()
        given = {key.name: whole[key.name] for key in keys if key.name in whole}
        if any(key.required and key.name not in given for key in keys):
            continue
        options = Table(keys).read(given, noted)
        if None in options.values():
            continue
        try:
            one.test(sizes, **options)
        except InputError as error:
            for fault in error.faults:
                place.at(one.section, one.index, fault.key).refuse(fault)
