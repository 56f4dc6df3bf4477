"""Sections that use the metamodels: complete, with text, and small, for every calibration."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import contexts
import numpy as np
import pytest

from grainfit.analysis import messages as of_analysis
from grainfit.analysis.analysis import Analysis
from grainfit.analysis.pareto import ParetoFront
from grainfit.campaign.store.records import RunRecord
from grainfit.errors import InputError
from grainfit.metamodels import messages
from grainfit.metamodels.metamodels import Metamodels
from grainfit.plots.sensitivity_figures import sensitivity as sensitivity_plot
from grainfit.problem import Problem
from grainfit.report.rendering import script_json
from grainfit.report.section import ReportContext, Section
from grainfit.report.sections.explorer.section import explorer
from grainfit.report.sections.predicted.section import predicted
from grainfit.report.sections.sensitivity.section import sensitivity
from grainfit.report.sections.surfaces.section import surfaces
from grainfit.report.sections.tradeoff.section import tradeoff
from grainfit.report.sections.undetermined.section import undetermined
from grainfit.run_definition import RunDefinition

SECTIONS: tuple[Callable[[ReportContext], Section], ...] = (
    surfaces,
    explorer,
    predicted,
    sensitivity,
    tradeoff,
    undetermined,
)


@cache
def usual() -> ReportContext:
    wanted = contexts.problem(3, 2)
    return contexts.context(wanted, contexts.evaluations(wanted, 24))


def whole_text(section: Section) -> str:
    figures = {key: [f.data, f.layout, f.description] for key, f in section.figures.items()}
    return section.html + json.dumps(json.loads(script_json([figures, section.data])))


@pytest.mark.parametrize(
    ("parameters", "responses", "runs"), [(1, 1, 6), (2, 6, 20), (5, 2, 30), (14, 1, 32)]
)
def test_all_sections_are_whole_for_any_number_of_parameters_and_responses(
    parameters: int, responses: int, runs: int
) -> None:
    wanted = contexts.problem(parameters, responses)
    answered = parameters != 2
    made = contexts.context(wanted, contexts.evaluations(wanted, runs), answered=answered)
    # Correlations that are there already, and no answer; nothing else has gaps.
    gaps = {undetermined: sum(range(parameters - 1)), tradeoff: 0 if answered else 3}
    for make in SECTIONS:
        section = make(made)
        placed = re.findall(r'data-figure="([^"]+)"', section.html)
        assert sorted(placed) == sorted(section.figures)
        assert all(key.startswith(f"{section.key}-") for key in section.figures)
        assert not re.search(r"\b(nan|NaN|None|inf)\b", section.html)
        assert whole_text(section).count("null") == gaps.get(make, 0)


def test_too_few_runs_are_said_not_drawn() -> None:
    wanted = contexts.problem(2, 1)
    for runs in (0, 2):
        made = contexts.context(wanted, contexts.evaluations(wanted, runs), answered=False)
        (note,) = made.analysis.notes
        for make in SECTIONS:
            section = make(made)
            assert str(section.html.striptags()) == note
            assert (section.figures, section.data) == ({}, {})


def test_a_response_without_a_metamodel_is_named() -> None:
    wanted = contexts.problem(2, 2)
    known = contexts.evaluations(wanted, 20, failing=lambda n, name: n > 2 and name[-1] == "1")
    made = contexts.context(wanted, known)
    assert [r["name"] for r in explorer(made).data["responses"]] == ["response 0"]
    for make in (surfaces, explorer, undetermined):
        assert "Without <span>response 1</span>" in make(made).html


def test_names_are_text_wherever_they_are_shown() -> None:
    wanted = contexts.renamed(contexts.problem(3, 2))
    known = contexts.evaluations(wanted, 16)
    made = contexts.context(wanted, known)
    front = ParetoFront(
        np.array([1e-3]),
        np.array([0.1]),
        [dict(known[0].proposal.parameters)],
        np.array([0.9]),
        np.ones((1, 2)),
    )
    made = replace(made, analysis=replace(made.analysis, pareto=front))
    for make in SECTIONS:
        section = make(made)
        assert "<script>" not in section.html
        assert "&lt;script&gt;" in section.html or make is tradeoff
        for figure in section.figures.values():
            drawn = json.dumps([figure.data, figure.layout])
            assert "<script>" not in drawn
        # Plain names are data; what becomes HTML or a figure's text is named so.
        marked = list(_marked(section.data))
        assert bool(marked) == (make in (explorer, tradeoff))
        assert not any("<script>" in text for text in marked)


def _marked(data: Any) -> Iterator[str]:
    for key, value in data.items() if isinstance(data, Mapping) else enumerate(data):
        if key in ("plot", "plot_unit", "axis", "html"):
            yield value
        elif isinstance(value, Mapping | list):
            yield from _marked(value)


def test_the_data_of_150_runs_are_small() -> None:
    wanted = contexts.problem(5, 2)
    known = contexts.evaluations(wanted, 150)
    few = contexts.context(wanted, known[:20])
    assert few.analysis.metamodels is not None
    points = np.array([wanted.to_unit(e.proposal.parameters) for e in known[20:]])
    models = [
        model.condition(points, [e.responses[target.name].value for e in known[20:]])
        for model, target in zip(few.analysis.metamodels.models, wanted.targets, strict=True)
    ]
    analysis = replace(few.analysis, metamodels=Metamodels(wanted, models))
    made = ReportContext(contexts.reading(wanted, known, answered=True), analysis)
    sizes = [len(whole_text(make(made))) for make in SECTIONS]
    assert sum(sizes) < 300_000


# Surfaces and explorer ----------------------------------------------------------------------


def test_the_first_surface_is_over_the_parameters_that_matter_most() -> None:
    made = usual()
    found = made.analysis.sensitivity
    assert found is not None
    total = np.array([[0.1, 0.9, 0.7], [0.2, 0.1, 0.6]])
    analysis = replace(made.analysis, sensitivity=replace(found, total=total))
    html = surfaces(replace(made, analysis=analysis)).html
    assert re.search(r'data-across="(\d)" data-up="(\d)"', html).groups() == ("1", "2")
    chosen = re.findall(r'value="(\d)" selected', html)
    assert chosen == ["0", "1", "2"]


def test_surfaces_have_all_runs_that_gave_something_and_their_numbers() -> None:
    wanted = contexts.problem(2, 2)
    known = contexts.evaluations(
        wanted, 20, failing=lambda n, name: n == 3 or (n == 5 and name[-1] == "0")
    )
    runs = surfaces(contexts.context(wanted, known)).data["runs"]
    assert [run["name"] for run in runs] == [f"run {n}" for n in range(1, 21) if n != 3]
    fifth = runs[3]
    assert fifth["values"] == pytest.approx(list(known[4].proposal.parameters.values()), rel=1e-5)
    assert fifth["responses"][0] is None
    assert fifth["responses"][1] == pytest.approx(known[4].responses["response 1"].value, rel=1e-5)


def test_one_parameter_has_slices_but_no_surface() -> None:
    wanted = contexts.problem(1, 1)
    html = surfaces(contexts.context(wanted, contexts.evaluations(wanted, 8))).html
    assert "data-slice=" in html
    assert "data-surface " not in html
    assert "<select" not in html


def test_what_is_held_is_the_answer_or_the_middle() -> None:
    made = usual()
    answer = made.answer
    data = explorer(made).data
    assert {p["name"]: p["held"] for p in data["parameters"]} == answer
    assert "Back to the answer" in explorer(made).html
    before = ReportContext(replace(made.reading, result=None), made.analysis)
    middle = made.reading.problem.from_unit([0.5] * 3)
    assert {p["name"]: p["held"] for p in explorer(before).data["parameters"]} == middle
    assert "Back to the middle" in explorer(before).html


# Predicted against simulated ----------------------------------------------------------------


def test_every_run_is_drawn_where_leaving_it_out_puts_it() -> None:
    made = usual()
    assert made.analysis.metamodels is not None
    left_out = made.analysis.metamodels.models[1].leave_one_out()
    figure = predicted(made).figures["predicted-1"]
    drawn = {
        int(name.removeprefix("run ")): (x, y, half)
        for trace in figure.data[1:]
        for x, y, (name, half) in zip(trace["x"], trace["y"], trace["customdata"], strict=True)
    }
    runs = made.reading.evaluations
    assert sorted(drawn) == list(range(1, len(runs) + 1))
    for number, (x, y, half) in drawn.items():
        assert x == pytest.approx(runs[number - 1].responses["response 1"].value)
        assert y == pytest.approx(left_out.predicted[number - 1])
        assert half == pytest.approx(1.96 * left_out.standard_deviation[number - 1], rel=1e-3)
    assert f"Q²</abbr> = {left_out.q2:.2f}" in predicted(made).html
    inside = round(left_out.coverage * len(runs))
    assert f"{inside} of {len(runs)} runs are inside" in predicted(made).html


def test_warnings_of_a_poor_metamodel_are_repeated() -> None:
    wanted = contexts.problem(2, 1)
    known = contexts.evaluations(wanted, 12)
    flat = [
        replace(e, responses={"response 0": replace(e.responses["response 0"], value=9.0)})
        for e in known
    ]
    html = predicted(contexts.context(wanted, flat)).html
    assert "nothing to predict" in html
    assert messages.SAME_VALUE.is_in(html)


# Sensitivity, trade-off, what is not determined ---------------------------------------------


def test_the_most_important_parameter_is_drawn_at_the_top() -> None:
    made = usual()
    found = made.analysis.sensitivity
    assert found is not None
    figure = sensitivity(made).figures["sensitivity-1"]
    best = found.names[int(found.total[1].argmax())]
    assert figure.layout["yaxis"]["ticktext"][-1] == made.parameter_label(best).plot
    total = figure.data[1]
    assert total["x"][-1] == found.total[1].max()
    assert total["error_x"]["array"][-1] == pytest.approx(
        max(found.total_high[1].max() - found.total[1].max(), 0.0)
    )
    assert min(total["error_x"]["arrayminus"]) >= 0.0


def test_an_unknown_sensitivity_is_a_sentence_without_bars() -> None:
    made = usual()
    found = made.analysis.sensitivity
    assert found is not None
    wide = found.total_high.copy()
    wide[0] = found.total_low[0] + 0.51
    analysis = replace(made.analysis, sensitivity=replace(found, total_high=wide))
    section = sensitivity(replace(made, analysis=analysis))
    assert "sensitivity-0" not in section.figures
    assert 'data-figure="sensitivity-0"' not in section.html
    assert of_analysis.SENSITIVITY_NOT_KNOWN.is_in(section.html, response=found.responses[0])
    drawn = sensitivity_plot(made.reading, analysis)
    assert f"not known: {found.responses[0]}" in str(drawn.layout.annotations) + str(
        drawn.layout.title
    )
    all_wide = replace(found, total_low=np.zeros_like(wide), total_high=np.ones_like(wide))
    with pytest.raises(InputError, match=of_analysis.SENSITIVITY_NOT_KNOWN.pattern):
        sensitivity_plot(made.reading, replace(analysis, sensitivity=all_wide))


def test_a_trade_off_can_be_picked_point_by_point() -> None:
    made = usual()
    front = made.analysis.pareto
    assert front is not None
    section = tradeoff(made)
    points = section.data["points"]
    assert [p["time_step"] for p in points] == front.time_steps.tolist()
    assert [p["values"] for p in points] == front.parameters
    assert section.html.count("<option") == len(points)
    figure = section.figures["tradeoff-front"]
    assert figure.layout["xaxis"]["title"]["text"] == "Rayleigh time step (µs)"
    expected = made.reading.problem.rayleigh_time_step(made.answer)
    assert figure.data[1]["x"] == pytest.approx([1e6 * expected])


@pytest.mark.parametrize(
    ("probability_all_met", "picked"), [((0.99, 0.8, 0.6, 0.1), "2"), ((0.1, 0.4, 0.3, 0.0), "1")]
)
def test_the_first_pick_is_the_largest_time_step_that_probably_agrees(
    probability_all_met: tuple[float, ...], picked: str
) -> None:
    made = usual()
    values = dict(made.answer)
    front = ParetoFront(
        np.array([1e-5, 2e-5, 3e-5, 4e-5]),
        np.array([0.1, 0.2, 0.3, 9.0]),
        [values] * 4,
        np.array(probability_all_met),
        np.ones((4, 2)),
    )
    analysis = replace(made.analysis, pareto=front)
    html = tradeoff(ReportContext(made.reading, analysis)).html
    assert re.findall(r'value="(\d+)" selected', html) == [picked]


@pytest.mark.parametrize(
    ("gain", "probability_all_met", "words"),
    [
        (1.02, 0.97, "No, by 2 % at most"),
        (0.98, 0.97, "No, by 0 % at most"),
        (1.5, 0.97, "Yes, by about 50 %"),
        (1.5, 0.80, ""),
    ],
)
def test_whether_the_time_step_could_be_larger_is_answered_first(
    gain: float, probability_all_met: float, words: str
) -> None:
    made = usual()
    step = made.reading.problem.rayleigh_time_step(made.answer)
    assert step is not None
    front = ParetoFront(
        np.array([gain * step]),
        np.array([0.1]),
        [dict(made.answer)],
        np.array([probability_all_met]),
        np.ones((1, 2)),
    )
    html = tradeoff(ReportContext(made.reading, replace(made.analysis, pareto=front))).html
    if words:
        assert f"<p><strong>{words}" in html
    else:
        assert "<p><strong>" not in html


def without_time_step() -> Problem:
    return contexts.problem(1, 1, rayleigh=False)


def with_a_fixed_time_step() -> Problem:
    wanted = contexts.problem(4, 1)
    free = [p for p in wanted.parameters if not p.name.startswith("particle.")]
    fixed = {
        "particle.density": 2500.0,
        "particle.youngs_modulus": 1e6,
        "particle.poissons_ratio": 0.25,
    }
    assert wanted.rayleigh is not None
    return replace(wanted, parameters=free, rayleigh=replace(wanted.rayleigh, fixed=fixed))


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (without_time_step, "No Rayleigh time step is known"),
        (with_a_fixed_time_step, "Nothing that is free changes the Rayleigh time step"),
    ],
)
def test_where_there_is_nothing_to_trade_it_is_said(
    make: Callable[[], Problem], reason: str
) -> None:
    wanted = make()
    section = tradeoff(contexts.context(wanted, contexts.evaluations(wanted, 8)))
    assert reason in section.html
    assert section.figures == {}


def test_what_is_not_determined_is_said_before_it_is_drawn() -> None:
    made = usual()
    found, posterior = made.analysis.identifiability, made.analysis.posterior
    assert found is not None
    assert posterior is not None
    section = undetermined(made)
    html = section.html.unescape()
    # Parameters have one name on the page, that of its tables.
    assert any("particle.density" in verdict for verdict in found.verdicts)
    assert "particle.density" not in html
    assert "particle density of the solid" in html
    places = [html.index(made.in_words(verdict)) for verdict in found.verdicts]
    assert places == sorted(places)
    assert places[-1] < html.index("data-figure")
    for test in found.further_tests:
        assert made.in_words(test) in html
    assert posterior.convergence in html
    narrowed = section.figures["undetermined-narrowing"].data[0]
    assert narrowed["x"] == [1.0 - found.narrowing[name] for name in reversed(posterior.names)]


def test_a_calibration_with_bulk_tests_names_the_command_that_compares_others() -> None:
    made = usual()
    assert "grainfit advise" not in undetermined(made).html
    definition = RunDefinition({"solver": "lammps", "test": {"type": "heap"}}, {}, 1)
    record = RunRecord(definition.identity, "heap", "finished", definition)
    reading = replace(made.reading, folder=Path("my beads"), records={record.identity: record})
    html = undetermined(replace(made, reading=reading)).html.unescape()
    assert "grainfit advise 'my beads'" in html


def test_each_pair_of_parameters_is_correlated_once() -> None:
    made = usual()
    posterior = made.analysis.posterior
    assert posterior is not None
    figure = undetermined(made).figures["undetermined-correlations"]
    (heat,) = figure.data
    assert heat["z"][0] == [posterior.correlations[1, 0], None]
    assert heat["z"][1] == posterior.correlations[2, :2].tolist()
    assert len(figure.layout["annotations"]) == 3


def test_a_sample_that_has_not_converged_is_marked() -> None:
    made = usual()
    assert made.analysis.posterior is not None
    rough = replace(made.analysis.posterior, converged=False, convergence="Take it as rough.")
    analysis: Analysis = replace(made.analysis, posterior=rough, notes=("Take it as rough.",))
    html = undetermined(ReportContext(made.reading, analysis)).html
    assert "Not fully calculated:</span> Take it as rough." in html
    assert "Take it as rough" not in predicted(ReportContext(made.reading, analysis)).html


def test_marginals_are_drawn_where_they_are_on_the_scale_of_the_interval() -> None:
    figure = undetermined(usual()).figures["undetermined-marginal-1"]
    axis, trace = figure.layout["xaxis"], figure.data[0]
    assert axis["type"] == "log"
    low, high = axis["range"]
    assert 5.0 <= low < high <= 7.0
    assert np.log10([trace["x"][0], trace["x"][-1]]) == pytest.approx([low, high])
    assert np.diff(np.log10(trace["x"])) == pytest.approx((high - low) / (len(trace["x"]) - 1))
    assert max(trace["y"]) == 1.0
