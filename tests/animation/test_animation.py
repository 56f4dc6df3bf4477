"""Animations of runs: the same runs, with particles and walls where they are."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import needs
from grainfit.animation import drawn_film, messages
from grainfit.bulk_tests.heap import Heap
from grainfit.cli import messages as cli_messages
from grainfit.errors import InputError
from grainfit.scenes.film import FILM, Film, filmed
from grainfit.scenes.run_output import RunOutput
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from tests.animation.animated_runs import (
    COMPRESSION,
    HEAP,
    MODEL,
    calibration,
    film_of,
    made_up,
    metres,
    moving,
    numbers,
    page_of,
    places,
    run_folders,
    simulate,
    travels,
)

RADIUS = 0.005


def installed(name: str) -> Any:
    mark = pytest.mark.skipif(shutil.which(name) is None, reason=f"{name} is not installed")
    return pytest.param(name, marks=mark)


@pytest.mark.parametrize("solver", ["lammps", installed("liggghts"), installed("yade")])
def test_particles_and_walls_are_where_they_are(tmp_path: Path, solver: str) -> None:
    scene = filmed(moving(), 20, duration=0.2)
    program = DEM_PROGRAMS[solver](Heap(diameter="10 mm"), {})
    run = program.simulate(scene, Workspace(tmp_path, 120.0))
    steps = Film(run.folder / FILM).steps
    assert (len(steps), steps[0]) == (61, 0)
    assert set(np.diff(steps)) == {33}

    # Frames change nothing, to the last digit of the energies at the ends of the stages.
    (tmp_path / "plain").mkdir()
    plain = program.simulate(moving(), Workspace(tmp_path / "plain", 120.0))
    assert plain.stages == run.stages
    assert not (plain.folder / FILM).exists()

    film = film_of(page_of(run, scene))
    times = np.array(film["times"])
    found = places(film)
    fall = times < 0.03
    # The floor is at z = 0 of the drawing, the beads begin where the scene has them.
    heights = found[:, :, 2] - (found[0, 0, 2] - 0.0301)
    for begin, height in zip((0.0301, 0.05), heights[fall].T, strict=True):
        np.testing.assert_allclose(height, begin - 9.81 * times[fall] ** 2 / 2, atol=3e-5)
    # Soft beads hit the floor at half a metre per second.
    assert heights.min() == pytest.approx(RADIUS, abs=1.2e-3)

    floor, block, lid = (travels(film, wall) for wall in range(3))
    assert not floor.any()
    np.testing.assert_allclose(block, 0.1 * np.maximum(times - 0.15, 0), rtol=1e-3)
    is_there = (times > 0.03) & (times <= 0.15)
    assert (np.isfinite(lid) == is_there).all()
    # Lengths are known as well as the radius is as a whole number.
    sinks = -0.2 * np.minimum(times[is_there] - 0.03, 0.1)
    np.testing.assert_allclose(lid[is_there], sinks, rtol=1e-3)
    assert [wall["axis"] for wall in film["walls"]] == [2, 0, 2]
    stages = [(stage["name"], stage["begin"]) for stage in film["stages"]]
    assert stages == [("fall", 0), ("close", 0.03), ("wait", 0.13), ("push", 0.15)]


def responses(folder: Path) -> Any:
    return json.loads((folder / "run.json").read_text())["responses"]


@pytest.mark.slow
def test_a_run_with_frames_is_the_same_run(tmp_path: Path) -> None:
    (tmp_path / "plain").mkdir()
    (tmp_path / "filmed").mkdir()
    plain = calibration(tmp_path / "plain", HEAP, MODEL)
    simulate(plain)
    (folder,) = run_folders(plain)
    assert not (folder / FILM).exists()
    record = (folder / "run.json").read_bytes()

    # A new run keeps frames.
    animated = calibration(tmp_path / "filmed", HEAP, MODEL)
    done = simulate(animated, "--animate", "--frames", "20")
    (other,) = run_folders(animated)
    assert other.name == folder.name
    assert responses(other) == responses(folder)
    assert "again" not in done.output
    words = " ".join(done.output.split())
    assert f"Animation: {other / 'animation.html'} (20 frames, 0." in words
    assert re.search(rf"No animation of own: {messages.OWN_MODEL.pattern}\.", words)

    # A known one is simulated again, and stays as it is.
    done = simulate(plain, "--animate", "--frames", "20")
    assert "Simulating heap again" in done.output
    assert (folder / "run.json").read_bytes() == record
    assert not plain.with_suffix(".simulated").joinpath("filming").exists()
    # Its duration is known now.
    assert len(Film(folder / FILM).steps) == pytest.approx(60, abs=2)
    assert len(film_of(folder / "animation.html")["frames"]) == 20
    # Its frames are enough for another page.
    assert "again" not in simulate(plain, "--animate", "--frames", "30").output
    film = film_of(folder / "animation.html")
    assert len(film["frames"]) == len(film["times"]) == 30
    # The cylinder rises after the filling, and the beads above its rim are gone.
    times, lift = np.array(film["times"]), film["stages"][1]["begin"]
    rises = travels(film, 0)
    np.testing.assert_allclose(rises, 0.05 * np.maximum(times - lift, 0), atol=2e-4)
    is_gone = np.isnan(places(film)[:, :, 0])
    assert not is_gone[times <= lift].any()
    assert is_gone[-1].any()
    assert not is_gone[-1].all()


@pytest.mark.slow
@needs.LIGGGHTS
def test_a_piston_is_where_its_series_has_it(tmp_path: Path) -> None:
    file = calibration(tmp_path, COMPRESSION, solver="liggghts")
    file.write_text(file.read_text().replace('"1 MPa"', '"10 MPa"'))
    simulate(file, "--animate", "--frames", "40")
    (folder,) = run_folders(file)
    film = film_of(folder / "animation.html")
    times = np.array(film["times"])
    piston = travels(film, 2)
    run = RunOutput(folder)
    begin = run.stages[0].time
    assert np.isnan(piston[times <= begin]).all()
    assert np.isfinite(piston[times > begin]).all()
    series = run.series("load", ["travel"])
    here = (times >= series["time"][0]) & (times <= series["time"][-1])
    assert here.sum() > 5
    expected = np.interp(times[here], series["time"], series["travel"])
    np.testing.assert_allclose(piston[here], expected, atol=metres(film))
    # It touches the bed, into which it sinks a little.
    tops = np.nanmax(places(film)[:, :, 2], axis=1) + RADIUS
    lid = np.mean(numbers(film["walls"][2]["triangles"])[2::3]) * metres(film) + piston
    last = times > begin + 0.1
    np.testing.assert_allclose(tops[last], lid[last], atol=0.3 * RADIUS)


@pytest.mark.slow
def test_a_run_that_fails_is_shown_with_its_reason(tmp_path: Path) -> None:
    file = calibration(tmp_path, HEAP, more="time_step_fraction = 1.0")
    done = simulate(file, "--animate", code=1)
    reason = "the simulation became unstable in the fill stage"
    assert reason in done.output
    (folder,) = run_folders(file)
    page = (folder / "animation.html").read_text()
    assert f"<strong>This run failed:</strong> {reason}" in page
    assert '<span class="film-bad">particles broke out</span>' in page
    assert [one["name"] for one in film_of(folder / "animation.html")["stages"]] == ["fill"]


@pytest.mark.slow
def test_ctrl_c_leaves_the_run_that_is_simulated_again(tmp_path: Path, ctrl_c: None) -> None:
    file = calibration(tmp_path, HEAP)
    simulate(file)
    (folder,) = run_folders(file)
    kept = {path.name: path.read_bytes() for path in folder.glob("*.*")}
    command = [sys.executable, "-m", "grainfit", "simulate", file.name, "--animate"]
    command += ["--workdir", "beads.simulated"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        end = time.monotonic() + 60
        while not [*tmp_path.glob("beads.simulated/filming/runs/*.partial/film.dump")]:
            assert time.monotonic() < end
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, words = process.communicate(timeout=60)
    assert process.returncode == 130
    assert cli_messages.STOPPED.is_in(words)
    assert {path.name: path.read_bytes() for path in folder.glob("*.*")} == kept
    simulate(file, "--animate")
    assert (folder / "animation.html").exists()


def test_models_of_the_user_and_many_runs_are_refused(tmp_path: Path) -> None:
    file = calibration(tmp_path, MODEL)
    with pytest.raises(InputError, match=messages.NO_SCENE.pattern):
        raise_again(file, "--animate")
    with pytest.raises(InputError, match=cli_messages.ANIMATION_OF_ONE_RUN.pattern):
        raise_again(calibration(tmp_path, HEAP), "--animate", "--repeat", "2")
    with pytest.raises(InputError, match=cli_messages.FRAMES_WITHOUT_ANIMATION.pattern):
        raise_again(file, "--frames", "20")
    assert not run_folders(file)


def raise_again(file: Path, *arguments: str) -> None:
    error = simulate(file, *arguments, code=1).exception
    assert error is not None
    raise error


def test_a_page_of_many_particles_has_fewer_frames_and_then_fewer_particles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = made_up(tmp_path, moving())
    assert len(film_of(page_of(run, moving(), 1000))["frames"]) == 41
    assert len(film_of(page_of(run, moving(), 10))["frames"]) == 10

    assert "the page stays small" not in page_of(run, moving(), 10).read_text()
    monkeypatch.setattr(drawn_film, "_MOST_PLACES", 60)
    assert "there are 30 frames only" in page_of(run, moving(), 1000).read_text()
    assert len(film_of(page_of(run, moving(), 1000))["frames"]) == 30
    monkeypatch.setattr(drawn_film, "_MOST_PLACES", 24)
    film = film_of(page_of(run, moving(), 1000))
    assert len(film["frames"]) == 24
    assert places(film).shape[1] == 1
    assert "2 particles (1 of them are drawn)" in page_of(run, moving()).read_text()


def test_a_run_whose_particles_have_all_gone_is_shown(tmp_path: Path) -> None:
    run = made_up(tmp_path, moving())
    path = tmp_path / FILM
    first, *later = path.read_text().split("ITEM: TIMESTEP\n")[1:]
    gone = [f"{one.split(chr(10))[0]}\nITEM: NUMBER OF ATOMS\n0\n" for one in later]
    header = (
        "ITEM: BOX BOUNDS ff ff ff\n" + "-1 1\n" * 3 + "ITEM: ATOMS id type x y z radius mass\n"
    )
    texts = [first, *(one + header for one in gone)]
    path.write_text("".join(f"ITEM: TIMESTEP\n{one}" for one in texts))
    found = places(film_of(page_of(run, moving())))
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1:]).all()


def test_places_far_below_the_walls_are_kept(tmp_path: Path) -> None:
    run = made_up(tmp_path, moving())
    path = tmp_path / FILM
    text = path.read_text()
    last = text.rpartition("2 1 0.02 0.03 ")
    path.write_text(f"{last[0]}{last[1]}-0.11 0.005 0.001\n")
    found = places(film_of(page_of(run, moving())))
    assert found[-1, 1, 2] - found[0, 1, 2] == pytest.approx(-0.16, abs=1e-4)


def test_particles_that_an_instability_has_thrown_are_left_out(tmp_path: Path) -> None:
    run = made_up(tmp_path, moving())
    path = tmp_path / FILM
    text = path.read_text().split("ITEM: TIMESTEP\n")
    text[-1] = text[-1].replace("0.02 0.03", "nan 0.03")
    text[-2] = text[-2].replace("0.02 0.03", "1e30 -inf")
    path.write_text("ITEM: TIMESTEP\n".join(text))
    found = places(film_of(page_of(run, moving())))
    assert np.isnan(found[-2:, 1]).all()
    assert np.isfinite(found[:-2]).all()
    assert np.isfinite(found[:, 0]).all()
