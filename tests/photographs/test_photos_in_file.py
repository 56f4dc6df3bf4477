"""Targets that are measured on photographs: measured once, named when they change."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.calibration_file import messages
from grainfit.calibration_file.originals import keep_pictures
from grainfit.cli.app import app
from grainfit.measurement.angle_of_repose import heap_silhouettes
from grainfit.measurement.heap_size import heap_profile
from grainfit.photographs import messages as of_photographs
from tests.photographs.drawn_pictures import cone
from tests.photographs.photographed_heap import ANGLE, PROFILE, load


def test_a_target_is_the_angle_that_the_photographs_have(folder: Path) -> None:
    target = load(folder, ANGLE + PROFILE).problem.targets[0]
    alone = gf.photo([folder / "heap_1.jpg", folder / "heap_2.jpg"], plate="620 mm")

    assert target.value == round(alone.angle_of_repose.value, 2)
    assert target.uncertainty == round(alone.angle_of_repose.standard_error, 2)
    assert target.value == pytest.approx(25.0, abs=1.0)


def test_the_outline_is_that_of_the_simulated_heap_within_its_uncertainty(folder: Path) -> None:
    curve = load(folder, PROFILE).problem.curves[0]

    heap = cone(25.0, 10.0, 1)
    truth = heap_profile(heap_silhouettes(heap, 0.31, 12), heap.diameter, 0.31)
    heights = np.interp(curve.coordinates, truth.coordinates, truth.values)
    assert len(curve.values) >= 6
    assert curve.coordinates[-1] > 0.12
    deviations = np.abs(np.array(curve.values) - heights) / curve.standard_uncertainties
    assert deviations.max() < 3
    assert curve.standard_uncertainties.max() < 0.06 * heights.max()


def test_check_shows_every_picture_and_where_the_overlays_are(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    load(folder, ANGLE)
    shutil.copytree("work", "beads.grainfit")
    done = CliRunner().invoke(app, ["check", "beads.toml"])

    assert messages.PHOTOGRAPHS.is_in(done.output), done.output
    assert messages.PICTURE_MEASURED.is_in(done.output)
    assert "heap_2.jpg" in done.output
    assert messages.OVERLAYS.is_in(done.output)
    assert len(list(Path("beads.grainfit/photographs").glob("heap_*_measured.png"))) == 2


def test_a_picture_is_measured_once_as_long_as_the_code_is_the_same(folder: Path) -> None:
    for path in (folder / "work/photographs").glob("*.json"):
        kept = json.loads(path.read_text())
        path.write_text(json.dumps({**kept, "angle": 30.0}))
    assert load(folder, ANGLE).problem.targets[0].value == 30.0

    for path in (folder / "work/photographs").glob("*.json"):
        path.write_text(json.dumps({**json.loads(path.read_text()), "version": "before"}))
    assert load(folder, ANGLE).problem.targets[0].value == pytest.approx(25.0, abs=1.0)


def test_a_calibration_keeps_what_an_earlier_version_has_measured(folder: Path) -> None:
    setup = load(folder, ANGLE)
    keep_pictures(setup.file.photographed, folder / "work", folder)
    for path in (folder / "work/photographs").glob("heap_*.json"):
        kept = json.loads(path.read_text())
        path.write_text(json.dumps({**kept, "angle": 30.0, "version": "before"}))

    again = load(folder, ANGLE)
    assert again.problem.targets[0].value == 30.0
    assert any(messages.EARLIER_CODE.is_in(note) for note in again.notes())


def test_hashes_of_the_originals_belong_to_the_calibration(folder: Path) -> None:
    hashes = load(folder, ANGLE).provenance.pictures

    assert set(hashes["angle_of_repose"]) == {"heap_1.jpg", "heap_2.jpg"}
    assert all(len(digest) == 64 for digest in hashes["angle_of_repose"].values())


def test_pictures_that_changed_moved_or_are_gone_are_named(folder: Path) -> None:
    keep_pictures(load(folder, ANGLE).file.photographed, folder / "work", folder)
    first, second = folder / "heap_1.jpg", folder / "heap_2.jpg"

    first.rename(folder / "kept.jpg")
    assert messages.PICTURE_MOVED(file="heap_1.jpg", path="kept.jpg") in load(folder, ANGLE).notes()
    second.rename(first)
    notes = load(folder, ANGLE).notes()
    assert messages.PICTURE_CHANGED(file="heap_1.jpg") in notes
    (folder / "kept.jpg").unlink()
    first.rename(second)
    assert messages.PICTURE_GONE(file="heap_1.jpg") in load(folder, ANGLE).notes()


def test_a_named_picture_that_moved_is_refused_with_file_key_and_line(folder: Path) -> None:
    named = 'targets.angle_of_repose = { photos = ["heap_1.jpg"], plate = "620 mm" }\n'
    keep_pictures(load(folder, named).file.photographed, folder / "work", folder)
    (folder / "other").mkdir()
    (folder / "heap_1.jpg").rename(folder / "other" / "heap_1.jpg")

    with pytest.raises(gf.InputError) as error:
        load(folder, named)

    said = str(error.value)
    assert "beads.toml: line 25" in said
    assert "targets.angle_of_repose.photos[0]" in said
    assert messages.MOVED_TO(path="other/heap_1.jpg") in said


def test_the_same_picture_twice_is_refused(folder: Path) -> None:
    shutil.copy(folder / "heap_1.jpg", folder / "heap_3.jpg")

    with pytest.raises(gf.InputError) as error:
        load(folder, ANGLE)
    assert of_photographs.SAME_PICTURE(file="heap_3.jpg", other="heap_1.jpg") in str(error.value)


def test_an_outline_without_a_known_length_is_refused(folder: Path) -> None:
    with pytest.raises(gf.InputError, match="marker sheet"):
        load(folder, 'targets.profile = { photos = "heap_1.jpg" }\n')


def test_a_picture_without_the_sheet_is_refused_where_it_is_to_be_seen(folder: Path) -> None:
    with pytest.raises(gf.InputError, match=of_photographs.NO_MARKER.pattern):
        load(folder, 'targets.angle_of_repose = { photos = "heap_1.jpg", marker = true }\n')


def test_without_the_extra_the_command_that_installs_it_is_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.rmtree(folder / "work")
    monkeypatch.setitem(sys.modules, "cv2", None)

    with pytest.raises(gf.InputError) as error:
        load(folder, ANGLE)
    assert "pip install 'grainfit[photos]'" in str(error.value)
    assert "line 25" in str(error.value)
