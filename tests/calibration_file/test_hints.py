"""Hints in messages about mistakes that people make: no unit, no quotes, a short name."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.bulk_tests.shear import messages
from grainfit.calibration_file.layout import LAYOUT
from grainfit.calibration_file.load import load_calibration_file
from grainfit.errors import Fault, InputError
from grainfit.options.fields import option_keys
from grainfit.options.kinds import Kind
from grainfit.options.places import Findings, Place
from grainfit.options.tables import Key
from grainfit.solvers.other_names import OTHER_TESTS, instead_of_program, instead_of_test
from grainfit.solvers.registry import types_of_test
from grainfit.strategies.registry import strategies

EXAMPLE = Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml"
TEXT = EXAMPLE.read_text(encoding="utf-8")
DIAMETER = 'diameter = "10 mm"'
LINE = f"line {TEXT.splitlines().index(DIAMETER) + 1}, "


def message(tmp_path: Path, old: str, new: str) -> str:
    assert TEXT.count(old) == 1
    (tmp_path / "beads.toml").write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(gf.InputError) as caught:
        load_calibration_file(tmp_path / "beads.toml")
    return str(caught.value).removeprefix(f"{tmp_path / 'beads.toml'}: ")


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        (
            "diameter = 10",
            "particle.diameter: is 10, a plain number, which is in m. It must be from 1e-07 to "
            '1 m. Give it with its unit, such as "10 mm".',
        ),
        ('diameter = "10 m"', "particle.diameter: is '10 m'. It must be from 1e-07 to 1 m."),
        ("diameter = 10 mm", 'has 10 mm without quotes. Write "10 mm".'),
    ],
)
def test_message_tells_how_to_write_a_quantity(tmp_path: Path, written: str, expected: str) -> None:
    assert message(tmp_path, DIAMETER, written) == LINE + expected


@pytest.mark.parametrize(
    "written",
    ['diameter = "10 mm', "diameter = '10 mm", "diameter = '10 mm\"", "diameter = \"10 mm'"],
)
def test_quote_that_is_not_closed_is_found(tmp_path: Path, written: str) -> None:
    assert message(tmp_path, DIAMETER, written) == (
        f'{LINE}has a quote that is not closed, in <{written}>. Close it, as in diameter = "10 mm".'
    )


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("diameter = 10,5", "has the decimal comma 10,5. Write a decimal point: 10.5."),
        ("diameter = { min = 1,5, max = 2,5 }", "has the decimal comma 1,5."),
        ("diameter = 0.01;", "has a ; behind 0.01. Remove it"),
        ("diameter = 8 .. 10", "has 8 .. 10. An interval is written { min = ..., max = ... }."),
        ("diameter = 8 - 10", "has 8 - 10. An interval is written { min = ..., max = ... }."),
        ("diameter = “10 mm”", "has curly quotes, in <diameter = “10 mm”>."),
        ("diameter = wide", 'has wide without quotes. Write "wide".'),
        ("diameter = True", "has True. Write true or false."),
        ("diameter = yes # it is", "has yes. Write true or false."),
        ("diameter == 0.01", "is not valid TOML: Invalid value"),
        ("diameter = { min = 1,\nmax = 2 }", "has a { that is not closed, in <diameter = { min"),
        ("[wal", "has brackets that do not match, in <[wal>."),
        ("[[wal]", "has brackets that do not match, in <[[wal]>."),
    ],
)
def test_usual_slips_in_toml_are_named_with_a_remedy(
    tmp_path: Path, written: str, expected: str
) -> None:
    assert message(tmp_path, DIAMETER, written).startswith(LINE + expected)


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        (f"{DIAMETER}\ndiameter = 0.02", "gives diameter again. Remove one of them"),
        (f"{DIAMETER}\n[particle]", "has the section [particle] again."),
        (f"{DIAMETER}\nx = {{ min = 1, min = 2 }}", "gives min again. Remove one of them"),
        (
            'diameter = { sieve_curve = "sieve.csv" }\ndiameter.classes = 5',
            "adds classes to diameter, which is complete with the } above. Write all keys",
        ),
    ],
)
def test_what_is_given_twice_is_named_and_not_called_a_missing_quote(
    tmp_path: Path, written: str, expected: str
) -> None:
    line = int(LINE.removeprefix("line ").removesuffix(", "))
    assert message(tmp_path, DIAMETER, written).startswith(f"line {line + 1}, {expected}")


def test_other_text_that_is_no_toml_is_quoted_from_the_reader(tmp_path: Path) -> None:
    found = message(tmp_path, DIAMETER, "diameter; 10")
    assert found.startswith(f"{LINE}is not valid TOML: Expected '=' after a key")


def test_tests_are_counted_from_one_for_readers(tmp_path: Path) -> None:
    assert ", test 1, type: is 'heep'" in message(tmp_path, 'type = "heap"', 'type = "heep"')
    assert str(Fault("test[1]", "is bad.")) == "test 2: is bad."
    assert str(Fault("holdout[0].name", "is bad.")) == "holdout 1, name: is bad."
    assert InputError(Fault("test[0].type", "is bad.")).reasons == "test 1, type: is bad."
    assert str(Fault("test[0].'test[0]'", "is bad.")) == "test 1, 'test[0]': is bad."


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("density", "Write its whole name: particle.density."),
        ("densty", "Write its whole name: particle.density."),
        ("rolling_friction", "Write its whole name: particle_particle.rolling_friction."),
        (
            "restitution",
            "Write its whole name: particle_particle.restitution or particle_wall.restitution.",
        ),
        ("particle.densty", 'Did you mean "particle.density"?'),
    ],
)
def test_short_name_of_a_parameter_leads_to_the_free_one(name: str, hint: str) -> None:
    with pytest.raises(gf.InputError) as caught:
        gf.load(EXAMPLE).values([f"{name}=1"])
    [fault] = caught.value.faults
    assert (fault.key, fault.remedy) == (name, hint)


@pytest.mark.parametrize("name", ["funnel", "Triaxial", "ring shear", "silo"])
def test_a_test_that_is_not_there_names_the_one_that_comes_nearest(
    name: str, tmp_path: Path
) -> None:
    found = message(tmp_path, 'type = "heap"', f'type = "{name}"')
    assert instead_of_test(name) in found


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("shear_stress", messages.ENTER_SHEAR_STRESS()),
        ("yield_locus", messages.ENTER_SHEAR_STRESS()),
        ("phi_e", messages.ENTER_ANGLE()),
        ("phi_lin", messages.ENTER_ANGLE()),
    ],
)
def test_values_of_a_shear_tester_are_answered_with_how_to_enter_them(
    name: str, remedy: str, tmp_path: Path
) -> None:
    shear = f'[[test]]\ntype = "shear"\nsolver = "lammps"\ntargets.{name} = {{ value = 20 }}\n'
    (tmp_path / "beads.toml").write_text(f"{TEXT}\n{shear}", encoding="utf-8")
    with pytest.raises(gf.InputError) as caught:
        load_calibration_file(tmp_path / "beads.toml")
    assert remedy in {fault.remedy for fault in caught.value.faults}


@pytest.mark.parametrize("name", ["edem", "EDEM 2023", "Star-CCM+", "abaqus"])
def test_another_program_is_used_by_command_or_table(name: str, tmp_path: Path) -> None:
    found = message(tmp_path, 'solver = "lammps"', f'solver = "{name}"')
    assert 'type = "command"' in found
    assert 'type = "table"' in found


def test_an_inclined_plane_needs_no_simulation(tmp_path: Path) -> None:
    found = message(tmp_path, 'type = "heap"', 'type = "inclined_plane"')
    assert 'sliding_friction = { measured_angle = "22 deg" }' in found


def test_doors_that_are_named_are_there() -> None:
    for sentence in {*OTHER_TESTS.values(), instead_of_program("edem", ["lammps"])}:
        named = re.findall(r'"(\w+)"', sentence)
        assert named
        assert set(named) <= types_of_test().keys()


def test_program_that_is_written_in_capitals_is_recognised() -> None:
    assert instead_of_program("LAMMPS", ["lammps", "yade"]) == 'Did you mean "lammps"?'


def keys_and_kinds() -> Iterator[tuple[str, Kind, str]]:
    """Every kind of a calibration file with its key, and the example of the key."""
    found: dict[int, object] = {}

    def within(one: object, name: str) -> Iterator[tuple[str, Kind, str]]:
        if id(one) in found:
            return
        found[id(one)] = one
        if isinstance(one, Key):
            name = one.name
            yield name, one.kind, one.example
        elif isinstance(one, Kind):
            yield name, one, ""
        inner: Iterable[object] = ()
        if isinstance(one, (tuple, list)):
            inner = one
        elif isinstance(one, Mapping):
            inner = one.values()
        elif is_dataclass(one) and not isinstance(one, type):
            inner = [getattr(one, known.name) for known in fields(one)]
        for part in inner:
            yield from within(part, name)

    yield from within(LAYOUT, "")
    for options in (*BUILT_IN.values(), *strategies().values()):
        yield from within(tuple(option_keys(options)), "")


def faults_of(kind: Kind, value: object) -> list[str]:
    findings = Findings(Path())
    kind.read(value, Place(findings, ("test", 0, "x")))
    return [str(fault) for fault in findings.faults]


def test_every_example_of_a_key_is_accepted_by_its_kind() -> None:
    seen, refused = 0, []
    for name, kind, example in keys_and_kinds():
        # That of Parsl names a file.
        examples = [example] if example and name != "parsl" else []
        for wrong in (True, "1 nonsense", "", -1e9, 10**9, "3"):
            for fault in faults_of(kind, wrong):
                examples += re.findall(r'(?:or example|such as) (".*?"|[\d.e+-]*\d)', fault)
        seen += len(examples)
        values = [tomllib.loads(f"value = {one}")["value"] for one in examples]
        refused += [(name, value) for value in values if faults_of(kind, value)]
    assert seen > 500
    assert refused == []
