"""The page's own calculations give the same numbers as Python."""

from __future__ import annotations

import shlex

import contexts
import numpy as np
import pytest
from scipy.special import stdtr
from scipy.stats import qmc

import needs
from grainfit.formatting import number, rounded
from grainfit.materials.time_step import RayleighTimeStep
from grainfit.metamodels.kriging import Kriging
from grainfit.metamodels.metamodels import Metamodels
from grainfit.report.sections.answer.section import seconds
from grainfit.report.sections.explorer.section import time_step_data

pytestmark = needs.NODE

PREDICT = """
    const model = grainfitKriging.prepare(data.model);
    return data.points.map((point) => grainfitKriging.predict(model, point));
"""


def runs(n: int, d: int, noise: float) -> tuple[np.ndarray, np.ndarray]:
    points = qmc.LatinHypercube(d, rng=n).random(n)
    values = 1500.0 + 200.0 * np.sin(3.0 * points[:, 0]) * (1.0 + points[:, -1])
    return points, values + noise * np.random.default_rng(n).standard_normal(n)


def model_of(name: str) -> Kriging:
    if name == "few runs":
        return Kriging.fit(*runs(4, 2, 10.0))
    if name == "all equal":
        points, values = runs(12, 2, 0.0)
        return Kriging.fit(points, np.full_like(values, 7.0))
    if name == "repeated":
        points, values = runs(10, 2, 0.0)
        scatter = np.random.default_rng(1).normal(0.0, 20.0, 30)
        return Kriging.fit(np.repeat(points, 3, axis=0), np.repeat(values, 3) + scatter)
    if name == "known noise":
        points, values = runs(20, 2, 10.0)
        return Kriging.fit(points, values, np.linspace(1.0, 100.0, 20))
    if name == "stated errors":
        points, values = runs(20, 2, 0.0)
        errors = np.tile([3.0, 60.0], 10)
        values = values + errors * np.random.default_rng(2).standard_normal(20)
        model = Kriging.fit(points, values, standard_errors=errors)
        assert model.to_plain()["noise_ratios"] is not None
        return model
    n, d, noise = {
        "one parameter": (12, 1, 10.0),
        "without noise": (30, 2, 0.0),
        "five parameters": (60, 5, 10.0),
        "fourteen parameters": (50, 14, 10.0),
    }[name]
    return Kriging.fit(*runs(n, d, noise))


@pytest.mark.parametrize(
    "name",
    [
        "one parameter",
        "few runs",
        "all equal",
        "repeated",
        "known noise",
        "stated errors",
        "without noise",
        "five parameters",
        "fourteen parameters",
    ],
)
def test_the_page_predicts_what_python_does(name: str) -> None:
    model = model_of(name)
    points = np.vstack([qmc.Sobol(model.d, rng=1).random(16), np.zeros(model.d), np.ones(model.d)])
    known = {"model": model.to_plain(factors=False), "points": points.tolist()}
    found = contexts.in_node(PREDICT, known, "kriging.js")
    expected = model.predict(points)
    means = np.array([one["mean"] for one in found])
    variances = np.array([one["variance"] for one in found])
    np.testing.assert_allclose(means, expected.mean, rtol=1e-6)
    np.testing.assert_allclose(variances, expected.variance_of_mean, rtol=1e-6)


def test_a_grid_is_what_its_points_are_one_by_one() -> None:
    model = model_of("five parameters")
    data = {
        "model": model.to_plain(factors=False),
        "point": [0.3, 0.6, 0.2, 0.9, 0.5],
        "across": [0.0, 0.31, 1.0],
        "up": [0.1, 0.8],
    }
    grid = contexts.in_node(
        """
        const model = grainfitKriging.prepare(data.model);
        const found = grainfitKriging.meanGrid(model, data.point, 3, data.across, 1, data.up);
        return Array.from(found);
        """,
        data,
        "kriging.js",
    )
    points = [[0.3, up, 0.2, across, 0.5] for up in (0.1, 0.8) for across in (0.0, 0.31, 1.0)]
    np.testing.assert_allclose(grid, model.predict(points).mean, rtol=1e-9)


