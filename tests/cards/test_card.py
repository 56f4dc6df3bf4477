"""Contents of a material card in every format, and cards that are refused."""

from __future__ import annotations

import ast
import csv
import io
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported_beads import FIXED, FREE
from typer.testing import CliRunner

import grainfit
from grainfit import ground_messages
from grainfit.bulk_tests.heap import Heap
from grainfit.calibration_file.starter import starter_file
from grainfit.campaign import messages as of_campaign
from grainfit.cards import FORMATS, MaterialCard, material_card, messages, render, write_card
from grainfit.cli import messages as cli_messages
from grainfit.cli.app import app
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import GrainfitError, InputError, StoreError
from grainfit.solvers.dem import messages as of_dem
from grainfit.testing.decks import write_deck
from grainfit.verdict.messages import STATUS_WORDS
from grainfit.work_folder import messages as of_work_folder
from grainfit.work_folder.saved_calibration import SavedCalibration

DRUM = grainfit.Problem(
    [grainfit.Parameter("Kohäsion", 0.0, 7e4, unit="J/m^3")],
    [grainfit.Target("angle", 36.0, tolerance=0.5, unit="deg")],
)


def drum(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return {"angle": 30 + parameters["Kohäsion"] / 7e3}


def table(card: MaterialCard) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(render(card, "csv"), newline="")))


def test_runs_are_counted_as_in_the_report(tmp_path: Path) -> None:
    first = grainfit.calibrate(DRUM, drum, workdir=tmp_path)
    [target] = DRUM.targets
    other = replace(DRUM, targets=[replace(target, value=35.0)])
    result = grainfit.calibrate(other, drum, workdir=tmp_path)

    card = material_card(tmp_path)
    counts = result.runs.total, result.runs.warm_start_runs
    assert (card.runs, card.earlier_runs) == counts
    assert card.earlier_runs == first.runs.total
    assert f"{counts[0]} + {counts[1]} of earlier" in card.runs_in_words


