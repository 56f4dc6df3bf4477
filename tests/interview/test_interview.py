"""The interview: answers become a calibration file, of which nothing else changes."""

import tomllib
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from xml.etree import ElementTree

import pytest
from pypdfium2 import PdfDocument
from reportlab.graphics.shapes import Circle, Group, String
from reportlab.graphics.shapes import Path as Line

import grainfit as gf
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.interview import messages
from grainfit.interview.answers import is_measured, named_tests
from grainfit.interview.equipment import equipment, way_of, ways
from grainfit.interview.measured import read_measured, typed
from grainfit.messages import Message
from grainfit.pdf.line_drawing import line_drawing

OWN = """\
# my own remarks
name = "sand of pit 3"   # as in the book

[particle]
diameter = "2 mm"        # sieved
youngs_modulus = "5 MPa"
poissons_ratio = 0.3
density = { min = "2500 kg/m^3", max = "2700 kg/m^3" } # free

[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.3
density = "7700 kg/m^3"

[particle_particle]
sliding_friction = { min = 0.2, max = 0.9 }
restitution = 0.5
rolling_friction = 0.1

[particle_wall]
sliding_friction = 0.4
restitution = 0.5
rolling_friction = 0.1

# the heap of May
[[test]]
type = "heap"
name = "may"
solver = "lammps"
plate_sliding_friction = 0.5 # glued
[test.targets.angle_of_repose]
value = "33 deg"         # protractor
tolerance = "2 deg"
weight = 2

# the search
[strategy]
max_runs = 40 # patience
"""


def interview(folder: Path, *given: tuple[str, str], text: str = "") -> gf.Interview:
    path = folder / "calibration.toml"
    if text:
        path.write_text(text)
    found = gf.Interview.open(path)
    for key, answer in given:
        found = found.answered(key, answer)
    return found


BEGUN = (
    ("material", "wood pellets"),
    ("moisture", "8 % wet basis"),
    ("diameter", "6 mm"),
    ("at_hand", "bucket, scale, tube, phone"),
    ("tests", "heap, packing"),
)
MEASURED = (
    ("heap.cylinder_radius", "40 mm"),
    ("heap.targets.angle_of_repose", "31; 33; 32 deg ± 0.5 deg"),
    ("packing.targets.bulk_density", "0.605 g/cm^3 ± 1 %"),
)


def test_answers_become_a_calibration_that_can_run(tmp_path: Path) -> None:
    found = interview(tmp_path, *BEGUN)
    assert found.left == (messages.NOT_MEASURED(names="heap and packing", verb="have"),)
    for key, answer in MEASURED:
        found = found.answered(key, answer)
    found.save()

    setup = gf.load(found.path)
    angle = next(t for t in setup.problem.targets if t.name == "heap.angle_of_repose")
    density = next(t for t in setup.problem.targets if t.name == "packing.bulk_density")

    assert found.left == ()
    assert angle == gf.Target.of_measurements(
        "heap.angle_of_repose", [31, 33, 32], unit="deg", systematic=0.5
    )
    assert (density.value, density.uncertainty) == pytest.approx((605, 6.05))
    assert setup.bulk_tests["heap"].cylinder_radius == 0.04
    assert setup.file.sizes is not None
    assert setup.file.sizes.diameters == (0.006,)
    assert f"{angle.standard_uncertainty:.2g}" in _question(found, MEASURED[1][0]).implies


def _question(found: gf.Interview, key: str):
    return next(one for one in found.questions() if one.key == key)


def test_a_file_is_opened_again_with_its_answers_and_what_was_asked(tmp_path: Path) -> None:
    interview(tmp_path, *BEGUN, ("shape", "")).save()
    again = interview(tmp_path)

    assert _question(again, "moisture").answer == "8 % wet basis"
    assert _question(again, "tests").answer == "heap, packing"
    assert [one.key for one in again.questions() if one.is_asked] == [
        *("material", "moisture", "diameter", "shape", "at_hand", "tests")
    ]


def test_answers_that_are_typed_again_change_nothing(tmp_path: Path) -> None:
    found = interview(tmp_path, *BEGUN, *MEASURED, ("shape", "lens"), ("wall_friction", "21 deg"))
    again = found
    for one in found.questions():
        again = again.answered(one.key, one.answer)

    assert tomllib.loads(again.text) == tomllib.loads(found.text)


