"""Instruments by name: their files, and what naming one does to a test."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.bulk_tests import messages
from grainfit.bulk_tests.instrument import instrument_names, read_instrument
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration_file.apparatus import opening_lines, simulated_apparatus
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.starter import starter_file, starter_test
from grainfit.cli.app import app
from grainfit.errors import InputError
from grainfit.options import messages as of_options
from grainfit.units import to_unit

#: Particles across the smallest length: too few for some tests, and too many in others.
SOME = (5.0, 7.0, 9.0)


def named(folder: Path, apparatus: str, *lines: str, test: str = "drum") -> Path:
    """Write a calibration file with an instrument and other lines in its test."""
    text = starter_file([test]).replace('diameter = "10 mm"', 'diameter = "2 mm"')
    line = f'type = "{test}"'
    text = text.replace(line, "\n".join([line, f'apparatus = "{apparatus}" #', *lines, "#"]), 1)
    path = folder / "calibration.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", instrument_names())
def test_every_file_describes_a_test_that_can_be_simulated(name: str) -> None:
    instrument = read_instrument(name)
    test = BUILT_IN[instrument.type]
    keys = {key.name: key for key in test.option_keys()}
    lengths = [to_unit(value, "m") for key, value in instrument.values.items() if is_length(key)]
    made = []
    for number in SOME:
        with suppress(InputError):
            made.append(test(diameter=min(lengths, default=0.08) / number, **instrument.values))

    assert {*instrument.options} <= {*keys}
    assert any(one.number_of_particles > 0 for one in made)
    assert instrument.title
    assert all(instrument.procedure)
    for printed in instrument.prints:
        assert printed.response in {"", *test.responses, *test.curves}
        assert printed.response or printed.remark


def is_length(option: str) -> bool:
    return option.endswith(("radius", "diameter", "length", "width", "depth", "gap"))


@pytest.mark.parametrize("name", instrument_names())
def test_every_dimension_has_a_public_source(name: str) -> None:
    instrument = read_instrument(name)
    sources = [dimension.source for dimension in instrument.options.values()]
    assert all(len(source) > 10 for source in sources)
    assert any("http" in source for source in sources)


def test_naming_an_instrument_or_writing_its_numbers_is_the_same_run(tmp_path: Path) -> None:
    by_name = gf.load(named(tmp_path, "GranuDrum"))
    instrument = read_instrument("granudrum")
    written = [f"{key} = {it.toml}" for key, it in instrument.options.items()]
    text = named(tmp_path, "", *written).read_text().replace('apparatus = "" #', "")
    (tmp_path / "by_hand.toml").write_text(text)
    by_hand = gf.load(tmp_path / "by_hand.toml")
    values = by_name.problem.from_unit([0.5] * by_name.problem.dimension)

    assert "42 mm" in text
    runs = [one.solvers["drum"].definition(values, 1).identity for one in (by_name, by_hand)]
    assert runs[0] == runs[1]


def test_options_beside_an_instrument_override_it_and_each_value_has_its_origin(
    tmp_path: Path,
) -> None:
    setup = gf.load(named(tmp_path, "granudrum", 'drum_length = "15 mm"'))
    values = {value.name: value for value in simulated_apparatus(setup)["drum"]}

    assert setup.bulk_tests["drum"].resolved_options()["drum_length"] == pytest.approx(0.015)
    assert (values["drum_length"].value, values["drum_length"].origin) == ("15 mm", "given")
    assert (values["drum_radius"].value, values["drum_radius"].origin) == ("42 mm", "instrument")
    assert values["fill_level"].origin == "assumed"
    page = tmp_path / "preview.html"
    done = CliRunner().invoke(app, ["preview", str(setup.file.path), "--output", str(page)])
    assert done.exit_code == 0, done.output
    assert "as of GranuDrum (Granutools): drum radius 42 mm" in page.read_text(encoding="utf-8")
    lines = [*opening_lines(setup)]
    assert any(messages.OF_INSTRUMENT.is_in(line) and "drum radius 42 mm" in line for line in lines)
    assert not any(messages.NEVER_DESCRIBED.is_in(line) for line in lines)


def test_unknown_names_are_answered_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        gf.load(named(tmp_path, "granudrun"))
    [fault] = caught.value.faults
    assert messages.NO_INSTRUMENT.is_in(str(fault))
    assert of_options.MEANT.is_in(str(fault), name="granudrum")

    with pytest.raises(InputError) as caught:
        gf.load(named(tmp_path, "iso 60"))
    [fault] = caught.value.faults
    assert messages.OTHER_TYPE.is_in(str(fault))
    assert 'type = "packing"' in str(fault)


def test_a_new_file_can_begin_with_an_instrument_that_its_particles_fit(tmp_path: Path) -> None:
    path = tmp_path / "new.toml"
    plastic = ["--material", "plastic"]
    done = CliRunner().invoke(app, ["new", str(path), "--test", "granudrum", *plastic])
    assert done.exit_code == 0, done.output
    [test] = gf.load(path).file.tests
    assert (test.name, test.instrument) == ("granudrum", read_instrument("granudrum"))

    beads = CliRunner().invoke(app, ["new", str(tmp_path / "x.toml"), "--test", "granudrum"])
    assert isinstance(beads.exception, InputError)
    assert "drum_radius" in str(beads.exception)
    assert not (tmp_path / "x.toml").exists()


def test_the_command_lists_instruments_and_shows_one_with_its_sources() -> None:
    listed = CliRunner().invoke(app, ["apparatus"])
    shown = CliRunner().invoke(app, ["apparatus", "GranuDrum"])
    missing = CliRunner().invoke(app, ["apparatus", "granudrun"])

    assert all(name in listed.output for name in instrument_names())
    for dimension in read_instrument("granudrum").options.values():
        assert dimension.source in " ".join(shown.output.split())
    assert "surface_angle" in shown.output
    assert missing.exit_code == 1
    assert messages.NO_INSTRUMENT.is_in(str(missing.exception))


def test_examples_of_stresses_follow_the_stress_of_an_instrument() -> None:
    text = starter_test("ft4_shear")
    assert '# normal_stress = "10 kPa"' in text
    assert (
        'targets.major_consolidation_stress = { value = "15000 Pa", uncertainty = "5 %" }' in text
    )
    text = starter_test("schulze_1_litre")
    assert '\nnormal_stress = "500 Pa"' in text
    assert 'targets.major_consolidation_stress = { value = "750 Pa"' in text


def test_examples_of_a_heap_on_a_disc_have_its_height_and_no_base() -> None:
    text = starter_test("granuheap")
    assert "base_radius" not in text
    # 20 mm at 22 degrees.
    assert 'targets.heap_height = { value = "8.08 mm"' in text
    assert 'targets.base_radius = { value = "130 mm"' in starter_test("heap")


@pytest.mark.parametrize(
    ("apparatus", "test", "line", "dropped"),
    [
        ("granupack", "tapped", 'fill_height = "50 mm"', "bulk_density_top"),
        ("cipac_mt_169", "tapped", 'fill_height = "90 mm"', "bulk_density_top"),
        ("hall_flowmeter", "hopper", 'fill_height = "30 mm"', "fill_mass"),
    ],
)
def test_another_filling_takes_what_goes_with_it_from_an_instrument(
    tmp_path: Path, apparatus: str, test: str, line: str, dropped: str
) -> None:
    path = named(tmp_path, apparatus, line, 'orifice_diameter = "15 mm"', test=test)
    if test == "tapped":
        path = named(tmp_path, apparatus, line, test=test)
    setup = gf.load(path)
    origins = {one.name: one.origin for one in simulated_apparatus(setup)[test]}

    assert dropped in read_instrument(apparatus).options
    assert dropped not in setup.file.tests[0].of_instrument
    assert origins["fill_height"] == "given"
    assert dropped not in origins


def test_heights_of_a_measure_are_listed_and_its_taps_are_not_too_few(tmp_path: Path) -> None:
    setup = gf.load(named(tmp_path, "cipac_mt_169", test="tapped"))
    values = {one.name: one for one in simulated_apparatus(setup)["tapped"]}

    assert values["bulk_density_top"].value == "99 mm"
    assert values["bulk_density_top"].origin == "instrument"
    assert "bulk_density_bottom" not in values
    assert "few-taps" not in {finding.check for finding in describe_plan(setup).findings}