@pytest.fixture(scope="session")
def calibrated_drum(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("calibrated.grainfit")
    grainfit.calibrate(DRUM, drum, workdir=folder)
    return folder


@pytest.fixture(scope="session")
def unreachable_drum(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("unreachable.grainfit")
    problem = replace(DRUM, targets=[replace(DRUM.targets[0], value=50.0)])
    grainfit.calibrate(problem, drum, workdir=folder, max_runs=20)
    return folder


@pytest.fixture(scope="session")
def undecided_drum(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A calibration whose runs scatter by several tolerances."""
    folder = tmp_path_factory.mktemp("undecided.grainfit")

    def scattering(parameters: dict[str, float], seed: int) -> dict[str, float]:
        noise = 3 * np.random.default_rng(seed).standard_normal()
        return {"angle": drum(parameters, seed)["angle"] + noise}

    grainfit.calibrate(DRUM, scattering, workdir=folder, max_runs=20)
    return folder


@pytest.fixture
def drum_folder(calibrated_drum: Path, tmp_path: Path) -> Path:
    """A work folder of its own, to be damaged."""
    return shutil.copytree(calibrated_drum, tmp_path / "drum.grainfit")


def edit_result(folder: Path, edit: Callable[[dict], object]) -> None:
    file = folder / "result.json"
    result = json.loads(file.read_text())
    edit(result)
    file.write_text(json.dumps(result))


# --- content --------------------------------------------------------------------------------------


def test_a_card_holds_all_14_parameters_with_origin_and_interval(
    beads: Path, card: MaterialCard
) -> None:
    found = json.loads((beads / "result.json").read_text())["parameters"]
    needed = [name for name, known in MATERIAL_PARAMETERS.items() if known.default is None]
    assert [parameter.name for parameter in card.parameters] == needed
    assert card.values == {**FIXED, **found}
    origins = {parameter.name: parameter.origin for parameter in card.parameters}
    assert {name for name in origins if origins[name] == "calibrated"} == set(FREE)
    assert {origins[name] for name in FIXED} == {"given"}
    intervals = {p.name: p.interval for p in card.parameters if p.interval}
    assert intervals == {"particle.density": (2290.0, 2330.0)}


def test_a_card_says_how_the_targets_are_met_and_where_it_comes_from(
    beads: Path, card: MaterialCard
) -> None:
    result = json.loads((beads / "result.json").read_text())
    for response in card.responses:
        expected = result["responses"][response.name]
        assert response.expected == expected["predicted"], "expected by all runs"
        assert response.interval[1] - response.expected == pytest.approx(
            1.96 * expected["standard_error"]
        )
        assert response.verified_mean == expected["verified_mean"], "beside it"
        assert response.verdict == expected["verdict"] == "met"
    assert (card.runs, card.failed_runs) == (result["runs"]["total"], 0)
    assert (card.calibration_file, card.identity) == ("beads.toml", result["identity"])
    assert [program.name for program in card.programs] == ["lammps"]
    assert card.programs[0].version
    assert card.rayleigh_time_step == pytest.approx(result["rayleigh_time_step"], rel=1e-12)
    # The heap test was made with a tenth of the Rayleigh time step.
    assert card.recommended_time_step == pytest.approx(result["rayleigh_time_step"] / 10)


@pytest.mark.parametrize("to", FORMATS)
def test_every_number_of_a_card_reads_back_exactly(card: MaterialCard, to: str) -> None:
    text = render(card, to)
    for parameter in card.parameters:
        assert repr(parameter.value) in text, parameter.name
    if to != "csv":
        assert repr(card.recommended_time_step) in text


@pytest.mark.parametrize("to", ["liggghts", "lammps", "yade"])
def test_a_deck_is_told_units_origins_and_deviations(card: MaterialCard, to: str) -> None:
    text = render(card, to)
    density = "particle density of the solid, kg/m^3: calibrated, 95 % interval 2290 to 2330"
    assert f"{density}, determined" in text
    assert "wall Young's modulus, Pa: given" in text
    assert "angle_of_repose: 22 +/- 0.5 deg" in text
    assert f"met; fresh seeds {card.responses[1].verified_mean:.5g}" in text
    assert "Calibration file: beads.toml" in text
    assert card.identity in text
    assert (of_dem.CALIBRATED_DIFFERENTLY.is_in(text, solvers="LAMMPS")) == (to != "lammps")


def test_the_keys_of_the_json_card_are_those_of_the_documentation(card: MaterialCard) -> None:
    data = json.loads(render(card, "json"))
    documentation = Path(__file__).parents[2] / "docs" / "export.md"
    written = set()
    for line in documentation.read_text().partition("## JSON")[2].splitlines():
        if line.startswith("| `"):
            written |= set(re.findall(r"`(\w+)`", line.split("|")[1]))

    def keys(value: object) -> set[str]:
        if isinstance(value, dict):
            return set(value) | {key for held in value.values() for key in keys(held)}
        return {key for held in value for key in keys(held)} if isinstance(value, list) else set()

    assert keys(data) == written
    assert data["format_version"] == 3
    values = {parameter["name"]: parameter["value"] for parameter in data["parameters"]}
    assert values == card.values


def test_the_csv_card_has_a_line_for_each_parameter_and_response(card: MaterialCard) -> None:
    lines = table(card)
    kinds = [line["kind"] for line in lines]
    assert kinds[:16] == ["parameter"] * 14 + ["response"] * 2
    assert set(kinds[16:]) == {"equation", "convention"}
    density = next(line for line in lines if line["name"] == "particle.density")
    assert float(density["value"]) == card.values["particle.density"]
    assert (density["unit"], density["low_95"], density["high_95"]) == (
        "kg/m^3",
        "2290.0",
        "2330.0",
    )
    responses = [line for line in lines if line["kind"] == "response"]
    assert {line["met"] for line in responses} == {"yes"}
    assert {line["origin"] for line in responses} == {"expected by all runs"}


def test_cards_of_five_classes_have_all_of_them(card: MaterialCard) -> None:
    beads = grainfit.LogNormal(median="10 mm", geometric_standard_deviation=1.3)
    sizes = grainfit.divide_into_classes(beads)
    many = replace(card, sizes=sizes)

    for name in ("lammps", "liggghts", "yade"):
        header = " ".join(render(many, name).split("\n#"))
        assert f"Particle diameters: {sizes.words}" in " ".join(header.split()), name
    lammps = render(many, "lammps")
    between = [f"{i}_{j}" for i in range(1, 6) for j in range(i, 6)]
    assert all(f"particle_particle_contact_{pair} string" in lammps for pair in between)
    assert all(f"particle_wall_contact_{i} string" in lammps for i in range(1, 6))
    data = json.loads(render(many, "json"))["particle_sizes"]
    assert data["diameters"] == data["real_diameters"] == [*sizes.diameters]
    assert data["mass_fractions"] == [0.2] * 5


def test_the_lammps_card_has_the_coefficients_of_the_deck_it_was_calibrated_with(
    card: MaterialCard, tmp_path: Path
) -> None:
    sizes = grainfit.ParticleSizes((0.008, 0.010), (0.3, 0.7))
    text = render(replace(card, sizes=sizes), "lammps")
    friction = card.values["particle_wall.rolling_friction"]
    # The plate of the test has a friction of its own; the cylinder is the wall.
    deck = write_deck(Heap(sizes), tmp_path, "lammps", card.values, seed=1).read_text()
    words = " ".join(deck.replace("&", " ").split())
    for types in ("1 1", "1 2", "2 2"):
        coefficients = words.partition(f"pair_coeff {types} ")[2].partition(" pair_coeff")[0]
        coefficients = coefficients.partition(" group")[0]
        name = f"particle_particle_contact_{types.replace(' ', '_')}"
        assert f'{name} string "{coefficients}"' in text
    for number in (1, 2):
        start = f"fix cylinder{number} size{number} wall/gran/region granular "
        coefficients = words.partition(start)[2].partition(" region")[0]
        assert coefficients.endswith(f" {friction!r}")
        assert f'particle_wall_contact_{number} string "{coefficients}"' in text


# --- not calibrated -------------------------------------------------------------------------------


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize(
    "status", ["undecided", "out_of_tolerance", "unreachable", "interrupted", "failed"]
)
def test_a_card_that_is_not_calibrated_says_so_at_the_top(
    card: MaterialCard, to: str, status: str
) -> None:
    missed = tuple(replace(response, verdict="missed") for response in card.responses)
    text = render(replace(card, status=status, responses=missed), to)
    top = text if to in ("json", "csv") else "\n".join(text.splitlines()[:12])
    assert "NOT CALIBRATED: " in top
    assert "angle_of_repose" in top
    assert "NOT CALIBRATED" not in render(card, to)


def test_what_is_not_determined_does_not_look_like_a_result(card: MaterialCard) -> None:
    wide = (1000.0, 3500.0)
    for word, heading, beside in (
        ("not determined", "# NOT DETERMINED, other values agree as well: ", ", NOT DETERMINED"),
        ("narrowed", "# Only narrowed: ", ", only narrowed"),
    ):
        open_card = replace(
            card,
            parameters=tuple(
                replace(p, interval=wide, determination=word) if p.interval else p
                for p in card.parameters
            ),
        )
        for to in ("liggghts", "lammps", "yade"):
            text = render(open_card, to)
            assert f"{heading}particle.density" in text
            assert f"95 % interval 1000 to 3500{beside}" in text
        found = json.loads(render(open_card, "json"))["parameters"]
        density = next(p for p in found if p["name"] == "particle.density")
        assert density["determination"] == word
        (line,) = (one for one in table(open_card) if one["name"] == "particle.density")
        assert line["determination"] == word


def test_the_card_has_the_intervals_of_the_result(calibrated_drum: Path) -> None:
    [found] = grainfit.Result.from_json(calibrated_drum / "result.json").intervals.values()
    [parameter] = material_card(calibrated_drum).parameters
    assert parameter.interval == (found.low, found.high)
    assert parameter.determination == found.determination == "determined"


def test_a_card_tells_what_is_missed_from_what_is_in_doubt(card: MaterialCard) -> None:
    def said(verdict: str) -> tuple[str, str, dict[str, object], str]:
        angle = replace(card.responses[1], verdict=verdict)
        missed = replace(card, status="undecided", responses=(card.responses[0], angle))
        lines = render(missed, "liggghts").splitlines()
        data = json.loads(render(missed, "json"))["responses"][1]
        line = next(line for line in lines if "22 +/- 0.5" in line)
        [met] = [row["met"] for row in table(missed) if row["name"] == angle.name]
        return missed.verdict, line, data, met

    verdict, line, data, met = said("in doubt")
    assert verdict.endswith("(not met: angle_of_repose, which is in doubt)")
    assert ", IN DOUBT; fresh seeds" in line
    assert (data["verdict"], met) == ("in doubt", "no")
    verdict, line, data, met = said("missed")
    assert verdict.endswith("(not met: angle_of_repose)")
    assert ", NOT MET; fresh seeds" in line
    assert (data["verdict"], met) == ("missed", "no")


def test_a_target_out_of_reach_makes_a_card_that_is_not_calibrated(unreachable_drum: Path) -> None:
    card = material_card(unreachable_drum)
    assert not card.calibrated
    assert card.status == "unreachable"
    assert [parameter.origin for parameter in card.parameters] == ["not calibrated"]
    assert {line["verdict"] for line in table(card)} == {card.verdict}


def test_a_calibration_that_was_started_again_and_killed_is_not_calibrated(
    drum_folder: Path,
) -> None:
    assert material_card(drum_folder).calibrated
    with sqlite3.connect(drum_folder / "runs.sqlite") as connection:
        connection.execute("UPDATE calibrations SET status = 'running'")
    assert material_card(drum_folder).verdict.startswith("NOT CALIBRATED: interrupted")


def test_an_answer_without_fresh_seeds_has_no_mean_of_theirs(drum_folder: Path) -> None:
    def stop_before_verification(result: dict) -> None:
        result["status"] = "interrupted"
        for response in result["responses"].values():
            response |= dict.fromkeys(
                ("verified_mean", "verified_standard_error", "verified_interval"), None
            )

    edit_result(drum_folder, stop_before_verification)
    with sqlite3.connect(drum_folder / "runs.sqlite") as connection:
        connection.execute("UPDATE calibrations SET status = 'interrupted'")
    card = material_card(drum_folder)
    assert not card.calibrated
    assert card.parameters[0].origin == "not calibrated"
    assert card.responses[0].verified_mean is None
    assert json.loads(render(card, "json"))["responses"][0]["verified_mean"] is None


def test_an_undecided_calibration_makes_a_card_that_is_not_calibrated(
    undecided_drum: Path,
) -> None:
    card = material_card(undecided_drum)
    assert (card.status, card.calibrated) == ("undecided", False)
    assert card.verdict == (
        f"NOT CALIBRATED: {STATUS_WORDS['undecided']} (not met: angle, which is in doubt)"
    )
    assert [parameter.origin for parameter in card.parameters] == ["not calibrated"]
    data = json.loads(render(card, "json"))
    assert (data["calibrated"], data["status"]) == (False, "undecided")
    assert data["responses"][0]["verdict"] == "in doubt"
    assert any("probability of" in notice for notice in data["notices"]), "it says why"
    assert [line["verdict"] for line in table(card)] == [card.verdict] * 2
    assert table(card)[1]["met"] == "no"


def test_without_an_answer_there_is_no_card_but_what_to_do(
    drum_folder: Path,
) -> None:
    with pytest.raises(StoreError, match=of_campaign.NO_WORK_FOLDER.pattern):
        material_card(drum_folder / "none")
    (drum_folder / "result.json").rename(drum_folder / "result.old")
    with pytest.raises(InputError, match=of_work_folder.NO_ANSWER_FILE.pattern):
        material_card(drum_folder)
    for status, words in (
        ("running", "was interrupted before"),
        ("failed", "failed.*Remove the cause"),
    ):
        with sqlite3.connect(drum_folder / "runs.sqlite") as connection:
            connection.execute("UPDATE calibrations SET status = ?", (status,))
        with pytest.raises(InputError, match=f"no answer yet.*{words}"):
            material_card(drum_folder)


@pytest.mark.parametrize(
    "edit",
    [
        lambda result: result["parameters"].update({"Kohäsion": "=1"}),
        lambda result: result["parameters"].update({"Kohäsion": float("nan")}),
        lambda result: result["parameters"].update({"Kohäsion": 10**400}),
        lambda result: result.update(parameters={"other": 1.0}),
        lambda result: result.update(responses=[]),
        lambda result: result["responses"].update(angle=3.0),
        lambda result: result["responses"]["angle"].update(verdict="perhaps"),
        lambda result: result["responses"]["angle"].pop("target"),
        lambda result: result.update(status="perfect"),
        lambda result: result.update(notices=7),
        lambda result: result.pop("status"),
        lambda result: result["intervals"].update(other=result["intervals"]["Kohäsion"]),
        lambda result: result["intervals"]["Kohäsion"].update(low=6e4),
        lambda result: result["intervals"]["Kohäsion"].update(determination="sure"),
    ],
)
def test_a_damaged_result_is_named_and_never_exported(
    drum_folder: Path, edit: Callable[[dict], object]
) -> None:
    edit_result(drum_folder, edit)
    with pytest.raises(StoreError, match=r"result\.json' is damaged: .*no finished run"):
        material_card(drum_folder)


# --- models of one's own --------------------------------------------------------------------------


def test_a_model_of_ones_own_makes_cards_for_programs_and_no_others(
    calibrated_drum: Path,
) -> None:
    card = material_card(calibrated_drum)
    data = json.loads(render(card, "json"))
    assert data["parameters"][0]["name"] == "Kohäsion"
    assert data["particle_sizes"] is None
    assert table(card)[0]["name"] == "Kohäsion"
    for to in ("liggghts", "lammps", "yade"):
        with pytest.raises(InputError) as refused:
            render(card, to)
        assert f"a card for {to} needs particle.youngs_modulus, " in str(refused.value)
        assert "json or csv" in str(refused.value)


def test_the_card_of_a_model_of_ones_own_has_the_particles_of_its_file(tmp_path: Path) -> None:
    sizes = '[{ value = "4 mm", mass_fraction = 0.5 }, { value = "5 mm", mass_fraction = 0.5 }]'
    file = starter_file(["heap"])
    file = file[: file.index("\n[[test]]") + 1].replace(
        'diameter = "10 mm"', f"diameter = {sizes}\ncoarse_graining = 2"
    )
    (tmp_path / "model.py").write_text(
        "def simulate(parameters, seed):\n"
        "    return {'slope': 10 * parameters['particle_particle.sliding_friction']}\n"
    )
    (tmp_path / "own.toml").write_text(
        file + '[[test]]\ntype = "python"\nfunction = "model.py:simulate"\n'
        "targets.slope = { value = 5, uncertainty = 0.5 }\n"
    )
    grainfit.load(tmp_path / "own.toml").calibrate(tmp_path / "own.grainfit", max_runs=12)

    card = material_card(tmp_path / "own.grainfit")

    assert card.sizes is not None
    assert card.sizes.coarse_graining == 2
    assert card.sizes.real.diameters == pytest.approx((0.004, 0.005))
    assert card.sizes.mass_fractions == (0.5, 0.5)


def test_a_solver_is_not_given_what_no_material_has(card: MaterialCard) -> None:
    parameters = tuple(
        replace(p, value=0.0) if p.name == "particle.youngs_modulus" else p for p in card.parameters
    )
    for to in ("liggghts", "lammps", "yade"):
        with pytest.raises(InputError, match=r"particle\.youngs_modulus: is 0"):
            render(replace(card, parameters=parameters), to)


def test_lammps_and_yade_need_the_size_of_the_particles(card: MaterialCard) -> None:
    without = replace(card, sizes=None)
    for to in ("lammps", "yade"):
        with pytest.raises(InputError, match=r"needs particle\.diameter"):
            render(without, to)
    assert render(without, "liggghts")


def test_an_unknown_format_lists_those_that_there_are(card: MaterialCard) -> None:
    with pytest.raises(InputError, match=messages.NO_FORMAT.pattern):
        render(card, "xml")


@pytest.mark.parametrize("to", ["xml", ["json"], None])
def test_a_card_names_the_arguments_that_it_cannot_write(
    calibrated_drum: Path, tmp_path: Path, to: Any
) -> None:
    drum_card = material_card(calibrated_drum)
    with pytest.raises(InputError, match=r"^to: "):
        drum_card.write(to, tmp_path / "card")
    with pytest.raises(InputError, match=r"^path: "):
        drum_card.write("json", 3)  # type: ignore[arg-type]
    shown = CliRunner().invoke(app, ["export", str(calibrated_drum), "--to", "xml"])
    assert "--to: " in str(shown.exception)


# --- names that are up to no good -----------------------------------------------------------------


@pytest.mark.parametrize("to", ["liggghts", "lammps"])
def test_no_name_leaves_a_comment_of_a_deck(
    card: MaterialCard, nasty_card: MaterialCard, to: str
) -> None:
    def commands(text: str) -> list[str]:
        lines = text.splitlines()
        assert all(not line.rstrip().endswith("&") for line in lines if "#" in line)
        assert '"""' not in text
        return [line.partition("#")[0].rstrip() for line in lines if line.partition("#")[0].strip()]

    plain, nasty = commands(render(card, to)), commands(render(nasty_card, to))
    assert [line for line in nasty if line in plain] == plain
    added = [line for line in nasty if line not in plain]
    assert len(added) == 2
    assert {line.split()[0] for line in added} == {"variable"}
    assert len({line.split()[1] for line in added}) == 2


def test_no_name_leaves_a_comment_or_a_text_of_a_yade_script(
    card: MaterialCard, nasty_card: MaterialCard
) -> None:
    def without_values(text: str) -> list[str]:
        module = ast.parse(text.encode())
        held = [node for node in module.body if "PARAMETERS =" not in ast.unparse(node)]
        return [ast.unparse(node) for node in held]

    text = render(nasty_card, "yade")
    assert without_values(text) == without_values(render(card, "yade"))
    # Only the first two lines of a module can say what it is written in.
    assert "coding" not in "".join(text.splitlines()[:2])


def test_no_name_is_calculated_by_a_spreadsheet(nasty_card: MaterialCard) -> None:
    for line in table(nasty_card):
        for column, cell in line.items():
            number = column in ("value", "low_95", "high_95", "deviation_percent")
            assert number or not cell.startswith(("=", "+", "-", "@")), (column, cell)
            assert cell.isprintable()


def test_names_come_back_from_json_as_they_were(card: MaterialCard) -> None:
    for name in ("Glasperlen \n</script>", "half a character: \udcff"):
        assert json.loads(render(replace(card, name=name), "json"))["name"] == name
        assert render(replace(card, name=name), "json").encode()


# --- grainfit export ------------------------------------------------------------------------------


def test_export_prints_a_card_with_intervals(calibrated_drum: Path) -> None:
    command = [sys.executable, "-m", "grainfit", "export", str(calibrated_drum), "--to", "json"]
    # A terminal that knows no umlauts must not cost the card.
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, capture_output=True, timeout=120, check=False, env=environment)
    assert (done.returncode, done.stderr) == (0, b"")
    data = json.loads(done.stdout.decode())
    (parameter,) = data["parameters"]
    low, high = parameter["interval_95"]
    assert parameter["name"] == "Kohäsion"
    assert DRUM.intervals["Kohäsion"][0] < low < 4.2e4 < high < DRUM.intervals["Kohäsion"][1]


def test_export_replaces_a_file_when_asked_and_says_what_it_is(
    unreachable_drum: Path, tmp_path: Path
) -> None:
    file = tmp_path / "card.csv"
    file.write_text("of yesterday")
    command = ["export", str(unreachable_drum), "--to", "csv", "-o", str(file)]
    refused = CliRunner().invoke(app, command)
    assert cli_messages.NOT_REPLACED.is_in(str(refused.exception))
    assert file.read_text() == "of yesterday"
    done = CliRunner().invoke(app, [*command, "--force"])
    assert (done.exit_code, done.stdout) == (0, "")
    assert "card.csv" in done.stderr
    assert "NOT CALIBRATED: out of reach" in done.stderr
    assert file.read_text(encoding="utf-8").startswith("kind,name,")
    assert list(tmp_path.iterdir()) == [file]


def test_export_says_in_one_line_what_is_wrong(drum_folder: Path) -> None:
    (drum_folder / "result.json").unlink()
    for folder, to, words in (
        (drum_folder, "xml", "yade, edem, rocky, mercurydpm, pfc, mfix, aspherix, json or csv"),
        (drum_folder / "runs", "json", "is not a work folder"),
        (drum_folder, "json", "there is no answer yet"),
    ):
        done = CliRunner().invoke(app, ["export", str(folder), "--to", to])
        assert isinstance(done.exception, GrainfitError)
        assert words in str(done.exception)
        assert "\n" not in str(done.exception)
        assert done.stdout == ""


def test_a_card_goes_where_it_is_told_to_or_that_is_said(tmp_path: Path) -> None:
    for place in (tmp_path, tmp_path / "none" / "card", Path("/"), tmp_path / ("x" * 300)):
        with pytest.raises(InputError, match=ground_messages.CANNOT_BE_WRITTEN.pattern):
            write_card(place, "card")
    write_card(Path("/dev/null"), "card")
    assert Path("/dev/null").is_char_device(), "a device is written to, never replaced"
    (tmp_path / "link").symlink_to("card")
    write_card(tmp_path / "link", "Körnung")
    assert (tmp_path / "card").read_text(encoding="utf-8") == "Körnung"
    assert (tmp_path / "link").is_symlink()


@pytest.mark.parametrize("to", ["lammps", "json"])
def test_a_card_says_by_how_much_soft_particles_raise_the_density(beads: Path, to: str) -> None:
    text = " ".join(render(material_card(beads), to).replace("#", " ").split())

    assert "% above that of stiff particles" in text


def test_a_card_names_the_apparatus(beads: Path) -> None:
    text = " ".join(render(material_card(beads), "liggghts").replace("#", " ").split())

    assert "Apparatus of lammps, assumed: " in text
    assert "cylinder radius 60 mm" in text
    assert json.loads(render(material_card(beads), "json"))["apparatus"]


def test_a_card_has_what_the_file_gives_as_given_whatever_its_value(beads: Path) -> None:
    saved = replace(SavedCalibration.open(beads), options={"lammps": ["cylinder_radius"]})
    text = " ".join(render(material_card(saved), "liggghts").replace("#", " ").split())
    assert "Apparatus of lammps, given: cylinder radius 60 mm." in text
