"""Curves that were measured several times: their errors, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from grainfit.errors import InputError
from grainfit.problem import CurveTarget, messages

PLACES = np.linspace(0.01, 0.2, 20)
TRUE = 1000 * PLACES * (1 + 3 * PLACES)


def repeats(
    count: int, common: float, independent: float, generator: np.random.Generator
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Curves that scatter as a whole, and from point to point, by shares of the largest value."""
    size = TRUE.max()
    return [
        (
            PLACES,
            TRUE
            + size * common * generator.normal()
            + size * independent * generator.normal(size=len(PLACES)),
        )
        for _ in range(count)
    ]


@pytest.mark.parametrize("count", [3, 6])
@pytest.mark.parametrize(("common", "independent"), [(0.03, 0.01), (0.0, 0.02), (0.05, 0.002)])
def test_interval_of_the_height_of_a_curve_holds(
    count: int, common: float, independent: float
) -> None:
    generator = np.random.default_rng(7)
    covered, drawn = 0, 400
    for _ in range(drawn):
        curve = CurveTarget.of_measurements(
            "stress", repeats(count, common, independent, generator)
        )
        covariance = curve.covariance_about(curve.values)
        height = np.mean(np.asarray(curve.values) - TRUE)
        covered += abs(height) <= 1.96 * np.sqrt(covariance.mean())
    # 95 % +- 3 binomial standard errors; a share cut off at 0 makes intervals wider, not narrower.
    assert covered / drawn > 0.95 - 3 * np.sqrt(0.95 * 0.05 / drawn)


def test_curves_that_differ_as_a_whole_are_not_many_measurements() -> None:
    shifted = [(PLACES, TRUE + 20 * number) for number in (-1, 0, 1)]

    curve = CurveTarget.of_measurements("stress", shifted)

    one = 2.195 * 20 / np.sqrt(3)  # Student's factor for three: 4.303 / 1.96
    assert curve.standard_uncertainties == pytest.approx(one, rel=1e-3)
    assert np.sqrt(curve.covariance_about(TRUE).mean()) == pytest.approx(one, rel=0.01)


def test_systematic_part_of_repeated_curves_adds_to_the_common_one() -> None:
    drawn = repeats(4, 0.0, 0.001, np.random.default_rng(1))

    curve = CurveTarget.of_measurements("stress", drawn, systematic="10 %", tolerance="2 %")

    assert np.asarray(curve.systematic) == pytest.approx(0.1 * TRUE, rel=0.2)
    assert curve.tolerances[0] == pytest.approx(0.02 * 0.1 * max(curve.values))


@pytest.mark.parametrize(
    ("curves", "words"),
    [
        ([(PLACES, TRUE)], "fewer than two curves"),
        (None, "fewer than two curves"),
        ([(PLACES, TRUE), (PLACES, TRUE)], "are all the same"),
        ([(PLACES, TRUE), (PLACES[-1] + PLACES - 0.01, TRUE)], "fewer than two points"),
        ([(PLACES, TRUE), (PLACES[::-1], TRUE)], "no curve"),
        ([(PLACES, TRUE), (PLACES, TRUE[:3])], "no curve"),
        ([(PLACES, TRUE), "ab"], "no curve"),
        ([(PLACES, TRUE), 3.0], "no curve"),
    ],
)
def test_repeats_that_are_none_are_refused(curves: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        CurveTarget.of_measurements("stress", curves)  # type: ignore[arg-type]


def test_curves_that_do_not_overlap_are_named_with_their_ranges() -> None:
    presses = [([2600.0, 3000.0], [2.1, 3.6]), ([500.0, 2000.0], [1.2, 2.5]), ([1e3, 9e3], [1, 9])]
    with pytest.raises(InputError) as caught:
        CurveTarget.of_measurements("strain", presses, coordinate_unit="Pa")

    expected: dict[str, object] = {"high": 1, "high_range": "2.6 kPa to 3 kPa", "low": 2}
    expected["low_range"] = "500 Pa to 2 kPa"
    assert messages.NO_OVERLAP.is_in(str(caught.value), **expected)
