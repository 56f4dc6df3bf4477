"""The commented calibration file that a new user starts from."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Sequence
from math import radians, tan

from grainfit.bulk_tests.abilities import starter_remarks
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import coarse_grained
from grainfit.bulk_tests.instrument import Instrument, instrument_names, read_instrument
from grainfit.bulk_tests.outline import concepts
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.shared.plate import ON_DISC
from grainfit.calibration_file import messages
from grainfit.calibration_file.suited_material import suited_to
from grainfit.contact_models.registry import CONTACT_MODELS
from grainfit.errors import Fault, InputError
from grainfit.materials.starting_materials import StartingMaterial
from grainfit.materials.starting_values import StartingValue
from grainfit.options.tables import Key
from grainfit.solvers.other_names import instead_of_program, instead_of_test
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.units import to_unit

#: Column at which remarks begin.
_REMARK = 40
_WIDTH = 100
_DEFAULT_TEST, _DEFAULT_SOLVER = "heap", "lammps"

_HEAD = """\
# Calibration file of grainfit. It is valid as it is: change it, then
#
#     grainfit check FILE     says what is wrong with it, and shows the plan
#     grainfit run FILE       calibrates
#
"""
_QUANTITIES = """\
# A quantity is a number with its unit, in quotes: "10 mm". A plain number is in SI units, an
# angle in degrees. A parameter that you know has a value:
#     restitution = 0.79
# One that is to be found, a free parameter, has an interval:
#     restitution = { min = 0.5, max = 0.9 }
# Lines that start with # are comments; most of those below are options with their defaults.

"""

_GLASS_BEADS = """\
name = "glass beads"                    # for you; choose freely

[particle]
diameter = "10 mm"
# Instead, a particle size distribution, by mass as from a sieve analysis:
# diameter = [{ value = "8 mm", mass_fraction = 0.3 }, { value = "10 mm", mass_fraction = 0.7 }]
# Far softer than glass, because the number of time steps grows with its cubic root.
# Overlaps of soft particles add to bulk densities, which the fitted particle density then makes up
# for: less than 2 % in beds under their own weight, 6 % in a compression test at 10 kPa (which
# needs at least 10 MPa). "0.4 MPa" has a third of the time steps, but 13 % too much in a heap.
# Measure it: grainfit stiffness FILE
youngs_modulus = "10 MPa"
# Were it free, it would span orders of magnitude, and be searched by them:
# youngs_modulus = { min = "0.1 MPa", max = "100 MPa", scale = "log" }
poissons_ratio = 0.22
density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }  # free; of the solid, not of the bulk

