"""Time of a calibration in its plan, what would shorten it, and impossible bulk densities."""

from __future__ import annotations

import math
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.calibration.messages import GUIDED_BY_ATLAS
from grainfit.calibration_file.build import CalibrationSetup, load_calibration
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.run_time import RunTime, costs_of_runs, expected_runs, run_time
from grainfit.cli.app import app
from grainfit.formatting import duration

NO_ATLAS = "[strategy]\natlas = false\n\n"
EXAMPLE = Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml"
TEXT = EXAMPLE.read_text(encoding="utf-8")
WIDE = (
    'type = "heap"\ncylinder_radius = "200 mm"\nplate_radius = "700 mm"\n'
    'strike_off_height = "400 mm"\nlift_height = "500 mm"'
)


def setup(tmp_path: Path, *changes: tuple[str, str]) -> CalibrationSetup:
    text = TEXT
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (tmp_path / "beads.toml").write_text(text, encoding="utf-8")
    return load_calibration(tmp_path / "beads.toml")


def notes_on_density(tmp_path: Path, *changes: tuple[str, str]) -> list[str]:
    return [note for note in setup(tmp_path, *changes).notes() if "out of reach" in note]


def time_of(setup: CalibrationSetup) -> RunTime | None:
    runs = expected_runs(setup.file, setup.problem, setup.solvers)
    costs = costs_of_runs(setup.problem, setup.solvers)
    return run_time(runs, costs, setup.repeats, setup.workers)


