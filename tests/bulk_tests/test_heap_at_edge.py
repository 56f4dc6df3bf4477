"""A heap whose size its plate has decided has an angle, and no base radius, height and profile."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.starter import starter_file
from grainfit.campaign.absent_responses import absences
from grainfit.campaign.batch import simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.reuse import needed_responses, runs_of
from grainfit.campaign.store.store import RunStore
from grainfit.cli.app import app
from grainfit.evaluation import Evaluation, Proposal
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.status import read_status

REASON = "the heap reaches the edge of the plate: use a larger plate_radius"
ABSENT = f"no base_radius, heap_height, profile: {REASON}"
#: A bed that makes heaps of about 85 mm radius, and a quick lift.
SMALL = """\
cylinder_radius = "35 mm"
strike_off_height = "85 mm"
bulk_density_top = "70 mm"
lift_speed = "0.3 m/s"
"""


def beads(folder: Path, plate: str, *targets: str) -> CalibrationSetup:
    """Return glass beads on a plate, with some of the targets of the heap test."""
    text = starter_file(["heap"]).replace('youngs_modulus = "10 MPa"', 'youngs_modulus = "1 MPa"')
    given = [
        line
        for line in text.splitlines()
        if not line.startswith("targets.") or line.split()[0].removeprefix("targets.") in targets
    ]
    path = folder / "beads.toml"
    kind = next(line for line in given if line.startswith('type = "heap"'))
    given[given.index(kind)] = f'{kind}\n{SMALL}plate_radius = "{plate}"'
    path.write_text("\n".join(given), encoding="utf-8")
    return gf.load(path)


def simulated(setup: CalibrationSetup, folder: Path, *, is_needed: bool) -> Evaluation:
    needed = needed_responses(setup.problem, setup.solvers) if is_needed else {}
    proposal = Proposal(setup.problem.middle, 1, "design")
    [found] = simulate_batch(setup.solvers, [proposal], folder, CampaignOptions(needed=needed))
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a work folder with one run, whose heap reaches the edge of a plate of 65 mm."""
    made = tmp_path_factory.mktemp("edge")
    simulated(beads(made, "65 mm", "angle_of_repose"), made / "work", is_needed=True)
    return made


@pytest.mark.parametrize("size", ["base_radius", "heap_height"])
def test_a_run_with_a_target_for_the_size_has_failed_with_the_reason(
    folder: Path, size: str
) -> None:
    setup = beads(folder, "65 mm", "angle_of_repose", size)
    for _ in range(2):
        found = simulated(setup, folder / "work", is_needed=True)
        assert found.failures == {"heap": ABSENT}
        assert not found.response_names
        # It is the same run, and would be the same again.
        assert found.reused == 1


def test_the_same_run_keeps_angle_and_density_where_nobody_needs_the_size(folder: Path) -> None:
    setup = beads(folder, "65 mm", "angle_of_repose")
    for is_needed in (True, False):
        found = simulated(setup, folder / "work", is_needed=is_needed)
        assert found.response_names == {"bulk_density", "angle_of_repose"}
        assert not found.failures
        assert found.reused == 1
    assert absences(setup.solvers, [found]) == [f"Seed 1: heap has {ABSENT}."]


def test_a_larger_plate_has_a_heap_with_a_size(folder: Path) -> None:
    setup = beads(folder, "120 mm", "base_radius")
    found = simulated(setup, folder / "large", is_needed=True)
    assert found.response_names == set(setup.bulk_tests["heap"].response_names or ())
    assert found.responses["base_radius"].value < 0.11
    assert not absences(setup.solvers, [found])


def test_known_runs_without_the_size_count_as_failures_where_it_is_needed(folder: Path) -> None:
    with closing(RunStore.in_folder(folder / "work")) as store:
        records = store.runs()
        assert [record.reason for record in store.incomplete_runs()] == [ABSENT]
    for targets, failures in ((["angle_of_repose"], {}), (["heap_height"], {"heap": ABSENT})):
        setup = beads(folder, "65 mm", *targets)
        [known] = runs_of(setup.problem, setup.solvers, records)
        assert known.failures == failures


def test_a_run_of_a_version_that_did_not_measure_the_size_is_repeated(
    folder: Path, tmp_path: Path
) -> None:
    with closing(RunStore.in_folder(folder / "work")) as known:
        [record] = known.incomplete_runs()
    with closing(RunStore.in_folder(tmp_path)) as store:
        store.save(replace(record, reason=""))
    found = simulated(beads(tmp_path, "65 mm", "base_radius"), tmp_path, is_needed=True)
    assert found.reused == 0
    assert found.failures == {"heap": ABSENT}


def test_a_calibration_names_the_reason_and_so_does_its_work_folder(tmp_path: Path) -> None:
    setup = beads(tmp_path, "65 mm", "base_radius")
    with pytest.raises(gf.RunFailedError, match=REASON):
        setup.calibrate(tmp_path / "work", max_runs=8, workers=2)

    status = read_status(tmp_path / "work")
    # Where there is hardly any friction, there is no heap either.
    assert ABSENT in {failed.reason for failed in status.failed}
    saved = SavedCalibration.open(tmp_path / "work")
    assert ABSENT in {found.failures["heap"] for found in saved.evaluations}
    assert {record.status for record in saved.records.values()} == {"failed"}


def test_the_command_line_says_what_a_run_is_without(folder: Path) -> None:
    beads(folder, "65 mm", "angle_of_repose")
    work = ["--workdir", str(folder / "work")]
    simulated = CliRunner().invoke(app, ["simulate", str(folder / "beads.toml"), *work])
    assert simulated.exit_code == 0, simulated.output
    [run] = (folder / "work" / "runs").iterdir()
    measured = CliRunner().invoke(app, ["measure", str(run)])
    for shown in (simulated.output, measured.output):
        assert ABSENT in " ".join(shown.split())
        assert "angle_of_repose" in shown


@pytest.mark.parametrize(
    ("plate", "targets", "noted"),
    [
        ("100 mm", ["base_radius"], "base_radius"),
        ("80 mm", ["angle_of_repose", "heap_height"], "heap_height"),
        ("80 mm", ["angle_of_repose"], ""),
        ("80 mm", ["heap_height"], ""),
        ("160 mm", ["angle_of_repose", "base_radius", "heap_height"], ""),
    ],
)
def test_a_plate_that_is_too_small_for_the_measured_heap_is_noted(
    tmp_path: Path, plate: str, targets: list[str], noted: str
) -> None:
    notes = [n for n in beads(tmp_path, plate, *targets).notes() if "too small for" in n]
    if not noted:
        assert not notes
        return
    [note] = notes
    assert note.startswith(f"Test heap: the plate of {plate} radius is too small for {noted}: ")


def test_nothing_is_said_of_a_plate_with_a_rim(tmp_path: Path) -> None:
    beads(tmp_path, '65 mm"\nrim_height = "10 mm', "angle_of_repose", "heap_height")
    assert not [n for n in gf.load(tmp_path / "beads.toml").notes() if "too small for" in n]