@pytest.mark.parametrize(
    ("key", "answer", "path", "value"),
    [
        ("diameter", "3 mm", ("particle", "diameter"), "3 mm"),
        (
            "diameter",
            "2 mm: 40 %; 3 mm: 60 %",
            ("particle", "diameter"),
            [
                {"value": "2 mm", "mass_fraction": "40 %"},
                {"value": "3 mm", "mass_fraction": "60 %"},
            ],
        ),
        ("density", "2650 kg/m^3", ("particle", "density"), "2650 kg/m^3"),
        (
            "density",
            "2600 to 2700 kg/m^3",
            ("particle", "density"),
            {"min": "2600 kg/m^3", "max": "2700 kg/m^3"},
        ),
        (
            "wall_friction",
            "21 deg ± 1 deg",
            ("particle_wall", "sliding_friction"),
            {"measured_angle": "21 deg", "uncertainty": "1 deg"},
        ),
        (
            "cohesion",
            "yes",
            ("particle_particle", "surface_energy"),
            {"min": 0, "max": "0.05 J/m^2"},
        ),
        ("may.lift_speed", "0.02 m/s", ("test", 0, "lift_speed"), "0.02 m/s"),
        (
            "may.targets.angle_of_repose",
            "32 deg",
            ("test", 0, "targets", "angle_of_repose", "value"),
            "32 deg",
        ),
    ],
)
def test_one_answer_changes_one_value_of_a_file_by_hand(
    tmp_path: Path, key: str, answer: str, path: tuple, value: object
) -> None:
    found = interview(tmp_path, (key, answer), text=OWN)
    expected = tomllib.loads(OWN)
    place = expected
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value

    assert tomllib.loads(found.text) == expected
    kept = (
        "my own remarks",
        "as in the book",
        "the heap of May",
        "glued",
        "protractor",
        "patience",
    )
    assert [words for words in kept if f"# {words}" not in found.text] == []


@pytest.mark.parametrize(
    ("key", "answer", "words"),
    [
        ("diameter", "3", "3 mm"),
        ("diameter", "2 mm: 40 %; 3 mm: 40 %", "sum to 0.8"),
        ("diameter", "sieve.csv", "no such file"),
        ("aspect_ratio", "1.5", messages.NO_QUESTION.text),
        ("density", "-3 kg/m^3", "density"),
        ("material", "wheat", messages.OTHER_MATERIAL.text),
        ("shape", "cube", "none of the choices"),
        ("may.cylinder_radius", "3 kg", "kg"),
        ("may.targets.angle_of_repose", "31; 320 deg", "320"),
        ("may.targets.heap_height", "20", "has no unit"),
        ("may.targets.heap_height", "20,5 mm", "comma"),
        ("may.targets.bulk_density", "low", "is no measurement"),
        ("may.targets.angle_of_repose", "31; 31; 31 deg", "are all 31"),
    ],
)
def test_an_impossible_answer_is_refused_with_its_reason(
    tmp_path: Path, key: str, answer: str, words: str
) -> None:
    begun = interview(tmp_path, text=OWN)

    with pytest.raises(gf.InputError) as refused:
        begun.answered(key, answer)

    assert words in str(refused.value)


def test_repeats_take_the_place_of_a_value_beside_its_tolerance(tmp_path: Path) -> None:
    found = interview(tmp_path, ("may.targets.angle_of_repose", "32; 34 deg ± 1 deg"), text=OWN)

    assert tomllib.loads(found.text)["test"][0]["targets"]["angle_of_repose"] == {
        "measurements": ["32 deg", "34 deg"],
        "systematic": "1 deg",
        "tolerance": "2 deg",
        "weight": 2,
    }


def test_a_measured_test_is_not_lost_by_a_choice(tmp_path: Path) -> None:
    found = interview(tmp_path, *BEGUN, *MEASURED[:2])

    assert [name for name, _ in named_tests(found.answered("tests", "heap").text)] == ["heap"]
    with pytest.raises(gf.InputError, match=messages.TEST_IS_MEASURED.pattern):
        found.answered("tests", "packing")


def test_what_is_not_measured_yet_is_left_out_of_a_calibration(tmp_path: Path) -> None:
    found = interview(tmp_path, *BEGUN, *MEASURED[:2])

    assert list(found.setup().bulk_tests) == ["heap"]
    assert not is_measured(dict(named_tests(found.text))["packing"])


def test_a_material_is_known_or_of_a_class_or_is_refused(tmp_path: Path) -> None:
    known = interview(tmp_path, ("material", "rape seed"))
    of_class = interview(tmp_path, ("material", "coffee powder"))

    assert known.remark == ""
    assert messages.OF_CLASS.is_in(of_class.remark, title="powders and ashes")
    assert _question(of_class, "material").answer == "coffee powder"
    with pytest.raises(gf.InputError, match=messages.UNKNOWN_MATERIAL.pattern):
        interview(tmp_path, ("material", "quux"))


BARE = OWN[: OWN.index("# the heap of May")]


