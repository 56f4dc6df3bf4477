"""`grainfit analyse` and `gf.analyse_runs`: what runs say without any simulation."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.analysis import messages as of_analysis
from grainfit.cli.app import app
from grainfit.work_folder import messages

MODEL = "def shear(parameters, seed):\n    raise RuntimeError('it was simulated')\n"
FILE = """\
name = "shear"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
name = "shear"
type = "python"
function = "model.py:shear"
targets.force = { value = "30 mN", uncertainty = 0.001, unit = "N" }
"""
SECOND = """\
[[test]]
name = "drop"
type = "python"
function = "model.py:shear"
targets.height = { value = 0.5, uncertainty = 0.02 }
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "model.py").write_text(MODEL)
    path = tmp_path / "shear.toml"
    path.write_text(FILE)
    monkeypatch.chdir(tmp_path)
    return path


def write_table(name: str, header: list[str], slope: float, noise: float, runs: int = 14) -> None:
    """Write a table of runs of a response that is proportional to the friction."""
    random = np.random.default_rng(4)
    with Path(name).open("w", newline="") as table:
        writer = csv.writer(table)
        writer.writerow(["friction", *header])
        for friction in np.linspace(0.1, 0.9, runs):
            writer.writerow([friction, slope * friction + random.normal(0, noise)])


def test_the_posterior_is_that_of_the_runs_and_nothing_is_simulated(file: Path) -> None:
    write_table("runs.csv", ["force [mN]"], 60.0, 0.1)
    found = gf.analyse_runs("shear.toml", "runs.csv")
    assert found.runs == 14
    posterior = found.analysis.posterior
    assert posterior is not None
    # force = 0.06 friction, 30 ± 1 mN.
    assert posterior.median("friction") == pytest.approx(0.5, abs=0.005)
    assert np.std(posterior.values) == pytest.approx(0.001 / 0.06, rel=0.1)
    assert found.analysis.intervals["friction"].determination == "determined"
    assert found.disagreement == ""
    text = str(found)
    assert "0.0300 ± 0.0010" in text
    assert of_analysis.DETERMINED_TO.is_in(text, name="friction")
    assert "force depends on friction" in text
    assert not Path("shear.grainfit").exists()
    done = CliRunner().invoke(app, ["analyse", "shear.toml", "--runs", "runs.csv"])
    assert done.exit_code == 0, done.output
    assert of_analysis.DETERMINED_TO.is_in(done.output, name="friction")


def test_tables_of_several_tests_are_named_and_combined(file: Path) -> None:
    file.write_text(FILE.replace("uncertainty = 0.001", "uncertainty = 0.01") + SECOND)
    write_table("force.csv", ["force"], 0.06, 0.0001)
    write_table("height.csv", ["height"], 1.0, 0.001)
    both = gf.analyse_runs("shear.toml", ["shear=force.csv", "drop=height.csv"])
    assert both.runs == 28
    assert both.analysis.posterior is not None
    assert np.std(both.analysis.posterior.values) == pytest.approx(0.02, rel=0.15)
    only = gf.analyse_runs("shear.toml", "shear=force.csv")
    assert only.analysis.posterior is not None
    assert np.std(only.analysis.posterior.values) > 0.1
    assert any("drop.height" in note for note in only.analysis.notes)
    with pytest.raises(gf.InputError, match=messages.WHICH_TEST.matching(tests="shear, drop")):
        gf.analyse_runs("shear.toml", "force.csv")


TWO = """\
name = "two"
[parameters]
friction = { min = 0.1, max = 0.9 }
bounce = { min = 0.3, max = 0.9 }
size = 3
[[test]]
name = "shear"
type = "python"
function = "model.py:shear"
parameters = ["friction"]
targets.force = { value = 0.03, uncertainty = 0.001 }
[[test]]
name = "drop"
type = "python"
function = "model.py:drop"
parameters = ["bounce"]
targets.height = { value = 0.5, uncertainty = 0.02 }
"""
TWO_MODELS = """\
def shear(parameters, seed):
    return {"force": 0.06 * parameters["friction"] + 1e-5 * (seed % 7), "strain": 1.0}

def drop(parameters, seed):
    return {"height": parameters["bounce"] + 1e-4 * (seed % 7), "time": 2.0}
"""


