"""Tests and values that mean something else than was measured are noted before any run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.bulk_tests.drum import messages as of_drum
from grainfit.bulk_tests.heap import messages as of_heap
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.bulk_tests.shared import messages as shared
from grainfit.bulk_tests.shear import messages as of_shear
from grainfit.calibration_file.checks import messages as of_values
from grainfit.calibration_file.starter import starter_file
from grainfit.messages import Message

Notes = Callable[..., list[str]]


@pytest.fixture
def notes(tmp_path: Path) -> Notes:
    def found(test: str, *changes: tuple[str, str]) -> list[str]:
        text = starter_file([test])
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new, 1)
        path = tmp_path / "calibration.toml"
        path.write_text(text, encoding="utf-8")
        return list(gf.load(path).notes())

    return found


def option(test: str, line: str) -> tuple[str, str]:
    return f'type = "{test}"', f'type = "{test}"\n{line}'


@pytest.mark.parametrize(
    ("test", "line", "limit", "message"),
    [
        ("heap", 'cylinder_radius = "{} mm"', (50, 49), shared.NARROW_CYLINDER),
        ("packing", 'cylinder_radius = "{} mm"', (50, 49), shared.NARROW_CYLINDER),
        ("compression", 'cylinder_radius = "{} mm"', (50, 49), shared.NARROW_CYLINDER),
        ("heap", 'lift_speed = "{} m/s"', (0.12, 0.13), of_heap.FAST_LIFT),
        ("drum", "froude_number = {}", (0.02, 0.021), of_drum.FAST_DRUM),
        ("shear", "inertial_number = {}", (0.01, 0.011), of_shear.FAST_SHEAR),
    ],
)
def test_an_apparatus_beyond_its_range_is_noted_with_its_number(
    notes: Notes, test: str, line: str, limit: tuple[float, float], message: Message
) -> None:
    within, beyond = (
        [message.is_in(note) for note in notes(test, option(test, line.format(value)))]
        for value in limit
    )
    assert not any(within)
    assert sum(beyond) == 1


def test_a_flow_through_an_assumed_depth_is_noted(notes: Notes) -> None:
    for test, depth in {"draw_down": "80 mm", "discharge": "50 mm"}.items():
        [note] = [note for note in notes(test) if shared.FLOW_DEPTH.is_in(note)]
        assert f"simulated depth of {depth}" in note
        given = notes(test, option(test, f'depth = "{depth}"'))
        assert not [note for note in given if shared.FLOW_DEPTH.is_in(note)]
    round_one = notes("discharge", option("discharge", 'orifice = "round"'))
    assert not [note for note in round_one if shared.FLOW_DEPTH.is_in(note)]


@pytest.mark.parametrize(
    ("test", "example"),
    [("draw_down", 'mass_flow = { value = "1.75 kg/s"'), ("discharge", '{ value = "1.16 kg/s"')],
)
def test_a_flow_far_from_that_of_the_opening_is_asked_about(
    notes: Notes, test: str, example: str
) -> None:
    assert not [note for note in notes(test) if shared.UNUSUAL_FLOW.is_in(note)]
    # Ten times the flow, too, at a density that is free by a factor of two.
    for unit in ("17500 kg/s", "17.5 kg/s", "12 kg/s", "0.002 kg/s"):
        changed = (example, example[: example.index('"')] + f'"{unit}"')
        assert [note for note in notes(test, changed) if shared.UNUSUAL_FLOW.is_in(note)], unit


@pytest.mark.parametrize(
    ("change", "message", "said"),
    [
        (option("heap", "gravity = 981"), of_values.UNUSUAL_GRAVITY, "981 cm/s^2"),
        (('diameter = "10 mm"', "diameter = 0.5"), of_values.UNUSUAL_DIAMETER, "10 mm"),
        (('{ value = "22 deg"', "{ value = 0.38"), of_values.SMALL_ANGLE, "0.38 rad"),
        (('{ value = "22 deg"', "{ value = 79"), of_values.STEEP_ANGLE, "11 deg"),
    ],
)
def test_a_value_beside_all_experience_is_asked_about(
    notes: Notes, change: tuple[str, str], message: Message, said: str
) -> None:
    assert not [note for note in notes("heap") if message.is_in(note)]
    [note] = [note for note in notes("heap", change) if message.is_in(note)]
    assert said in note


def test_a_density_of_particles_in_another_unit_is_asked_about(tmp_path: Path) -> None:
    lines = [
        'density = { min = "2 kg/m^3", max = "3 kg/m^3" }'
        if line.startswith("density = {")
        else line
        for line in starter_file(["heap"]).splitlines()
    ]
    path = tmp_path / "calibration.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    [note] = [n for n in gf.load(path).notes() if of_values.UNUSUAL_DENSITY.is_in(n)]
    assert "3 g/cm^3" in note


def test_a_density_of_walls_in_another_unit_is_asked_about(notes: Notes) -> None:
    text = starter_file(["heap"])
    walls = text[text.index("[wall]") :]
    line = next(line for line in walls.splitlines() if line.startswith("density"))
    [note] = [
        note
        for note in notes("heap", (line, 'density = "7.7 kg/m^3"'))
        if of_values.UNUSUAL_DENSITY.is_in(note)
    ]
    assert note.startswith("wall.density = 7.7 kg/m^3")


def test_an_assumed_size_is_noted_where_it_moves_a_response_beyond_its_tolerance(
    notes: Notes,
) -> None:
    """The bulk density of a larger heap is 5 % higher, its tolerance is 1 %."""
    found = [note for note in notes("heap") if of_values.ASSUMED_SIZE.is_in(note)]
    assert len(found) == 1
    assert "cylinder_radius is assumed, 60 mm" in found[0]
    assert "bulk_density by +" in found[0]
    given = notes("heap", option("heap", 'cylinder_radius = "70 mm"'))
    assert not any(of_values.ASSUMED_SIZE.is_in(note) for note in given)


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_test_has_an_option_that_says_how_large_it_is(name: str) -> None:
    assert BUILT_IN[name].vessel in {key.name for key in BUILT_IN[name].option_keys()}


def test_a_plate_that_is_not_given_is_noted_below_a_heap_that_spreads_on_it(notes: Notes) -> None:
    """The starting walls (0.27, 0.05) halve the angle of the starting heap, without a failure."""
    sliding = ("plate_sliding_friction = 0.5 ", "# ")
    rolling = ("plate_rolling_friction =", "# ")

    def found(*changes: tuple[str, str]) -> list[str]:
        return [n for n in notes("heap", *changes) if shared.ASSUMED_PLATE.is_in(n)]

    assert not found()
    assert shared.ASSUMED_PLATE.is_in(found(sliding)[0], value=0.27)
    assert shared.ASSUMED_PLATE.is_in(found(rolling)[0], value=0.05)
    assert len(found(sliding, rolling)) == 2