@pytest.mark.parametrize(
    "text",
    [BARE, BARE.replace("name =", "# name ="), "# my notes\n", "{begun}# my notes\n"],
    ids=["named", "nameless", "notes alone", "begun and edited"],
)
def test_a_material_takes_nothing_out_of_a_file_by_hand(tmp_path: Path, text: str) -> None:
    text = text.format(begun=interview(tmp_path, *BEGUN[:3]).text) if "begun" in text else text
    begun = interview(tmp_path, text=text)

    if "# name" in text:
        changed = begun.answered("material", "wheat").text
        assert tomllib.loads(changed) == {"name": "wheat", **tomllib.loads(text)}
        assert set(text.splitlines()) <= set(changed.splitlines())
    else:
        with pytest.raises(gf.InputError, match=messages.OTHER_MATERIAL.pattern):
            begun.answered("material", "barley")


def test_another_material_begins_anew_where_there_are_answers_alone(tmp_path: Path) -> None:
    given = (*BEGUN[:3], ("density", "1000 to 1400 kg/m^3"), ("wall_friction", "21 deg ± 1 deg"))
    found = interview(tmp_path, *given, ("moisture", "9 %"), ("material", "barley"))

    assert found.text == interview(tmp_path, ("material", "barley")).text


CLUMPS = (*BEGUN, ("shape", "lens"))
ODD = (
    *("1,5", "2:1", "abc", "1.5 kg", "true", "0x2", "[2]", "{a=1}", "1\nb = 2", "nan", "to"),
    *("9" * 5000, "1e999", "\ud800", "3\x7f", "3\x00", "3 mm ± 10 %", "1 ± 2 ± 3", "2 - - 3"),
)


@pytest.mark.parametrize("key", ["diameter", "aspect_ratio", "density", "wall_friction", "twins"])
def test_an_odd_answer_is_refused_in_the_words_of_the_interview(tmp_path: Path, key: str) -> None:
    begun = interview(tmp_path, *CLUMPS)
    for odd in ODD:
        with pytest.raises(gf.InputError) as refused:
            begun.answered(key, odd)
        assert " = " not in str(refused.value).replace("b = 2", "")


def test_a_drum_is_lined_and_not(tmp_path: Path) -> None:
    found = interview(tmp_path, *BEGUN[:3], ("at_hand", "drum, phone"), ("tests", "drum"))
    for given, lined in (("yes", True), ("no", False)):
        found = found.answered("drum.lining", given)
        assert dict(named_tests(found.text))["drum"]["lining"] is lined


def test_numbers_of_other_forms_are_those_of_toml(tmp_path: Path) -> None:
    found = interview(tmp_path, *CLUMPS, ("aspect_ratio", "2."), ("wall_friction", ".5"))

    assert tomllib.loads(found.text)["particle"]["aspect_ratio"] == 2
    assert tomllib.loads(found.text)["particle_wall"]["sliding_friction"] == 0.5


@pytest.mark.parametrize(
    ("key", "answer", "message"),
    [
        ("may.plate_radius", "160", messages.NO_UNIT),
        ("may.lift_speed", "50", messages.NO_UNIT),
        ("wall_friction", "8", messages.ANGLE_OR_FRICTION),
        ("wall_friction", "20 to 25", messages.ANGLE_OR_FRICTION),
        ("wall_friction", "20 deg to 25 deg", messages.NO_WALL_FRICTION),
        ("density", "1000 ± 50 kg/m^3", messages.NO_DENSITY),
        ("diameter", "3 mm ± 10 %", messages.NO_ERROR_HERE),
        ("diameter", "2 - 3 mm", messages.NO_SIZES),
        ("moisture", "12 \ud800", messages.NOT_TYPED),
    ],
)
def test_what_could_mean_something_else_is_asked_again(
    tmp_path: Path, key: str, answer: str, message: Message
) -> None:
    with pytest.raises(gf.InputError, match=message.pattern):
        interview(tmp_path, (key, answer), text=OWN)


@pytest.mark.parametrize(
    ("answer", "unit"),
    [
        ("2500 to 2600 kg/m^3", "kg/m^3"),
        ("2500 - 2600 kg/m^3", "kg/m^3"),
        ("2500-2600 kg/m^3", "kg/m^3"),
        ("2500 kg m^-3 – 2600 kg m^-3", "kg m^-3"),
    ],
)
def test_an_interval_is_typed_with_to_or_with_a_dash(
    tmp_path: Path, answer: str, unit: str
) -> None:
    found = interview(tmp_path, ("density", answer), text=OWN)

    density = tomllib.loads(found.text)["particle"]["density"]
    assert density == {"min": f"2500 {unit}", "max": f"2600 {unit}"}


