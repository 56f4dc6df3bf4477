"""Layout of the whole calibration file, and the rules that span its sections."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration_file.cluster import CLUSTER, cluster_options
from grainfit.calibration_file.parameters import FixedOrFree, OwnParameter
from grainfit.calibration_file.strategy_section import StrategySection, strategy_keys
from grainfit.calibration_file.tests_section import Tests
from grainfit.contact_models.base import Kind
from grainfit.contact_models.registry import (
    MATERIAL_PARAMETERS,
    no_effect,
    parameters_without_effect,
    selectable_models,
    unusual_models,
)
from grainfit.errors import InputError
from grainfit.materials.diameters import Diameters
from grainfit.materials.parameters import MaterialParameter
from grainfit.materials.sizes import LARGEST_FACTOR, ParticleSizes
from grainfit.options.kinds import Choice, Quantity, Text
from grainfit.options.places import Findings, Place
from grainfit.options.tables import Key, Named, Table, Values
from grainfit.problem import Parameter
from grainfit.solvers.own_model.prime_seed import PRIME_SEEDS
from grainfit.solvers.registry import types_of_test

MATERIAL_SECTIONS = {
    "particle": "The particles.",
    "wall": "The walls, all of one material.",
    "particle_particle": "Contacts between particles.",
    "particle_wall": "Contacts between particles and walls.",
}
_DIAMETER, _FACTOR = "diameter", "coarse_graining"
#: Keys of ``[particle]`` that make up the sizes of the simulated particles.
SIZES = (_DIAMETER, _FACTOR)
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
    return Key(
        parameter.key,
        FixedOrFree(parameter),
        f"{parameter.description}{unit}: a value, or {{ min, max }} when free.{default}",
        example=parameter.example,
    )


def _homes() -> dict[str, str]:
    """Right sections of keys that users may put into a wrong one."""
    homes = {
        **dict.fromkeys(SIZES, "[particle]"),
        "name": "the top of the file, above all sections",
    }
    homes |= dict.fromkeys(strategy_keys(), "[strategy]")
    homes |= {key.name: "[cluster]" for key in CLUSTER}
    homes |= {key.name: "[[test]]" for test in BUILT_IN.values() for key in test.option_keys()}
    homes |= dict.fromkeys(
        ("solver", "ranks", "timeout", "executable", "targets", "repeats"), "[[test]]"
    )
    for name in MATERIAL_PARAMETERS:
        section, _, key = name.partition(".")
        homes[key] = f"{homes[key]} or [{section}]" if key in homes else f"[{section}]"
    return homes


def _material_table(section: str) -> Table:
    keys = [
        _material_key(parameter)
        for name, parameter in MATERIAL_PARAMETERS.items()
        if name.startswith(f"{section}.")
    ]
    if section == "particle":
        diameter = Key(
            _DIAMETER,
            Diameters(),
            "Particle diameter, or a list of { value, mass_fraction }.",
            example='"10 mm"',
        )
        factor = Key(
            _FACTOR,
            Quantity("", lowest=1.0, highest=LARGEST_FACTOR),
            "Simulated particles are this many times as large as the real ones, in the same "
            "geometry.",
            default="1",
            example="2",
        )
        keys[:0] = [diameter, factor]
    return Table(tuple(keys), homes=_homes())


def _contact_model_keys() -> tuple[Key, ...]:
    return tuple(
        Key(
            kind,
            Choice(names),
            f"Model of {_KINDS[kind]}.",
            default=f'"{names[0]}"',
            example=f'"{names[1]}"',
        )
        for kind, names in selectable_models().items()
    )


LAYOUT = Table(
    (
        Key("name", Text(), "Name of the calibration, for people.", True, '"glass beads"'),
        *(
            Key(section, _material_table(section), description)
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
        replace(key, kind=Tests(planned=True)) if key.name == "test" else key for key in LAYOUT.keys
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
        place.at("test").fault("is missing.", "Add a section [[test]] with type and targets.")
    simulated = _simulated(document)
    if simulated:
        _note_missing_material(simulated, values, place)
        _note_parameters_without_effect(values, place)
        _note_impossible_tests(simulated, values, place)
        if len(simulated) == len(document["test"]):
            _note_useless_parameters(simulated, values, place)
    if not any(isinstance(value, Parameter) or value is None for value in _parameters(values)):
        place.fault(
            "there is no free parameter, so there is nothing to calibrate.",
            "Give at least one an interval, for example "
            'particle.density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }.',
        )
    return values


def chosen_models(values: Values) -> tuple[str, ...]:
    """Return the contact models that a file chooses, without those that act anyway."""
    table = values.get("contact_models") or {}
    return unusual_models(name for name in table.values() if name is not None)


def simulated_sizes(values: Values) -> ParticleSizes | None:
    """Return the sizes of the simulated particles; None where a file has none, or faulty ones."""
    particle = values.get("particle") or {}
    sizes: ParticleSizes | None = particle.get(_DIAMETER)
    factor = particle.get(_FACTOR, 1.0)
    return None if sizes is None or factor is None else sizes.coarse_grained(factor)


def _parameters(values: Values) -> list[Any]:
    """Values of all material and own parameters; None where one, or a section, is faulty."""
    found: list[Any] = []
    for section in (*MATERIAL_SECTIONS, "parameters"):
        table = values.get(section, {})
        found += [None] if table is None else [v for k, v in table.items() if k not in SIZES]
    return found


@dataclass(frozen=True)
class _Simulated:
    """A bulk test of the file: its place in the list, its class, and its table."""

    index: int
    test: type[BulkTest]
    table: dict[str, Any]


def _simulated(document: dict[str, Any]) -> list[_Simulated]:
    tests = document.get("test")
    if not isinstance(tests, list):
        return []
    known = {name: kind.bulk_test for name, kind in types_of_test().items()}
    return [
        _Simulated(index, test, table)
        for index, table in enumerate(tests)
        if isinstance(table, dict)
        and isinstance(table.get("type"), str)
        and (test := known.get(table["type"])) is not None
    ]


def _words(simulated: list[_Simulated]) -> str:
    names = list(dict.fromkeys(one.test.type for one in simulated))
    return f"the {' and the '.join(names)} test{'s' if len(names) > 1 else ''}"


def _note_missing_material(simulated: list[_Simulated], values: Values, place: Place) -> None:
    needed = {
        name
        for one in simulated
        for name in one.test.material_parameters
        if MATERIAL_PARAMETERS[name].default is None
    } - parameters_without_effect(chosen_models(values))
    for section in MATERIAL_SECTIONS:
        keys = [
            key
            for key in _material_table(section).keys
            if key.name == _DIAMETER or f"{section}.{key.name}" in needed
        ]
        if section not in values and keys:
            names = ", ".join(key.name for key in keys)
            words = _words(simulated)
            verb = "need" if words.endswith("s") else "needs"
            place.at(section).fault(
                "is missing.", f"{words.capitalize()} {verb} [{section}] with {names}."
            )
        elif values.get(section) is not None:
            for key in keys:
                if key.name not in values[section]:
                    key.note_missing(place.at(section))


def _note_parameters_without_effect(values: Values, place: Place) -> None:
    chosen = chosen_models(values)
    for name in sorted(parameters_without_effect(chosen)):
        section, _, key = name.partition(".")
        if key in (values.get(section) or {}):
            fault = no_effect(name, chosen)
            place.at(section, key).fault(fault.message, fault.remedy)


def _note_useless_parameters(simulated: list[_Simulated], values: Values, place: Place) -> None:
    words = _words(simulated)
    verb = "have" if words.endswith("s") else "has"
    for name in values.get("parameters") or ():
        place.at("parameters", name).fault(
            f"is used by no test: {words} {verb} the material parameters only.",
            "Remove it, or add a [[test]] of your own model.",
        )


def _note_impossible_tests(simulated: list[_Simulated], values: Values, place: Place) -> None:
    """Note impossible geometries, which only the test itself can find from sizes and options."""
    sizes = simulated_sizes(values)
    if sizes is None:
        return
    for one in simulated:
        keys = one.test.option_keys()
        given = {key.name: one.table[key.name] for key in keys if key.name in one.table}
        if any(key.required and key.name not in given for key in keys):
            continue
        # Faults of the single options are noted already.
        options = Table(keys).read(given, Place(Findings(place.findings.folder)))
        if None in options.values():
            continue
        try:
            one.test(sizes, **options)
        except InputError as error:
            for fault in error.faults:
                place.at("test", one.index, fault.key).fault(fault.message, fault.remedy)