@pytest.fixture
def exported(file: Path) -> Path:
    """A file of two tests with a parameter each, and its runs as grainfit exports them."""
    (file.parent / "model.py").write_text(TWO_MODELS)
    path = file.with_name("two.toml")
    path.write_text(TWO)
    for number in range(9):
        settings = [f"friction={0.1 + 0.1 * number}", f"bounce={0.3 + 0.05 * number}"]
        gf.repeat_runs(path, repeat=1, seed=number + 1, settings=settings)
    done = CliRunner().invoke(app, ["runs", "export", "two.simulated", "all.csv"])
    assert done.exit_code == 0, done.output
    return path


def test_an_export_of_several_tests_is_analysed_and_imported_as_it_is(exported: Path) -> None:
    found = gf.analyse_runs(exported, ["shear=all.csv", "drop=all.csv"])
    assert found.runs == 18
    assert found.analysis.posterior is not None
    assert found.analysis.posterior.median("friction") == pytest.approx(0.5, abs=0.01)
    assert found.analysis.posterior.median("bounce") == pytest.approx(0.5, abs=0.02)
    assert not {"friction", "bounce", "force", "height"}.intersection(found.ignored)
    assert not {"strain", "time"}.intersection(found.ignored)
    from_folder = gf.analyse_runs(exported, "two.simulated")
    assert from_folder.analysis.posterior is not None
    assert found.analysis.posterior.median("friction") == pytest.approx(
        from_folder.analysis.posterior.median("friction"), rel=0.01
    )
    for test in ("shear", "drop"):
        done = CliRunner().invoke(
            app, ["runs", "import", "two.toml", "all.csv", "--test", test, "--workdir", "again"]
        )
        assert "Imported 9 runs" in done.output
        assert f"{test}; 0 were there already." in done.output
    for test in ("shear", "drop"):
        done = CliRunner().invoke(
            app,
            ["runs", "import", "two.toml", "all.csv", "--test", test, "--workdir", "two.simulated"],
        )
        assert "Imported 0 runs" in done.output
        assert f"{test}; 9 were there already." in done.output


def test_a_response_is_said_to_depend_on_parameters_of_its_test_alone(exported: Path) -> None:
    text = str(gf.analyse_runs(exported, ["shear=all.csv", "drop=all.csv"]))
    assert re.search(r"shear.force depends on friction \(\d+ % of its variance\)\.\s", text)
    assert re.search(r"drop.height depends on bounce \(\d+ % of its variance\)\.\s", text)


def test_a_table_needs_the_parameters_of_its_test_alone(exported: Path) -> None:
    write_table("force.csv", ["force"], 0.06, 0.0001)
    found = gf.analyse_runs(exported, ["shear=force.csv", "drop=all.csv"])
    assert found.runs == 14 + 9
    Path("more.csv").write_text("friction,bounce,force\n0.2,0.4,0.012\n0.3,,0.018\n")
    assert gf.analyse_runs(exported, "shear=more.csv").ignored == ("bounce (shear=more.csv)",)
    Path("less.csv").write_text("bounce,force\n0.4,0.012\n")
    with pytest.raises(gf.InputError, match="line 1, column friction: is missing"):
        gf.analyse_runs(exported, "shear=less.csv")


def test_what_is_given_twice_counts_once(exported: Path) -> None:
    given = ["shear=all.csv", "drop=all.csv", "shear=./all.csv", "two.simulated", "two.simulated/"]
    found = gf.analyse_runs(exported, given)
    assert found.runs == gf.analyse_runs(exported, [*given[:2], given[3]]).runs
    assert "shear=./all.csv a second time" in found.ignored
    assert "two.simulated/ a second time" in found.ignored