def test_time_is_that_of_the_runs_of_the_plan_by_the_workers(tmp_path: Path) -> None:
    beads = setup(tmp_path)
    runs = expected_runs(beads.file, beads.problem, beads.solvers)
    cost = beads.solvers["heap"].estimate_cost(beads.problem.middle)
    assert cost is not None
    time = time_of(beads)
    assert time is not None
    fewest, most = runs.to_come.range
    assert time.seconds[1] == pytest.approx(-(-most // beads.workers) * cost.wall_seconds)
    assert runs.design + runs.verification <= fewest < most
    lines = describe_plan(beads).lines
    [line] = [line for line in lines if line.startswith("DEM runs")]
    assert line.startswith(f"DEM runs: {runs.to_come}, {runs.design} of them for the design;")
    [line] = [line for line in lines if line.startswith("Time: ")]
    assert str(time) in line
    assert not any("The calibration takes" in note for note in describe_plan(beads).notes)


def test_budget_limits_the_time(tmp_path: Path) -> None:
    beads = setup(tmp_path, ("[[test]]", "[strategy]\nmax_runs = 10\nworkers = 1\n\n[[test]]"))
    time = time_of(beads)
    assert time is not None
    assert time.seconds[1] == pytest.approx(10 * time.costs["heap"])


@pytest.mark.parametrize(
    ("hours", "words"),
    [(47, "47 h 00 min"), (48, "2 days 00 h"), (100, "4 days 04 h"), (142230, "5926 days")],
)
def test_long_durations_are_in_days(hours: float, words: str) -> None:
    assert duration(3600 * hours) == words


def test_calibration_of_days_says_what_would_shorten_it_and_to_what(tmp_path: Path) -> None:
    stiff = ('youngs_modulus = "0.36 MPa"', 'youngs_modulus = "500 MPa"')
    beads = setup(tmp_path, ('type = "heap"', WIDE), stiff)
    time = time_of(beads)
    assert time is not None
    assert time.is_long
    [note] = [n for n in describe_plan(beads).notes if n.startswith("The calibration takes")]
    assert "days" in str(time)
    modulus = re.search(r"particle\.youngs_modulus = (\S+) MPa", note)
    assert modulus is not None
    assert messages.USUAL_DIMENSIONS.is_in(note, type="heap", count=1500)
    assert "particle.coarse_graining = 2" in note
    # What it offers takes about the time that it says.
    softer = setup(
        tmp_path, ('type = "heap"', WIDE), (stiff[0], f'youngs_modulus = "{modulus[1]} MPa"')
    )
    assert f"to bulk densities, it would take {time_of(softer)}" in note
    usual = setup(tmp_path, stiff)
    found = re.search(r"of that size \(expected to move ([^)]*)\), it would take ([^;]*);", note)
    assert found is not None
    assert "bulk_density by -" in found[1]
    assert found[2] == str(time_of(usual))
    assert messages.WITH_TWINS.is_in(note, count=3000)


def test_timeout_is_noted_beside_a_test_whose_time_is_not_known(tmp_path: Path) -> None:
    folder = EXAMPLE.parents[1] / "own_model"
    text = (folder / "heap_and_drop.toml").read_text(encoding="utf-8")
    path = tmp_path / "two.toml"
    text = text.replace('type = "heap"', 'type = "heap"\ntimeout = "1 s"')
    path.write_text(text.replace('folder = "model"', f'folder = "{folder / "model"}"'))
    assert [
        n for n in describe_plan(load_calibration(path)).notes if n.startswith("Test heap: time")
    ]


def test_timeout_below_the_time_of_a_run_is_noted(tmp_path: Path) -> None:
    beads = setup(tmp_path, ('type = "heap"', 'type = "heap"\ntimeout = "1 s"'))
    [note] = [note for note in describe_plan(beads).notes if "timeout" in note]
    assert note.startswith("Test heap: timeout = 1 s, but a run takes about ")
    longer = setup(tmp_path, ('type = "heap"', 'type = "heap"\ntimeout = "1 h"'))
    assert not any("timeout" in note for note in describe_plan(longer).notes)


def test_bulk_density_above_every_packing_is_noted_with_a_possible_interval(
    tmp_path: Path,
) -> None:
    low = ('max = "2793 kg/m^3"', 'max = "1700 kg/m^3"')
    [note] = notes_on_density(tmp_path, low)
    assert messages.IMPOSSIBLE_BULK_DENSITY.is_in(note, density=1700, fraction=0.79)
    assert "above 0.74" in note
    proposed = re.search(r"density = (\{ min = .* \})", note)
    assert proposed is not None
    interval = '{ min = "1407 kg/m^3", max = "2793 kg/m^3" }'
    assert notes_on_density(tmp_path, (interval, proposed[1])) == []
    assert note in setup(tmp_path, low).notes()


def test_bulk_density_below_every_packing_is_noted(tmp_path: Path) -> None:
    [note] = notes_on_density(tmp_path, ('value = "1500 kg/m^3"', 'value = "300 kg/m^3"'))
    assert "solid fraction of 0.21, below 0.35" in note


@pytest.mark.parametrize(
    "change",
    [
        ('value = "1500 kg/m^3"', "value = 1.5"),
        ('{ min = "1407 kg/m^3", max = "2793 kg/m^3" }', "{ min = 1.4, max = 2.8 }"),
    ],
)
def test_a_density_in_another_unit_is_called_that(tmp_path: Path, change: tuple[str, str]) -> None:
    [note] = notes_on_density(tmp_path, change)
    assert messages.ANOTHER_UNIT.is_in(note)
    assert "density = {" not in note


def test_a_tolerance_far_below_the_scatter_is_noted(tmp_path: Path) -> None:
    def found(uncertainty: str) -> list[str]:
        beads = setup(tmp_path, ('uncertainty = "1 %"', f"uncertainty = {uncertainty}"))
        return [note for note in beads.notes() if "runs scatter by" in note]

    # Meant as 1 %, and read as 1 kg/m^3.
    [note] = found("1")
    assert "scatter by about 0.6 %, and its tolerance, 1 kg/m^3, is 0.067 % of the value" in note
    assert messages.FINE_TOLERANCE.is_in(note, runs="about 450", undecided=9)
    assert messages.MEANT_AS_PERCENTAGE.is_in(note)
    assert found('"1 %"') == found('"0.4 %"') == []


def test_run_forecasts_with_its_budget_what_check_forecasts(tmp_path: Path) -> None:
    setup(tmp_path, ('uncertainty = "1 %"', 'uncertainty = "0.2 %"'))
    file = tmp_path / "beads.toml"
    checked = grainfit("check", file)
    assert messages.FINE_TOLERANCE.is_in(checked, runs="about 55", undecided=8, budget=48)
    # Too few for the design: nothing is simulated.
    started = grainfit("run", file, "--max-runs", "3", "--workdir", tmp_path / "work")
    assert "about 55 runs. About 9 of 10" in started
    assert messages.FINE_TOLERANCE.is_in(started, budget=3, wide=0.32, offered=26)
    assert "angle_of_repose: recorded runs scatter by" in started


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("budget", [None, 9, 12])
def test_the_progress_begins_with_the_numbers_of_check(tmp_path: Path, budget: int | None) -> None:
    one = ("[[test]]", "[strategy]\nworkers = 1\n\n[[test]]")
    setup(tmp_path, one)
    file = tmp_path / "beads.toml"
    given = [] if budget is None else ["--max-runs", str(budget)]
    begun = progress_of(file, *given)
    if budget is not None:
        file.write_text(
            file.read_text().replace("workers = 1", f"workers = 1\nmax_runs = {budget}")
        )
    [planned] = re.findall(r"DEM runs: (.+?), 5 of them for the design", grainfit("check", file))
    assert f"0 done, 1 running, 0 failed, {planned} to come" in begun
    # By the recorded scatter of the angle: 2.24 standard errors within the tolerance.
    scatter = gf.tests.Heap.responses["angle_of_repose"].trials.scatter * 22 / 0.5
    needed = int(1.1 * (2.24 * scatter) ** 2 + 6)
    assert planned == (
        f"about {needed} ({int(needed / 1.6)} to {math.ceil(1.6 * needed)})"
        if budget is None
        else str(budget)
    )


def progress_of(file: Path, *given: str) -> str:
    """Start a calibration; return its output up to its first line of progress, and stop it."""
    words = [sys.executable, "-m", "grainfit", "run", file, "--no-report", *given]
    # The work folder is made where the command is started.
    with subprocess.Popen(
        words, cwd=file.parent, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL
    ) as process:
        assert process.stderr is not None
        text = b""
        while b" to come" not in text and (line := process.stderr.readline()):
            text += line
        process.send_signal(signal.SIGINT)
        process.communicate()
    return text.decode()


def grainfit(*arguments: object) -> str:
    """Run a command; return its output in one line."""
    runner = CliRunner(env={"COLUMNS": "400"})
    return " ".join(runner.invoke(app, [str(one) for one in arguments]).output.split())


@pytest.mark.parametrize(
    "changes",
    [
        [],
        # Small particles fill the gaps between large ones.
        [
            ('max = "2793 kg/m^3"', 'max = "1700 kg/m^3"'),
            (
                'diameter = "10 mm"',
                'diameter = [{ value = "10 mm", mass_fraction = 0.7 },'
                ' { value = "4 mm", mass_fraction = 0.3 }]',
            ),
        ],
        # Clumps pack more densely than spheres.
        [
            ('max = "2793 kg/m^3"', 'max = "1700 kg/m^3"'),
            ('diameter = "10 mm"', 'diameter = "10 mm"\nshape = "two_spheres"\naspect_ratio = 1.5'),
        ],
        # Soft particles overlap: 1.14 of the density of stiff ones.
        [('value = "1500 kg/m^3"', 'value = "2300 kg/m^3"')],
        # A cohesive bed may be as loose as it likes.
        [
            ('value = "1500 kg/m^3"', 'value = "300 kg/m^3"'),
            ("restitution = 0.79", 'restitution = 0.79\nsurface_energy = "0.01 J/m^2"'),
        ],
    ],
)
def test_nothing_is_said_where_a_packing_is_possible(
    tmp_path: Path, changes: list[tuple[str, str]]
) -> None:
    assert notes_on_density(tmp_path, *changes) == []


def test_time_of_an_own_model_is_not_known(tmp_path: Path) -> None:
    own = gf.load(EXAMPLE.parents[1] / "own_model" / "calibration.toml")
    assert time_of(own) is None
    assert describe_plan(own).seconds is None


def test_a_long_run_offers_larger_particles_and_a_smaller_apparatus(tmp_path: Path) -> None:
    beads = setup(tmp_path, ('type = "heap"', WIDE), ('"0.36 MPa"', '"20 MPa"'))
    [note] = [n for n in describe_plan(beads).notes if n.startswith("Test heap: a run takes")]
    twins = re.search(r"strategy\.twins = ([0-9]+) searches", note)
    assert twins is not None
    assert note.count("expected to move bulk_density by -") == 2
    offered = setup(
        tmp_path,
        ('type = "heap"', WIDE),
        ('"0.36 MPa"', '"20 MPa"'),
        ("[[test]]", f"[strategy]\ntwins = {twins[1]}\n\n[[test]]"),
    )
    twin = offered.twins["heap"].bulk_test
    assert twin is not None
    assert twin.number_of_particles == pytest.approx(3000, rel=0.2)
    assert not [n for n in describe_plan(offered).notes if n.startswith("Test heap: a run takes")]


@pytest.mark.parametrize(
    ("changes", "design"),
    [
        ({"rolling_damping = 0.25": "rolling_damping = 0.0"}, 3),
        # The atlas does not have that law.
        ({}, 5),
        ({"rolling_damping = 0.25": "rolling_damping = 0.0", "[[test]]": f"{NO_ATLAS}[[test]]"}, 5),
    ],
)
def test_the_plan_says_that_the_atlas_guides_the_search(
    tmp_path: Path, changes: dict[str, str], design: int
) -> None:
    text = EXAMPLE.read_text()
    for old, new in changes.items():
        text = text.replace(old, new)
    (tmp_path / "beads.toml").write_text(text)
    setup = load_calibration(tmp_path / "beads.toml")

    runs = expected_runs(setup.file, setup.problem, setup.solvers)

    assert runs.design == design
    assert list(runs.guided) == (["heap"] if design == 3 else [])
    said = " ".join(describe_plan(setup).lines)
    assert GUIDED_BY_ATLAS.is_in(said, tests="heap") == (design == 3)