def test_the_plan_compares_what_can_be_measured_with_what_is_at_hand(tmp_path: Path) -> None:
    found = interview(tmp_path, *BEGUN[:3], ("at_hand", "bucket, scale"))
    plan = found.measurement_plan()

    assert [one.name for one in plan.combinations] == ["packing"]
    with pytest.raises(gf.InputError, match=messages.NO_TESTS.pattern):
        interview(tmp_path, *BEGUN[:3], ("at_hand", "phone")).measurement_plan()


def test_the_sheet_has_steps_and_blanks_of_the_chosen_tests(tmp_path: Path) -> None:
    with closing(PdfDocument(interview(tmp_path, *BEGUN, *MEASURED[:1]).record_sheet())) as sheet:
        text = " ".join(page.get_textpage().get_text_bounded() for page in sheet)

    assert "Record sheet: wood pellets" in text
    assert "Moisture: 8 % wet basis" in text
    assert "40 mm" in text
    assert "Base radius, mm" in text
    assert "packing: poured container" in text
    # In the drawing.
    assert "cylinder_radius" in text
    with pytest.raises(gf.InputError, match=messages.NO_SHEET.pattern):
        interview(tmp_path, *BEGUN[:2]).record_sheet()


def test_every_way_has_a_drawing_whose_marks_are_all_on_paper() -> None:
    for way in ways(equipment()):
        marks = ElementTree.fromstring(way.drawing).iter()
        wanted = Counter(_SHAPES.get(one.tag.partition("}")[2]) for one in marks)
        drawn = Counter(type(one) for one in _leaves(line_drawing(way.drawing, 500.0)))
        assert {kind: count for kind, count in wanted.items() if kind} == drawn


_SHAPES = {"path": Line, "circle": Circle, "text": String}


def _leaves(group: Group) -> Iterator[object]:
    for one in group.contents:
        yield from _leaves(one) if isinstance(one, Group) else [one]


def test_equipment_names_what_there_is() -> None:
    known = equipment()
    for way in ways(known):
        test = BUILT_IN[way.test]
        assert {*way.options} <= {key.name for key in test.option_keys()}, way
        assert {*way.responses} <= {*test.responses}, way
        assert way.responses, way
        assert way.steps, way
    assert {way.name for way in ways(known)} >= {*BUILT_IN} - {"shear"}
    assert way_of("python") is None


@pytest.mark.parametrize(
    ("text", "unit", "target"),
    [
        ("22deg", "deg", {"value": "22 deg"}),
        ("22", "deg", {"value": "22 deg"}),
        ("0.4 +- 0.02", "", {"value": 0.4, "uncertainty": 0.02}),
        ("20 21 22 mm", "m", {"measurements": ["20 mm", "21 mm", "22 mm"]}),
        ("20 mm, 2.1 cm ± 1 %", "m", {"measurements": ["20 mm", "2.1 cm"], "systematic": "1 %"}),
        ("-3e-1", "", {"value": -0.3}),
    ],
)
def test_measurements_are_read_as_typed_and_shown_so(text: str, unit: str, target: dict) -> None:
    found = read_measured("x", text, unit).target()

    assert found == target
    assert read_measured("x", typed(found), unit).target() == target


def test_a_bucket_of_small_particles_is_searched_in_smaller_ones(tmp_path: Path) -> None:
    asked = interview(
        tmp_path,
        ("material", "polypropylene pellets"),
        ("at_hand", "holed_bucket, scale, stop_watch"),
        ("tests", "discharge"),
        ("discharge.orifice", "round"),
        ("discharge.orifice_diameter", "50 mm"),
        ("discharge.width", "200 mm"),
        ("discharge.fill_height", "200 mm"),
        ("discharge.targets.mass_flow", "0.34; 0.35 kg/s"),
    )
    assert "discharge.slot_width" not in [one.key for one in asked.questions()]
    slow, small = asked.plan(), asked.answered("twins", "1500")

    assert not any("full-size" in line for line in slow.lines)
    assert any("full-size" in line for line in small.plan().lines)
    assert "twins" not in tomllib.loads(small.answered("twins", "as measured").text)["strategy"]
    with pytest.raises(gf.InputError, match="at least 100"):
        asked.answered("twins", "5")


SAND = (
    ("material", "dry sand"),
    ("diameter", "0.5 mm"),
    ("at_hand", "iso_60, scale, tube"),
    ("tests", "iso_60"),
)


def test_particles_are_enlarged_where_the_apparatus_holds_too_many(tmp_path: Path) -> None:
    asked = interview(tmp_path, *SAND)

    assert messages.ENLARGED.is_in(asked.enlargement)
    factor = tomllib.loads(asked.text)["particle"]["coarse_graining"]
    assert factor == 4

    coarser = asked.answered("diameter", "3 mm")
    assert tomllib.loads(coarser.text)["particle"]["coarse_graining"] == 1
    assert coarser.enlargement == ""
