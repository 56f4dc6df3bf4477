"""Every face names the simulated apparatus, and what of it is assumed."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.bulk_tests import messages
from grainfit.bulk_tests.apparatus import ApparatusValue, apparatus_of
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration.provenance import Provenance
from grainfit.calibration_file.apparatus import opening_lines, simulated_apparatus
from grainfit.calibration_file.starter import starter_file
from grainfit.cli.app import app
from grainfit.report.sections.answer.simulated_tests import simulated_tests

GEOMETRY = 'cylinder_radius = "70 mm"\nlift_speed = "0.04 m/s"'


def heap_file(folder: Path, lines: str = GEOMETRY) -> Path:
    path = folder / "beads.toml"
    text = starter_file(["heap"]).replace('type = "heap"', f'type = "heap"\n{lines}')
    path.write_text(text, encoding="utf-8")
    return path


def apparatus(path: Path) -> dict[str, ApparatusValue]:
    [values] = simulated_apparatus(gf.load(path)).values()
    return {value.name: value for value in values}


def test_values_are_in_the_units_of_a_laboratory_given_or_assumed(tmp_path: Path) -> None:
    found = apparatus(heap_file(tmp_path))
    shown = {name: (value.value, value.origin) for name, value in found.items()}
    assert shown["cylinder_radius"] == ("70 mm", "given")
    assert shown["lift_speed"] == ("0.04 m/s", "given")
    assert shown["plate_radius"] == ("160 mm", "assumed")
    assert shown["plate_rolling_friction"] == ("as between particles", "given")
    # Mass of the count of spheres of 10 mm in the middle of the interval of the density.
    count, mass = found["particles"].value.removesuffix(" kg").split(", ")
    density = gf.load(tmp_path / "beads.toml").problem.middle["particle.density"]
    assert float(mass) == pytest.approx(int(count) * density * 5.236e-7, rel=5e-3)


def test_a_plate_of_the_walls_has_their_friction(tmp_path: Path) -> None:
    path = heap_file(tmp_path)
    lines = [x for x in path.read_text().splitlines() if not x.startswith("plate_")]
    path.write_text("\n".join(lines), encoding="utf-8")
    plate = apparatus(path)["plate_sliding_friction"]
    friction = gf.load(path).file.fixed["particle_wall.sliding_friction"]
    assert (plate.value, plate.origin) == (f"of the walls, {friction:g}", "assumed")


@pytest.mark.parametrize("name", BUILT_IN)
def test_what_was_given_is_found_in_the_record_of_a_run(name: str) -> None:
    kind = BUILT_IN[name]
    plain = {value.name: value.origin for value in apparatus_of(kind(diameter="10 mm"))}
    assert set(plain.values()) == {"assumed"}
    recorded = kind.from_definition(kind(diameter="10 mm", gravity=9.0).definition())
    assert {value.origin for value in apparatus_of(recorded)} == {"assumed"}


def test_a_given_speed_is_found_however_it_was_given() -> None:
    drum = BUILT_IN["drum"](diameter="10 mm", froude_number=0.02)
    found = {value.name: value for value in apparatus_of(drum, ["froude_number"])}
    assert found["rotational_speed"] == ApparatusValue("rotational_speed", "14.95 rpm", "given")
    assert found["drum_radius"].origin == "assumed"


def test_check_preview_and_report_name_it(tmp_path: Path) -> None:
    path = heap_file(tmp_path)
    text = " ".join(CliRunner().invoke(app, ["check", str(path)]).output.split())
    assert "Apparatus of heap, given: cylinder radius 70 mm, lift speed 0.04 m/s" in text
    assert "Apparatus of heap, assumed: plate radius 160 mm" in text
    document = json.loads(CliRunner().invoke(app, ["check", str(path), "--json"]).output)
    radius = {"name": "cylinder_radius", "value": "70 mm", "origin": "given", "instrument": ""}
    assert radius in document["apparatus"]["heap"]

    page = tmp_path / "preview.html"
    done = CliRunner().invoke(app, ["preview", str(path), "--output", str(page)])
    assert done.exit_code == 0, done.output
    assert "Apparatus of heap, assumed: plate radius 160 mm" in page.read_text(encoding="utf-8")

    [test] = simulated_tests(gf.load(path).bulk_tests, {})
    origins = {name: origin for name, _, _, origin in test.options}
    assert origins["cylinder_radius"] == "given"
    assert (origins["plate_radius"], origins["views"]) == ("assumed", "")


def test_a_given_value_that_is_the_default_stays_given(tmp_path: Path) -> None:
    setup = gf.load(heap_file(tmp_path, 'cylinder_radius = "60 mm"'))
    stored = Provenance.from_json(json.loads(json.dumps(asdict(setup.provenance))))
    [test] = simulated_tests(setup.bulk_tests, stored.options)
    origins = {name: origin for name, _, _, origin in test.options}
    assert (origins["cylinder_radius"], origins["plate_radius"]) == ("given", "assumed")


def test_texts_of_options_are_shown_without_marks_of_code() -> None:
    example = Path(__file__).parents[2] / "examples" / "discharge_curve" / "calibration.toml"
    [test] = simulated_tests(gf.load(example).bulk_tests, {})
    meanings = {name: meaning for name, meaning, *_ in test.options}
    assert '"measured"' in meanings["flow_until"]
    assert not any("`" in meaning for meaning in meanings.values())


def test_a_heap_that_was_never_described_is_said_so(tmp_path: Path) -> None:
    path = heap_file(tmp_path, "")
    # The starting file gives the plate.
    given, rest = opening_lines(gf.load(path))
    assert messages.GIVEN.is_in(given)
    assert "plate rolling friction as between particles" in given
    assert messages.REST_NOT_DESCRIBED.is_in(rest)
    assert "plate radius" in rest
    assert "friction" not in rest
    without_plate = [x for x in path.read_text().splitlines() if not x.startswith("plate_")]
    path.write_text("\n".join(without_plate), encoding="utf-8")
    [line] = opening_lines(gf.load(path))
    assert messages.NEVER_DESCRIBED.is_in(line)
    described = [*opening_lines(gf.load(heap_file(tmp_path)))]
    faults = (messages.NEVER_DESCRIBED, messages.REST_NOT_DESCRIBED)
    assert not any(message.is_in(line) for line in described for message in faults)
    assert len(described) == 2
