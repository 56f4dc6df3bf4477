"""Few points, which are predicted by all sets of hyperparameters at once, are as many are."""

from __future__ import annotations

import numpy as np
import pytest

from grainfit.metamodels.kriging import Kriging

MANY, FEW = 300, 20


@pytest.mark.parametrize(("runs", "dimension"), [(6, 1), (20, 2), (40, 4)])
def test_few_points_are_predicted_as_many(runs: int, dimension: int) -> None:
    random = np.random.default_rng(1)
    places = random.random((runs, dimension))
    responses = np.sin(3 * places[:, 0]) + places.sum(axis=1) + 0.05 * random.standard_normal(runs)
    fitted = Kriging.fit(places, responses)
    larger = fitted.embedded(list(range(1, dimension + 1)), np.insert(places, 0, 0.5, axis=1))
    for model in (fitted, fitted.condition(places[:2], responses[:2]), larger):
        points = random.random((MANY, model.d))
        parts = np.split(points, MANY // FEW)
        whole = model.predict(points)
        for name in ("mean", "variance_of_mean"):
            found = np.concatenate([getattr(model.predict(part), name) for part in parts])
            np.testing.assert_allclose(found, getattr(whole, name), rtol=1e-8, atol=1e-10)
        found = np.concatenate([model.mean(part) for part in parts])
        np.testing.assert_allclose(found, model.mean(points), rtol=1e-9)
        slopes = np.concatenate([model.gradients(part) for part in parts])
        np.testing.assert_allclose(slopes, model.gradients(points), rtol=1e-7, atol=1e-9)
