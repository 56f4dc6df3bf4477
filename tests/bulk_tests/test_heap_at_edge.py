"""A heap whose shape its plate has decided gives the bulk density of the bed alone."""

from __future__ import annotations

import re
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.shared import messages
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.calibration_file.starter import starter_file
from grainfit.campaign.absent_responses import absences
from grainfit.campaign.batch import simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.campaign.reuse import needed_responses, runs_of
from grainfit.campaign.store.store import RunStore
from grainfit.cli.app import app
from grainfit.evaluation import Evaluation, Proposal
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_PLATE, ROUGH_SPHERES
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.status import read_status

REASON = Heap.responses["base_radius"].absent
ABSENT = f"no angle_of_repose, base_radius, heap_height, profile: {REASON}"
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


@pytest.mark.parametrize("shape", ["angle_of_repose", "base_radius", "heap_height"])
def test_a_run_with_a_target_for_the_shape_has_failed_with_the_reason(
    folder: Path, shape: str
) -> None:
    setup = beads(folder, "65 mm", shape)
    for _ in range(2):
        found = simulated(setup, folder / "work", is_needed=True)
        assert found.failures == {"heap": ABSENT}
        assert not found.response_names
        # It is the same run, and would be the same again.
        assert found.reused == 1


def test_the_same_run_keeps_the_density_where_nobody_needs_the_shape(folder: Path) -> None:
    setup = beads(folder, "65 mm", "bulk_density")
    for is_needed in (True, False):
        found = simulated(setup, folder / "work", is_needed=is_needed)
        assert found.response_names == {"bulk_density"}
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
    for targets, failures in ((["bulk_density"], {}), (["angle_of_repose"], {"heap": ABSENT})):
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
    beads(folder, "65 mm", "bulk_density")
    work = ["--workdir", str(folder / "work")]
    simulated = CliRunner().invoke(app, ["simulate", str(folder / "beads.toml"), *work])
    assert simulated.exit_code == 0, simulated.output
    [run] = (folder / "work" / "runs").iterdir()
    measured = CliRunner().invoke(app, ["measure", str(run)])
    for shown in (simulated.output, measured.output):
        assert ABSENT in " ".join(shown.split())
        assert "bulk_density" in shown


@pytest.mark.parametrize(
    ("plate", "targets", "noted"),
    [
        ("100 mm", ["base_radius"], "base_radius"),
        ("80 mm", ["angle_of_repose", "heap_height"], "angle_of_repose and heap_height"),
        ("80 mm", ["angle_of_repose"], "angle_of_repose"),
        ("80 mm", ["bulk_density"], ""),
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


@pytest.mark.parametrize(
    ("sliding", "rolling", "noted"),
    [
        # Wall friction of the file, 0.3 and 0.05: spread, but no failure (`assumed-plate`).
        ("", "", ""),
        ("0.5", '"particle_particle"', ""),
        ("0.1", '"particle_particle"', "plate_sliding_friction"),
        ("0.5", "0", "plate_rolling_friction"),
    ],
)
def test_a_plate_on_which_heaps_slide_apart_is_noted(
    tmp_path: Path, sliding: str, rolling: str, noted: str
) -> None:
    text = re.sub(r"(?m)^plate_\w+_friction.*\n", "", starter_file(["heap"]))
    given = {"sliding": sliding, "rolling": rolling}
    lines = [f"plate_{kind}_friction = {value}\n" for kind, value in given.items() if value]
    path = tmp_path / "beads.toml"
    path.write_text(text.replace('solver = "', f'{"".join(lines)}solver = "', 1), encoding="utf-8")
    notes = [note for note in gf.load(path).notes() if messages.SMOOTH_PLATE.is_in(note)]
    assert [noted in note for note in notes] == [True] * bool(noted)


def test_a_heap_that_slides_apart_on_the_walls_fails_with_that_reason(tmp_path: Path) -> None:
    text = re.sub(r"(?m)^plate_\w+_friction.*\n", "", starter_file(["heap"]))
    text = text.replace('youngs_modulus = "10 MPa"', 'youngs_modulus = "1 MPa"')
    walls = text.index("[particle_wall]")
    smooth = re.sub(r"(?m)^(\w+ing_friction) = .*", r"\1 = 0.1", text[walls:], count=2)
    (tmp_path / "beads.toml").write_text(
        text[:walls] + smooth.replace('type = "heap"', f'type = "heap"\n{SMALL}'), encoding="utf-8"
    )
    found = simulated(gf.load(tmp_path / "beads.toml"), tmp_path / "work", is_needed=True)
    assert "plate_sliding_friction" in found.failures["heap"]


def heap_on_disc(**options: object) -> Heap:
    given = {"base": "disc", "strike_off_height": "60 mm", "bulk_density_top": "50 mm"}
    return Heap(diameter="10 mm", **{**ROUGH_PLATE, **given, **options})


def test_a_disc_is_as_wide_as_the_cylinder_and_a_plate_is_the_run_that_it_was() -> None:
    disc, plate = heap_on_disc(cylinder_radius="55 mm"), Heap(diameter="10 mm", base="plate")
    recorded = disc.definition()

    assert disc.setup.plate_radius == pytest.approx(0.055)
    assert recorded["setup"]["base"] == "disc"
    assert Heap.from_definition(recorded).definition() == recorded
    assert "base" not in plate.definition()["setup"]
    with pytest.raises(gf.InputError, match="plate_radius"):
        heap_on_disc(cylinder_radius="55 mm", plate_radius="54 mm")


def test_a_heap_that_does_not_cover_its_disc_is_no_result(tmp_path: Path) -> None:
    heap = heap_on_disc(cylinder_radius="45 mm", plate_radius="110 mm", lift_speed="0.15 m/s")
    with pytest.raises(gf.RunFailedError) as caught:
        Lammps(heap, ROUGH_SPHERES).run({}, 1, Workspace(tmp_path, 300))
    assert messages.NOT_COVERED.is_in(str(caught.value))


@pytest.mark.slow
def test_a_heap_that_covers_its_disc_has_an_angle(tmp_path: Path) -> None:
    heap = Heap(diameter="10 mm", base="disc", **ROUGH_PLATE)
    found = Lammps(heap, ROUGH_SPHERES).run({}, 1, Workspace(tmp_path, 300))
    assert 20 < found["angle_of_repose"].value < 32
    # Half a diameter less than the disc, one diameter above it.
    assert found["base_radius"].value == pytest.approx(0.055, abs=0.005)
