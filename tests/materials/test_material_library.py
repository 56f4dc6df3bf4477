"""The library of starting materials: every value has its source, and every name an answer."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.starter import starter_file
from grainfit.cli.app import app
from grainfit.errors import InputError
from grainfit.materials import messages as of_materials
from grainfit.materials.material_classes import material_classes
from grainfit.materials.starting_materials import (
    materials_like,
    read_starting_material,
    starting_material_names,
)
from grainfit.units import to_unit
from tools.materials_page import PAGE, updated

#: Units that sources have instead of those of the library: g/cm3, lb/ft3, micrometres, g/mL.
FACTORS = (1, 1000, 16.0185, 0.001)
#: Sizes that sources have in words, mm.
SIZES = {"1/2": 12.7, "1/8": 3.18, "-3 ": 76.2, "100M": 0.15, "100 mesh": 0.15, "100mesh": 0.15}
PUBLISHED = [m.name for m in materials_like() if m.published]
#: One of each class, and those whose sizes, densities and heaps are extreme.
TYPICAL = ("barley", "bauxite", "fly_ash", "lactose", "alfalfa_seed", "copper_ore")


def numbers(text: str) -> list[float]:
    """Return the numbers in a text, those of its sizes in words too."""
    found = [size for word, size in SIZES.items() if word in text]
    plain = re.sub(r"(?<=\d),(?=\d{3})", "", text)
    return found + [float(number) for number in re.findall(r"\d+\.?\d*|\.\d+", plain)]


@pytest.mark.parametrize("name", PUBLISHED)
def test_every_published_number_is_in_the_quoted_words_of_its_source(name: str) -> None:
    for quantity, value in read_starting_material(name).published.items():
        assert len(value.source) > 20
        assert value.text
        known = numbers(f"{value.text} {value.source}")
        for end in {value.low, value.high} - {None}:
            ends = [factor * number for factor in FACTORS for number in known]
            if name == "flaxseed" and quantity == "diameter":
                length, breadth, thickness = known[:6:2], known[1:6:2], known[2:6:2]
                assert min(length) < end < max(breadth + thickness + [9]), "a mean of them"
                continue
            assert any(abs(end - one) <= 0.006 * one for one in ends), (quantity, end, known)


def test_the_library_has_all_classes_and_forty_materials_with_a_public_source() -> None:
    names = starting_material_names()
    assert len(PUBLISHED) >= 40
    assert {m.material_class.name for m in materials_like()} == set(material_classes())
    known = [text for m in materials_like() for text in m.names if text != m.name]
    for name in names:
        assert all(re.fullmatch(r"\S.*\S", text) for text in read_starting_material(name).names)
    assert len({*known}) > 2 * len(names), "synonyms"


def test_the_file_of_every_published_material_passes_the_check(tmp_path: Path) -> None:
    path = tmp_path / "new.toml"
    for name in PUBLISHED:
        material = read_starting_material(name)
        text = starter_file(["heap"], material)
        path.write_text(text, encoding="utf-8")
        assert describe_plan(gf.load(path)).problems == (), name
        assert max(map(len, text.splitlines())) <= 100
        unwrapped = text.replace("\n# ", " ")
        for value in material.published.values():
            assert f"{value.words} ({value.source})" in unwrapped
        bulk = to_unit(material.example_targets["bulk_density"], "kg/m^3") / 0.54
        ends = material.sections["particle"]["density"].value
        assert to_unit(ends["min"], "kg/m^3") < bulk < to_unit(ends["max"], "kg/m^3"), name


@pytest.mark.parametrize("test", ["compression", "discharge"])
def test_tests_under_load_and_through_an_outlet_take_them(tmp_path: Path, test: str) -> None:
    path = tmp_path / "new.toml"
    for name in TYPICAL:
        path.write_text(starter_file([test], read_starting_material(name)), encoding="utf-8")
        assert describe_plan(gf.load(path)).problems == (), name


def test_what_is_not_published_is_said_to_be_of_the_class() -> None:
    lignite = read_starting_material("lignite")
    assert "diameter" not in lignite.published
    assert lignite.sections["particle"]["diameter"].source.startswith("No source: usual for coals")
    assert any("No public source was found for diameter" in line for line in lignite.about)
    steep = read_starting_material("sunflower_seed")
    assert steep.example_targets["angle_of_repose"] == "35 deg"
    assert any("Published heaps (41 to 57 deg)" in line for line in steep.about)


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("rape seed", "canola"),
        ("Oilseed-Rape", "canola"),
        ("polypropylene", "plastic_pellets"),
        ("washed sand", "dry_sand"),
        ("soybean", "soybeans"),
        ("urea", "granular_urea"),
        ("cement", "cement"),
        ("coal", "anthracite"),
    ],
)
def test_synonyms_name_a_material(given: str, name: str) -> None:
    assert read_starting_material(given).name == name


@pytest.mark.parametrize(
    ("given", "near", "ranges"),
    [
        ("wood pellets", "alfalfa_pellets", "pellets and granulates: .*bulk density 657 to 689"),
        ("coffee beans", "soybeans", "seeds, pulses and nuts: .*angle of repose 16 to 57°"),
        ("chick peas", "chickpea|green_pea", "seeds"),
        ("nickel ore", "copper_ore", "ores and concentrates: .*bulk density 1201 to 2403 kg/m³"),
        ("flie ash", "coal_ash|fly_ash", "powders"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest_and_the_ranges_of_its_class(
    given: str, near: str, ranges: str
) -> None:
    with pytest.raises(InputError) as caught:
        read_starting_material(given)
    words = str(caught.value)
    assert of_materials.NO_STARTING_MATERIAL.is_in(words, name=given)
    assert re.search(f"near: .*({near})", words)
    assert re.search(f"Typical of {ranges}", words)
    done = CliRunner().invoke(app, ["new", "never.toml", "--material", given])
    assert done.exit_code == 1
    assert not Path("never.toml").exists()


def test_the_page_has_the_materials_as_their_files_have_them() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert updated(page) == page, "python tools/materials_page.py"


def listed(*arguments: str) -> str:
    done = CliRunner(env={"COLUMNS": "250"}).invoke(app, ["materials", *arguments])
    assert done.exit_code == 0, done.output
    return done.output


def test_the_command_lists_searches_and_shows_sources() -> None:
    everything = listed()
    assert all(name in everything for name in starting_material_names())
    ores = listed("--class", "ores")
    assert "bauxite" in ores
    assert "wheat" not in ores
    assert "Typical of ores and concentrates" in ores
    both = listed("urea")
    assert "Bu, Yu, Dong" in both
    assert '"static friction coefficient between urea particles was calibrated to 0.27"' in both
    several = listed("ammonium")
    assert {"ammonium_chloride", "ammonium_nitrate", "ammonium_sulphate"} <= set(several.split())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--class", "liquids"], "'liquids' is no class of materials. Use one of beads, pellets"),
        (["wheat", "--class", "ores"], "'wheat' is in no material of the class 'ores'"),
        (["coffee", "beans"], "'coffee beans' is no starting material"),
    ],
)
def test_a_search_without_an_answer_says_so(arguments: list[str], words: str) -> None:
    done = CliRunner().invoke(app, ["materials", *arguments])
    assert done.exit_code == 1
    assert words in str(done.exception)