[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"

[particle_particle]                     # contacts between particles
sliding_friction = 0.18
rolling_friction = { min = 0.22, max = 1.11 }           # free
restitution = 0.79
rolling_damping = 0.0                   # without it, all solvers have the same law

[particle_wall]                         # contacts between particles and walls
sliding_friction = 0.27
rolling_friction = 0.05                 # on smooth steel less; then beads roll on for seconds
restitution = 0.82
rolling_damping = 0.0

# Linear springs, as many decks have them, in place of those of Hertz and Mindlin are a section
# [contact_models] with contact = "linear"; their stiffness can be given (normal_stiffness).

"""

_STRATEGY = """\
[strategy]
name = "sequential"                     # every run where it helps most; or "staged" (the paper's)
# seed = 1                              # same seed, same calibration
# max_runs = 60                         # budget of DEM runs; none by default
# workers = 2                           # runs at a time; as many as the machine has cores for
# design_runs = 5                       # d + 2 for d free parameters, at least 5; 4 for one
# verification_runs = 5                 # with fresh seeds, at the answer
# prefer = "accuracy"                   # closest parameter set, not the fastest that agrees
# extend_intervals = true               # move a bound that keeps a target out of reach
# wanted_half_width = "25 %"            # go on until the 95 % intervals are that narrow

# A DEM model of your own, instead of these tests or beside them, and all other keys:
# docs/reference/calibration_file; runs in jobs of a cluster: docs/clusters.md
"""
#: Diameter and bulk density of the particles that the examples of tests are for, mm and kg/m^3.
DIAMETER_OF_EXAMPLES = 10.0
_BULK_DENSITY_OF_EXAMPLES = 1350.0
#: Powers of diameter and bulk density that quantities of a unit follow, with Froude's number kept.
_POWERS = {
    "mm": (1.0, 0),
    "s": (0.5, 0),
    "m/s": (0.5, 0),
    "rad/s": (-0.5, 0),
    "kg/s": (2.5, 1),
    "kg/m^3": (0.0, 1),
}
_QUANTITY = re.compile(rf'"([\d.]+) ({"|".join(map(re.escape, _POWERS))})"')
#: Stresses in the examples, and the normal stress that they are of, Pa.
_STRESS, _STRESS_OF_EXAMPLES = re.compile(r'"([\d.]+) Pa"'), 500.0
_ANGLE_OF_EXAMPLES = "22 deg"
#: Size of a heap in diameters, at an angle of repose of 45 degrees, and the power of the tangent of
#: the angle that it follows: fitted to simulated heaps of rough spheres of 20 to 41 degrees, of
#: which all are within 2 % in radius and 8 % in height. A cone of given volume has powers of -1/3
#: and 2/3; heaps have a foot and a round top.
_SIZE_OF_HEAP = {"base_radius": (10.3, -0.21), "heap_height": (8.7, 0.56)}


def starter_file(
    names: Sequence[str] = (_DEFAULT_TEST,),
    material: StartingMaterial | None = None,
    solver: str = _DEFAULT_SOLVER,
) -> str:
    """Return a commented calibration file: it teaches, and loads as it is.

    Parameters
    ----------
    names : sequence of str
        Bulk tests, or instruments, whose tests then have their names; the second of one kind is
        ``heap_2``.
    material : StartingMaterial, optional
        Material whose values it begins with; by default glass beads, with more comments.
    solver : str
        DEM program of all tests.

    Raises
    ------
    InputError
        There is no such test, no such program, or it cannot simulate a test, or the particles do
        not fit an instrument.
    """
    known = bulk_tests()
    instruments = {name: read_instrument(name) for name in names if name in instrument_names()}
    kinds = {name: instruments[name].type if name in instruments else name for name in names}
    faults = [
        messages.NO_BULK_TEST.fault(
            "test",
            name=name,
            remedy=instead_of_test(name) or f"Use one of {', '.join(known)}.",
        )
        for name, kind in kinds.items()
        if kind not in known
    ]
    if solver not in DEM_PROGRAMS:
        words = f"{solver!r} is not a DEM program that grainfit knows."
        door = instead_of_program(solver, DEM_PROGRAMS)
        faults.append(Fault("solver", words, door or f"Use one of {', '.join(DEM_PROGRAMS)}."))
    if not faults:
        diameter = f"{DIAMETER_OF_EXAMPLES} mm"
        tests = [known[kind](diameter=diameter) for kind in dict.fromkeys(kinds.values())]
        program = DEM_PROGRAMS[solver]
        faults = [f for test in tests for f in program.concept_faults(test.type, concepts(test))]
    InputError.raise_for(faults)
    if material is None:
        for one in instruments.values():
            known[one.type](diameter=diameter, **one.values)
        first = _for_solver(_GLASS_BEADS, solver)
    else:
        usual = [kind for name, kind in kinds.items() if name not in instruments]
        first = _material_part(suited_to(material, usual, instruments), solver, tests)
    blocks = [_TESTS if material is None else f"{_TESTS}{_EXAMPLES}"]
    for place, name in enumerate(names):
        instrument = instruments.get(name)
        before = names[:place].count(name)
        own = f"{name}_{before + 1}" if before else name if instrument else ""
        lines = _test(known[kinds[name]], own, solver, material, instrument)
        blocks.append("\n".join(lines) + "\n\n")
    return f"{_HEAD}{_QUANTITIES}{first}{''.join(blocks)}{_STRATEGY}"


def file_without_tests(material: StartingMaterial, solver: str = _DEFAULT_SOLVER) -> str:
    """Return a commented file of a material, before any test is chosen."""
    return f"{_QUANTITIES}{_material_part(material, solver, ())}{_TESTS}\n{_STRATEGY}"


def starter_test(
    name: str, material: StartingMaterial | None = None, solver: str = _DEFAULT_SOLVER
) -> str:
    """Return the section of a test that is not measured yet: its targets are comments.

    Parameters
    ----------
    name : str
        A bulk test, or an instrument, whose test then has its name.
    material : StartingMaterial, optional
        Material that the examples are for.
    solver : str
        DEM program of the test.
    """
    instrument = read_instrument(name) if name in instrument_names() else None
    test = bulk_tests()[instrument.type if instrument else name]
    lines = _test(test, name if instrument else "", solver, material, instrument)
    return "".join(f"{'# ' * line.startswith('targets.')}{line}\n" for line in lines)


def _material_part(material: StartingMaterial, solver: str, tests: Sequence[BulkTest]) -> str:
    return _for_solver("\n".join(_sections(material, solver, tests)) + "\n\n", solver)


def _for_solver(sections: str, solver: str) -> str:
    """Return the sections of a material as a program takes them."""
    for name in DEM_PROGRAMS[solver].absent_parameters:
        key = name.rpartition(".")[2]
        line = _with_remark(f"{key} = 0", f"{solver} has none")
        sections = re.sub(rf"^{key} = .*$", line, sections, flags=re.MULTILINE)
    return sections


def _sections(material: StartingMaterial, solver: str, tests: Sequence[BulkTest]) -> Iterator[str]:
    """Iterate over the lines of a material, each value below its source."""
    yield from _comment(
        f"STARTING VALUES for {material.title}. Your material differs: nothing here is calibrated, "
        "and a value is as good as the source above it. Measure what you can; the intervals are of "
        "what is to be found."
    )
    yield from (line for text in material.about for line in _comment(text))
    if material.published_lines:
        yield "#"
        yield "# Published, each with its source:"
        yield from (line for text in material.published_lines for line in _comment(text))
    yield ""
    yield _with_remark(f'name = "{material.title}"', "for you; choose freely")
    for section, values in material.sections.items():
        yield f"\n[{section}]"
        for key, entry in values.items():
            yield from _comment(entry.source)
            yield _with_remark(f"{key} = {entry.toml}", "free" if entry.is_free else "")
        for key, entry in material.suggested.get(section, {}).items():
            name = f"{section}.{key}"
            if key in values:
                continue
            if _acts_unchosen(name, solver) and _fits(name, entry, tests):
                yield from _comment(entry.source)
                yield f"# {key} = {entry.toml}"


def _acts_unchosen(name: str, solver: str) -> bool:
    """Return whether a program has the usual contact model of a parameter, if there is one."""
    models = [m for m in CONTACT_MODELS if name in {parameter.name for parameter in m.parameters}]
    return not models or solver in models[0].solvers


def _fits(name: str, entry: StartingValue, tests: Sequence[BulkTest]) -> bool:
    """Return whether the default apparatus of all tests has room for a factor, if it is one."""
    if name != "particle.coarse_graining":
        return True
    try:
        for test in tests:
            coarse_grained(test, entry.value, {})
    except InputError:
        return False
    return True


def _comment(text: str) -> list[str]:
    return textwrap.wrap(
        text, _WIDTH, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False
    )


_TESTS = """\
# What was measured: one [[test]] for each laboratory test. Delete the targets that you do not have.
# A target is a value with its standard uncertainty, or your measurements themselves; systematic is
# what is wrong in all of them alike (protractor, scale), tolerance what is good enough for you:
#     targets.angle_of_repose.measurements = ["21.4 deg", "22.9 deg", "21.8 deg"]
#     targets.angle_of_repose.systematic = "0.4 deg"
#     targets.angle_of_repose.tolerance = "1.5 deg"
"""
_EXAMPLES = "# The targets below are examples: replace them by your measurements.\n"


def _test(
    test: type[BulkTest],
    name: str,
    solver: str,
    material: StartingMaterial | None,
    instrument: Instrument | None,
) -> Iterator[str]:
    """Iterate over the lines of a test."""
    yield "[[test]]"
    yield _with_remark(f'type = "{test.type}"', test.title)
    if instrument:
        yield _with_remark(f'apparatus = "{instrument.name}"', instrument.title)
    if name:
        yield _with_remark(f'name = "{name}"', "this test's own name")
    needed = concepts(test(diameter=f"{DIAMETER_OF_EXAMPLES} mm"))
    able = [name for name, one in DEM_PROGRAMS.items() if not needed & set(one.missing)]
    others = ", ".join(f'"{other}"' for other in able if other != solver)
    yield _with_remark(f'solver = "{solver}"', f"or {others}")
    yield "# Geometry and procedure, as in your laboratory. These defaults follow the diameter d."
    set_options = starter_remarks(test)
    dimensions = instrument.options if instrument else {}
    for key in test.option_keys():
        if key.name in dimensions:
            line = f"# {key.name} = {dimensions[key.name].toml}"
            yield _with_remark(line, "of the instrument; here it would override it")
        else:
            yield from _option(key, material, set_options.get(key.name))
    disc = _disc_of(instrument)
    for response, info in test.responses.items():
        # A heap on a disc ends at its edge, whatever the material.
        if disc is None or response != "base_radius":
            example = _at_stress(info.example, instrument)
            yield f"targets.{response} = {example_target(response, example, material, disc)}"


def _disc_of(instrument: Instrument | None) -> float | None:
    """Return the radius of the disc on which an instrument makes heaps, mm, if it has one."""
    values = instrument.values if instrument else {}
    return to_unit(values["plate_radius"], "mm") if values.get("base") == ON_DISC else None


def _option(key: Key, material: StartingMaterial | None, why_set: str | None) -> Iterator[str]:
    """Iterate over the lines of an option: commented out, with default and description, or set."""
    line = f"{key.name} = {scaled_example(key.example, material)}"
    if why_set is not None:
        yield _with_remark(line, why_set)
        return
    line, key = f"# {line}", key.in_words()
    remark = f"{key.default}. {key.description}" if key.default else key.description
    whole = _with_remark(line, remark)
    if len(whole) <= _WIDTH:
        yield whole
        return
    yield _with_remark(line, key.default)


def _with_remark(line: str, remark: str) -> str:
    return f"{line:<{_REMARK - 1}} # {remark}" if remark else line


def _at_stress(example: str, instrument: Instrument | None) -> str:
    """Return an example for the normal stress of an instrument that has one."""
    given = instrument.values.get("normal_stress") if instrument else None
    times = to_unit(given, "Pa") / _STRESS_OF_EXAMPLES if given else 1.0

    def at_stress(found: re.Match[str]) -> str:
        return f'"{_rounded(float(found[1]) * times)} Pa"'

    return _STRESS.sub(at_stress, example)


def scaled_example(example: str, material: StartingMaterial | None) -> str:
    """Return an example for particles of the size and bulk density of a material.

    Parameters
    ----------
    example : str
        TOML, for particles of `DIAMETER_OF_EXAMPLES`.
    material : StartingMaterial, optional
        The material; without it the example is as it was.
    """
    if material is None:
        return example
    size = _diameter(material) / DIAMETER_OF_EXAMPLES
    density = to_unit(material.example_targets["bulk_density"], "kg/m^3")

    def of_material(found: re.Match[str]) -> str:
        of_size, of_density = _POWERS[found[2]]
        ratio = size**of_size * (density / _BULK_DENSITY_OF_EXAMPLES) ** of_density
        return f'"{_rounded(float(found[1]) * ratio)} {found[2]}"'

    return _QUANTITY.sub(of_material, example)


def example_target(
    response: str, example: str, material: StartingMaterial | None, disc: float | None = None
) -> str:
    """Return an example of a target: the material's own value, or one that agrees with it.

    Parameters
    ----------
    response : str
        Name of the response.
    example : str
        TOML, for particles of `DIAMETER_OF_EXAMPLES`.
    material : StartingMaterial, optional
        The material; without it the example is as it was.
    disc : float, optional
        Radius of the disc that a heap covers, mm.
    """
    target = scaled_example(example, material)
    value = material.example_targets.get(response) if material else None
    if response in _SIZE_OF_HEAP and (size := _size_of_heap(response, material, disc)):
        value = f"{_rounded(size)} mm"
    return target if value is None else re.sub(r'value = "[^"]*"', f'value = "{value}"', target)


def _size_of_heap(
    response: str, material: StartingMaterial | None, disc: float | None
) -> float | None:
    """Return radius or height of a heap, mm; None for the heap that the examples are of."""
    angle = material.example_targets["angle_of_repose"] if material else _ANGLE_OF_EXAMPLES
    slope = tan(radians(to_unit(angle, "deg")))
    if disc is not None:
        return disc * slope
    if material is None:
        return None
    diameters, power = _SIZE_OF_HEAP[response]
    return diameters * _diameter(material) * float(slope**power)


def _diameter(material: StartingMaterial) -> float:
    return to_unit(material.sections["particle"]["diameter"].value, "mm")


def _rounded(value: float) -> str:
    return f"{float(f'{value:.3g}'):g}"