def test_runs_that_several_sources_share_count_once(exported: Path) -> None:
    alone = gf.analyse_runs(exported, "two.simulated")
    lines = Path("all.csv").read_text().splitlines(keepends=True)
    Path("earlier.csv").write_text("".join(lines[:9]))
    for given in (
        ["two.simulated", "shear=all.csv", "drop=all.csv"],
        ["shear=all.csv", "drop=all.csv", "two.simulated"],
        ["drop=earlier.csv", "shear=all.csv", "two.simulated"],
    ):
        found = gf.analyse_runs(exported, given)
        assert " a second time" in found.ignored[-1]
        # Counted twice, the same runs would hardly seem to scatter.
        for name, quality in found.analysis.quality.items():
            assert quality.noise == pytest.approx(alone.analysis.quality[name].noise, rel=0.01)


def test_lines_without_a_seed_are_runs_of_their_own(file: Path) -> None:
    write_table("monday.csv", ["force"], 0.06, 0.0001)
    write_table("friday.csv", ["force"], 0.061, 0.0001)
    found = gf.analyse_runs("shear.toml", ["monday.csv", "friday.csv"])
    assert (found.runs, found.ignored) == (28, ())


def test_lines_of_tests_with_other_names_are_of_the_test_unless_it_is_named(file: Path) -> None:
    lines = "0.2,0.012,old\n0.3,0.018,old\n"
    Path("runs.csv").write_text("friction,force,test\n" + lines)
    assert gf.analyse_runs("shear.toml", "runs.csv").runs == 2
    Path("runs.csv").write_text("friction,force,test\n0.4,0.024,shear\n" + lines)
    assert gf.analyse_runs("shear.toml", "runs.csv").runs == 1


def test_runs_at_one_place_are_counted_for_their_test_alone(exported: Path) -> None:
    Path("one.csv").write_text("friction,force\n" + 5 * "0.2,0.012\n")
    notes = gf.analyse_runs(exported, ["shear=one.csv", "drop=all.csv"]).analysis.notes
    assert any(
        "5 runs gave the response 'shear.force', at only 1 different place" in n for n in notes
    )


def test_measurements_that_nothing_agrees_with_are_told(file: Path) -> None:
    write_table("runs.csv", ["force"], 0.02, 0.0001)
    found = gf.analyse_runs("shear.toml", "runs.csv")
    assert found.disagreement.startswith("No parameter set within the intervals agrees")
    # 0.9 · 0.02 = 18 mN instead of 30 ± 1.
    assert "force is 0.01" in found.disagreement
    assert found.disagreement in str(found)


def test_the_runs_of_a_work_folder_can_be_analysed(file: Path) -> None:
    (file.parent / "model.py").write_text(
        "def shear(parameters, seed):\n"
        "    return {'force': 0.06 * parameters['friction'] + 1e-5 * (seed % 7)}\n"
    )
    setup = gf.load("shear.toml")
    for number in range(9):
        gf.repeat_runs(
            setup, repeat=1, seed=number + 1, settings=[f"friction={0.1 + 0.1 * number}"]
        )
    found = gf.analyse_runs(setup, "shear.simulated")
    assert found.runs == 9
    assert found.analysis.posterior is not None
    assert found.analysis.posterior.median("friction") == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("friction,forces\n0.3,1\n", "forces"),
        ("friction,force\n0.3,much\n", "line 2"),
        ("friction,force\n", "holds no runs"),
    ],
)
def test_faults_of_a_table_are_named(file: Path, table: str, words: str) -> None:
    Path("runs.csv").write_text(table)
    done = CliRunner().invoke(app, ["analyse", "shear.toml", "--runs", "runs.csv"])
    assert isinstance(done.exception, gf.InputError)
    assert words in str(done.exception)


def test_too_few_runs_are_told_and_no_runs_refused(file: Path) -> None:
    Path("runs.csv").write_text("friction,force\n0.3,0.02\n")
    found = gf.analyse_runs("shear.toml", "runs.csv")
    assert found.analysis.posterior is None
    assert "are needed" in str(found)
    with pytest.raises(gf.InputError, match=messages.NO_TABLES.pattern):
        gf.analyse_runs("shear.toml", [])
    gf.repeat_runs("shear.toml", repeat=1, workdir="other")
    (file.parent / "model.py").write_text(f"# Another model.\n{MODEL}")
    with pytest.raises(gf.InputError, match=messages.NO_RUN_OF_THE_FILE.pattern):
        gf.analyse_runs("shear.toml", "other")
