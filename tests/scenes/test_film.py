"""Film of a run: what is read of its file, and where walls are meanwhile."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grainfit.errors import NotMeasurableError
from grainfit.scenes import messages
from grainfit.scenes.conditions import AtRest, Elapsed, Loaded
from grainfit.scenes.film import FILM, Film, filmed
from grainfit.scenes.records import Series, Travel
from grainfit.scenes.run_output import STAGES, STAGES_HEADER, RunOutput, series_file
from grainfit.scenes.scene import Load, Rotation, Scene, Stage, Velocity, Wall
from grainfit.scenes.shapes import Cylinder, Plane
from grainfit.scenes.wall_travels import stage_spans, wall_travels
from grainfit.testing.simulated_scenes import scene_of, spheres


def frame(step: int, rows: list[str], columns: str = "id type x y z radius mass") -> str:
    return (
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n"
        f"ITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\nITEM: ATOMS {columns}\n"
        + "".join(f"{row}\n" for row in rows)
    )


def bead(number: int, z: float, *more: str) -> str:
    return " ".join([f"{number} 1 0 0 {z} 0.005 1e-3", *more])


def test_frames_are_read_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    path = tmp_path / FILM
    columns = "id type x y z radius mass v_glued"
    path.write_text(
        frame(0, [bead(2, 0.2, "0"), bead(1, 0.1, "0"), bead(7, 0.0, "1")], columns)
        + frame(50, [bead(7, 0.01, "1"), bead(1, 0.05, "0")], columns)
        + frame(100, [], columns)
    )
    film = Film(path)
    assert film.steps.tolist() == [0, 50, 100]
    first, second, empty = film.read([0, 1, 2])
    assert first.numbers.tolist() == [1, 2, 7]
    assert first.positions[:, 2].tolist() == [0.1, 0.2, 0.0]
    assert first.glued.tolist() == [0, 0, 1]
    assert (second.step, second.numbers.tolist()) == (50, [1, 7])
    assert len(empty.numbers) == 0


@pytest.mark.parametrize("cut", [1, 10, 40, 100, 150])
def test_of_a_run_that_was_stopped_the_frames_before_are_left(tmp_path: Path, cut: int) -> None:
    path = tmp_path / FILM
    rows = [bead(1, 0.1), bead(2, 0.2)]
    path.write_text((frame(0, rows) + frame(50, rows) + frame(100, rows))[:-cut])
    assert Film(path).steps.tolist() == [0, 50]


def test_a_film_that_is_missing_or_damaged_is_said(tmp_path: Path) -> None:
    with pytest.raises(NotMeasurableError, match=messages.UNREADABLE.pattern):
        Film(tmp_path / FILM)
    (tmp_path / "empty").write_text("")
    with pytest.raises(NotMeasurableError, match=messages.UNREADABLE.pattern):
        Film(tmp_path / "empty")
    (tmp_path / "begun").write_text(frame(0, [bead(1, 0.1)])[:-5])
    with pytest.raises(NotMeasurableError, match=messages.NO_FRAME.pattern):
        Film(tmp_path / "begun")
    (tmp_path / "other").write_text(frame(0, ["1 1 a 0 0 0 0"]))
    with pytest.raises(NotMeasurableError, match=messages.BAD_FRAME.pattern):
        Film(tmp_path / "other").read([0])


def test_frames_are_spread_over_the_run(tmp_path: Path) -> None:
    path = tmp_path / FILM
    path.write_text("".join(frame(10 * n, [bead(1, 0.1)]) for n in range(100)))
    film = Film(path)
    assert film.spread(100) == film.spread(1000) == list(range(100))
    chosen = film.spread(30)
    assert (len(chosen), chosen[0], chosen[-1]) == (30, 0, 99)
    assert set(np.diff(chosen)) == {3, 4}
    assert film.spread(2) == [0, 99]


def lid() -> Wall:
    return Wall(Plane("z", 0.1, upwards=False))


def pressed(**more: object) -> Scene:
    """A lid that comes down, presses, and goes up; a drum that turns; a floor."""
    recorded = Series({"way": Travel("lid")}, 0.01)
    press = {"lid": Load("z", -1.0, 0.1, 1.0)}
    stages = (
        Stage("fill", AtRest(2.0)),
        Stage("close", Elapsed(0.5), put={"lid": lid()}, motions={"lid": Velocity("z", -0.1)}),
        Stage("press", Loaded("lid", 0.1, 1.0), motions=press, series=recorded),
        Stage("hold", Elapsed(0.1), motions=press),
        Stage("wait", Elapsed(0.1)),
        Stage("again", Loaded("lid", 0.1, 1.0), motions=press, series=recorded),
        Stage("open", Elapsed(1.0), take_away=("lid",), motions={"drum": Rotation("x", 2.0)}),
    )
    walls = {"floor": Wall(Plane("z", 0.0)), "drum": Wall(Cylinder(0.1, -1.0, 1.0, "x"))}
    return scene_of(spheres([(0, 0, 0.02)]), walls, stages, time_step=1e-3, **more)


def output(folder: Path, rows: list[tuple[str, str, float]], **series: list[tuple[float, float]]):
    lines = [f"{name},{end},{round(1000 * time)},{time},1,0.0" for name, end, time in rows]
    (folder / STAGES).write_text("\n".join([STAGES_HEADER, *lines]) + "\n")
    for name, table in series.items():
        text = "".join(f"{time},{way}\n" for time, way in table)
        (folder / series_file(name)).write_text("time,way\n" + text)
    return RunOutput(folder)


ENDS = [
    *(("fill", "at_rest", 0.4), ("close", "done", 0.9), ("press", "done", 1.4)),
    *(("hold", "done", 1.5), ("wait", "done", 1.6), ("again", "done", 2.0), ("open", "done", 3.0)),
]


def test_walls_are_where_motions_and_records_have_them(tmp_path: Path) -> None:
    run = output(
        tmp_path,
        ENDS,
        press=[(1.0, -0.06), (1.2, -0.07), (1.4, -0.08)],
        again=[(1.7, -0.085), (2.0, -0.09)],
    )
    times = np.array([0.0, 0.4, 0.65, 0.9, 0.95, 1.1, 1.4, 1.45, 1.55, 1.85, 2.0, 2.5, 3.0])
    found = wall_travels(pressed(), run, times)

    gone = np.nan
    # Before it is put, where its place was not recorded, and after it is taken away, it is not.
    expected = [gone, gone, -0.025, -0.05, -0.055, -0.065, -0.08, gone, gone, -0.0875, -0.09]
    np.testing.assert_allclose(found["lid"].travels, [*expected, gone, gone], atol=1e-12)
    assert found["lid"].unknown == ("hold", "wait")
    np.testing.assert_allclose(found["floor"].travels, 0.0)
    assert found["floor"].motion is None
    np.testing.assert_allclose(found["drum"].travels, [0.0] * 11 + [1.0, 2.0], atol=1e-12)
    assert found["drum"].motion == Rotation("x", 2.0)


@pytest.mark.parametrize(
    ("ends", "names", "last"),
    [
        (ENDS[:2], ["fill", "close", "press"], np.inf),
        ([("fill", "restless", 2.0)], ["fill"], 2.0),
        ([], ["fill"], np.inf),
        (ENDS, [stage.name for stage in pressed().stages], 3.0),
    ],
)
def test_stages_that_a_run_reached(tmp_path: Path, ends: list, names: list[str], last: float):
    spans = stage_spans(pressed(), output(tmp_path, ends).ends)
    assert [span.stage.name for span in spans] == names
    assert spans[-1].end == last
    assert [span.begin for span in spans[1:]] == [span.end for span in spans[:-1]]


def test_a_series_that_was_cut_off_leaves_its_wall_unknown(tmp_path: Path) -> None:
    run = output(tmp_path, ENDS[:2], press=[(1.0, -0.06), (1.2, -0.07)])
    whole = wall_travels(pressed(), run, np.array([1.1]))["lid"]
    assert whole.travels == pytest.approx([-0.065])
    path = tmp_path / series_file("press")
    path.write_text(path.read_text()[:-3])
    cut = wall_travels(pressed(), run, np.array([1.1]))["lid"]
    assert np.isnan(cut.travels).all()
    assert cut.unknown == ("press",)


def test_a_run_of_a_third_of_the_expected_time_has_enough_frames() -> None:
    film = filmed(pressed(), 60, duration=9.0)
    assert film.film_interval is not None
    assert 3.0 / film.film_interval == pytest.approx(60)