def test_the_page_finds_the_probability_that_all_agree() -> None:
    wanted = contexts.problem(2, 2)
    metamodels = Metamodels.fit(wanted, contexts.evaluations(wanted, 20))
    points = qmc.Sobol(2, rng=2).random(64)
    data = {
        "models": [model.to_plain(factors=False) for model in metamodels.models],
        "targets": [[target.value, target.tolerance] for target in wanted.targets],
        "points": points.tolist(),
    }
    found = contexts.in_node(
        """
        const models = data.models.map(grainfitKriging.prepare);
        return data.points.map((point) => models.reduce((share, model, i) => {
            const [target, tolerance] = data.targets[i];
            const predicted = grainfitKriging.predict(model, point);
            return share * grainfitKriging.probability(model, predicted, target, tolerance);
        }, 1));
        """,
        data,
        "kriging.js",
    )
    expected = metamodels.probability_all_met(points)
    assert expected.max() > 0.5
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("freedom", [1, 2, 5, 30, 400])
def test_the_distribution_of_student_is_right_far_into_its_tails(freedom: int) -> None:
    places = [-90.0, -7.5, -3.0, -0.1, 0.0, 0.1, 3.0, 7.5, 90.0]
    found = contexts.in_node(
        "return data.places.map((x) => grainfitKriging.student(x, data.freedom));",
        {"places": places, "freedom": freedom},
        "kriging.js",
    )
    np.testing.assert_allclose(found, stdtr(freedom, places), rtol=1e-9, atol=1e-14)


def test_numbers_are_written_as_in_the_rest_of_the_page() -> None:
    values = [
        0.0,
        1.0,
        -0.6,
        0.00012345,
        9.9996e-5,
        12345.6,
        9999.6,
        123456.0,
        1e20,
        -3.6e-9,
        2309.4312,
    ]
    uncertainties = [31.0, 0.045, 0.0, 1e-9, 250.0]
    times = [2.0, 0.0020543, 4.2e-5, 3e-8]
    found = contexts.in_node(
        """
        const { text, rounded, seconds } = grainfitQuantities;
        return [
            data.values.map((value) => text(value)),
            data.values.flatMap((value) => data.uncertainties.map((u) => rounded(value, u))),
            data.times.map(seconds),
        ];
        """,
        {"values": values, "uncertainties": uncertainties, "times": times},
        "quantities.js",
    )
    assert found[0] == [number(value) for value in values]
    assert found[1] == [rounded(value, u) for value in values for u in uncertainties]
    assert found[2] == [seconds(time) for time in times]


def test_intervals_and_time_steps_are_those_of_the_problem() -> None:
    wanted = contexts.problem(3, 1)
    point = [0.25, 0.5, 1.0]
    assert wanted.rayleigh is not None
    parameters = [
        {"name": p.name, "minimum": p.minimum, "maximum": p.maximum, "scale": p.scale}
        for p in wanted.parameters
    ]
    rayleigh = time_step_data(wanted.rayleigh)
    values, back, step = contexts.in_node(
        """
        const { fromUnit, toUnit, rayleigh } = grainfitQuantities;
        const values = data.parameters.map((p, j) => fromUnit(p, data.point[j]));
        const named = Object.fromEntries(data.parameters.map((p, j) => [p.name, values[j]]));
        const back = data.parameters.map((p, j) => toUnit(p, values[j]));
        return [named, back, rayleigh(data.rayleigh, named)];
        """,
        {"parameters": parameters, "point": point, "rayleigh": rayleigh},
        "quantities.js",
    )
    assert values == pytest.approx(wanted.from_unit(point))
    assert back == pytest.approx(point)
    assert step == pytest.approx(wanted.rayleigh_time_step(wanted.from_unit(point)))


def test_time_steps_of_a_free_aspect_ratio_are_those_of_the_problem() -> None:
    solid = {"particle.youngs_modulus": 1e6, "particle.poissons_ratio": 0.25}
    step = RayleighTimeStep(0.005, solid, "grain")
    ratios = [1.0, 1.02, 1.38, 1.7, 2.5, 3.0]
    points = [{"particle.density": 2500.0, "particle.aspect_ratio": ratio} for ratio in ratios]
    found = contexts.in_node(
        "return data.points.map((at) => grainfitQuantities.rayleigh(data.known, at));",
        {"known": time_step_data(step), "points": points},
        "quantities.js",
    )

    assert found == pytest.approx([step(point) for point in points], rel=1e-9)


def test_settings_survive_a_shell() -> None:
    values = {"particle.density": 2300.5, 'it\'s "wide" & $HOME': 1e-9}
    written = contexts.in_node(
        "return grainfitQuantities.settings(data.values);", {"values": values}, "quantities.js"
    )
    words = shlex.split(written)
    assert words[::2] == ["--set", "--set"]
    found = dict(word.split("=", 1) for word in words[1::2])
    assert {name: float(value) for name, value in found.items()} == values
