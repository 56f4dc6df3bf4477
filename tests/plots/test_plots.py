"""Figures of a saved calibration: complete, valid for Plotly, and the same data as the report."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest

import grainfit as gf
from grainfit.analysis.analysis import Analysis
from grainfit.errors import InputError
from grainfit.plots import convergence_figures, curve_traces, messages
from grainfit.plots.arrange import arrange, in_columns
from grainfit.plots.expected_course import Expectation
from grainfit.plots.figure import Figure
from grainfit.plots.posterior_figures import posterior_figures
from grainfit.report.page import render_page
from grainfit.report.section import ReportContext

NAMES = ("convergence", "pairs", "parallel", "pareto", "posterior", "predicted", "sensitivity")
NASTY = "<i>friction</i>"
PROBLEM = gf.Problem(
    [
        gf.Parameter("particle.density", 1400.0, 2800.0, unit="kg/m^3"),
        gf.Parameter(NASTY, 0.1, 0.9),
        gf.Parameter("particle.youngs_modulus", 1e5, 1e7, "log", "Pa"),
    ],
    [
        gf.Target("bulk_density", 1200.0, tolerance=12.0, unit="kg/m^3"),
        gf.Target("angle_of_repose", 30.0, tolerance=0.5, unit="deg"),
        gf.Target("<b>force</b>", 50.0, tolerance=2.0, unit="N"),
    ],
    gf.RayleighTimeStep(0.005, {"particle.poissons_ratio": 0.25}),
)


def simulate(parameters: dict[str, float], seed: int) -> dict[str, float]:
    scatter = ((seed * 7919) % 101 - 50) / 50
    stiffness = parameters["particle.youngs_modulus"]
    return {
        "bulk_density": 0.6 * parameters["particle.density"] + 3 * scatter,
        "angle_of_repose": 15 + 30 * parameters[NASTY] + 0.1 * scatter,
        "<b>force</b>": 10 * (stiffness / 1e5) ** 0.5 + 0.2 * scatter,
    }


@pytest.fixture(scope="session")
def saved(tmp_path_factory: pytest.TempPathFactory) -> gf.OpenedCalibration:
    folder = tmp_path_factory.mktemp("plots") / "work"
    gf.calibrate(PROBLEM, simulate, workdir=folder, name="<u>beads</u>", max_runs=25, seed=3)
    return gf.open(folder)


def texts(value: Any) -> list[str]:
    """All texts in a figure."""
    if isinstance(value, str):
        return [value]
    if isinstance(value, dict):
        return [text for item in value.values() for text in texts(item)]
    return [text for item in value for text in texts(item)] if isinstance(value, list) else []


@pytest.mark.parametrize("name", NAMES)
def test_a_figure_is_complete_and_escaped(saved: gf.OpenedCalibration, name: str) -> None:
    figure = getattr(gf.plots, name)(saved)

    assert isinstance(figure, go.Figure)
    plain = json.loads(figure.to_json())
    layout = plain["layout"]
    axes = [axis for key, axis in layout.items() if re.fullmatch(r"[xy]axis\d*", key)]
    assert all("domain" in axis or "overlaying" in axis for axis in axes)
    assert layout["title"]["text"].startswith("<b>")
    assert layout["height"] > 300
    titled = [axis["title"].get("text") for axis in axes if axis.get("visible", True)]
    assert any(titled)
    assert not any("<i>" in text or "<b>force" in text for text in texts(plain))


def test_an_answer_by_runs_of_others_alone_has_a_report(tmp_path: Path) -> None:
    stop = tmp_path / "stop"

    def height(parameters: dict[str, float], seed: int) -> dict[str, float]:
        if stop.exists():
            raise KeyboardInterrupt
        return {"height": 3 * parameters["friction"]}

    problem = gf.Problem([gf.Parameter("friction", 0.1, 0.9)], [gf.Target("height", 1.5)])
    gf.calibrate(problem, height, workdir=tmp_path, seed=1)
    stop.touch()
    found = gf.calibrate(problem, height, workdir=tmp_path, seed=2)
    assert (found.status, found.runs.total) == ("interrupted", 0)
    assert found.parameters

    opened = gf.open(tmp_path)
    assert "friction" in render_page(ReportContext(opened, opened.analyse()))


def test_figures_hold_the_data_of_the_page(saved: gf.OpenedCalibration) -> None:
    page = render_page(ReportContext(saved, saved.analyse()))
    pattern = r'<script type="application/json" id="figure-([^"]*)">(.*?)</script>'
    of_page = {key: json.loads(text) for key, text in re.findall(pattern, page, re.DOTALL)}

    for name, section in {
        "convergence": "convergence-",
        "pairs": "undetermined-pair-",
        "parallel": "runs-parallel",
        "pareto": "tradeoff-",
        "posterior": "undetermined-",
        "predicted": "predicted-",
        "sensitivity": "sensitivity-",
    }.items():
        shown = [
            trace
            for key, figure in of_page.items()
            if key.startswith(section) and ("-pair-" in key) == (name == "pairs")
            for trace in figure["data"]
        ]
        drawn = json.loads(getattr(gf.plots, name)(saved).to_json())["data"]
        assert len(drawn) == len(shown) > 0
        assert sorted(t["type"] for t in drawn) == sorted(t["type"] for t in shown)
        # The page has six digits of each number.
        expected = pytest.approx(sorted(map(_first_number, shown)), rel=1e-5)
        assert sorted(map(_first_number, drawn)) == expected


def test_a_density_is_drawn_where_it_is_and_a_line_stays_within_its_axes(
    saved: gf.OpenedCalibration,
) -> None:
    found = saved.analyse()
    assert found.posterior is not None
    density = posterior_figures(
        saved, found.posterior, found.identifiability, found.intervals
    ).marginals[0]
    heights = np.array(density.data[0]["y"])
    assert np.count_nonzero(heights > 0.01) > 15
    low, high = density.layout["xaxis"]["range"]
    interval = found.intervals["particle.density"]
    assert 1400 < low < interval.low < interval.high < high < 2800

    # A line that is far from every run.
    expected = [Expectation(runs, np.full(3, 1e4), np.ones(3)) for runs in (10, 20)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(convergence_figures, "expectations_at_answer", lambda _: expected)
        figures = convergence_figures.convergence_figures(saved)
    assert figures["0"].layout["yaxis"]["range"][1] > 1e4
    assert 10 ** figures["misfit"].layout["yaxis"]["range"][1] > (1e4 - 30.0) / 0.5


@pytest.mark.parametrize("count", [1, 2, 5, 20, 2_000])
def test_every_tick_is_a_run_of_its_own(saved: gf.OpenedCalibration, count: int) -> None:
    few = replace(saved, evaluations=(saved.evaluations * count)[:count])
    axis = convergence_figures.convergence_figures(few)["misfit"].layout["xaxis"]
    assert axis["dtick"] == int(axis["dtick"])
    assert 1 <= count / axis["dtick"] <= 8


def _first_number(trace: dict[str, Any]) -> float:
    """A number that tells traces apart."""
    if "z" in trace:
        return float(trace["z"][1][0])
    return round(float(trace["x"][0]), 3) if trace["x"] else 0.0


def test_the_analysis_is_made_once(
    saved: gf.OpenedCalibration, monkeypatch: pytest.MonkeyPatch
) -> None:
    fresh = gf.open(saved.folder)
    first = fresh.analyse()
    assert saved.result is not None
    answer = saved.result.parameters
    same = gf.analyse(saved.problem, saved.known, seed=3, answer=answer).posterior
    assert first.posterior is not None
    assert same is not None
    assert (first.posterior.values == same.values).all()
    monkeypatch.setattr("grainfit.analysis.analysis.analyse", None)

    assert fresh.analyse() is first
    gf.plots.sensitivity(fresh)
    intervals = {parameter.name: parameter.interval for parameter in fresh.card().parameters}
    assert intervals["particle.density"] == first.posterior.interval("particle.density")
    with pytest.raises(TypeError):
        replace(fresh, seed=2).analyse()


def test_an_analysis_that_is_given_is_drawn(saved: gf.OpenedCalibration) -> None:
    given = saved.analyse()
    assert given.sensitivity is not None
    one = replace(given, sensitivity=replace(given.sensitivity, responses=("bulk_density",)))

    assert len(gf.plots.sensitivity(saved, one).data) == 2


@pytest.mark.parametrize(
    "name", [name for name in NAMES if name not in ("convergence", "parallel")]
)
def test_a_figure_that_cannot_be_drawn_says_why(saved: gf.OpenedCalibration, name: str) -> None:
    with pytest.raises(
        InputError, match=re.escape(messages.NOTHING_TO_DRAW(reasons="There are 2 runs only."))
    ):
        getattr(gf.plots, name)(saved, Analysis(notes=("There are 2 runs only.",)))


def test_no_convergence_without_a_run_and_no_posterior_where_nothing_agrees(
    saved: gf.OpenedCalibration,
) -> None:
    without = replace(saved, problem=replace(PROBLEM, rayleigh=None))
    with pytest.raises(InputError, match=messages.NO_RUN()):
        gf.plots.convergence(replace(saved, evaluations=()))
    with pytest.raises(InputError, match="No parameter set within the intervals agrees"):
        gf.plots.posterior(replace(saved, state="unreachable"))
    with pytest.raises(InputError, match="No Rayleigh time step"):
        gf.plots.pareto(without, replace(saved.analyse(), pareto=None))


def test_arranged_figures_keep_their_places_and_do_not_overlap() -> None:
    def figure(height: int, **layout: Any) -> Figure:
        trace = {"type": "scatter", "x": [1], "y": [2], "name": "a"}
        return Figure((trace, trace), layout, "", height, title="title")

    shape = {"type": "line", "x0": 1, "x1": 1, "yref": "paper", "y0": 0, "y1": 1}
    rows = [*in_columns([figure(200), figure(200), figure(200)], 2), [figure(300, shapes=[shape])]]
    drawn = arrange(rows, "heading").to_dict()["layout"]

    x = [drawn[f"xaxis{n}"]["domain"] for n in ("", 2, 3, 4)]
    y = [drawn[f"yaxis{n}"]["domain"] for n in ("", 2, 3, 4)]
    assert x[0] == x[2] == [0.0, pytest.approx(0.435)]
    assert x[1] == pytest.approx([0.565, 1.0])
    assert x[3] == [0.0, 1.0]
    assert y[0] == y[1]
    assert y[0][0] > y[2][1] > y[2][0] > y[3][1] > y[3][0] > 0
    (moved,) = drawn["shapes"]
    assert (moved["xref"], moved["yref"]) == ("x4", "y4 domain")
    legends = [drawn[f"legend{n}"]["y"] for n in ("", 2, 3, 4)]
    assert legends == [domain[1] for domain in y]
    pixels = (y[3][1] - y[3][0]) * drawn["height"]
    assert 200 < pixels < 300


def test_figures_side_by_side_share_a_legend() -> None:
    def figure(*names: str) -> Figure:
        data = [{"type": "scatter", "x": [1], "y": [2], "name": name} for name in names]
        hidden = {"type": "scatter", "x": [], "y": [], "name": "outside", "showlegend": False}
        return Figure((*data, hidden), {}, "")

    drawn = arrange([[figure("inside"), figure("inside", "outside")]], "", one_legend=True)
    assert {trace.legend for trace in drawn.data} == {"legend"}
    assert [trace.showlegend for trace in drawn.data] == [True, False, False, True, False]
    assert [trace.legendgroup for trace in drawn.data] == [trace.name for trace in drawn.data]


def test_names_of_the_room() -> None:
    assert set(NAMES) < set(dir(gf.plots))
    assert "plots" in dir(gf)
    with pytest.raises(AttributeError, match="no attribute 'pie'"):
        gf.plots.pie  # noqa: B018


@pytest.mark.parametrize(
    ("unit", "places", "step"),
    [("", (0, 1, 3), 1), ("", (0, 0.5, 1), None), ("s", (0, 1, 3), None)],
)
def test_an_axis_that_counts_has_whole_ticks(
    unit: str, places: tuple[float, ...], step: int | None
) -> None:
    assert curve_traces.coordinate_axis("taps", unit, places).get("dtick") == step
