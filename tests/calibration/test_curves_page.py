"""The Python of docs/curves.md runs as it stands."""

from __future__ import annotations

from pages import names_after


def test_the_example_of_the_page_calibrates_on_its_curve() -> None:
    names = names_after("curves.md")
    result = names["result"]

    assert result.status == "calibrated"
    # The points were made with 2.4e5 Pa and 0.6, and rounded with errors of about 1 %.
    low, high = result.intervals["modulus"].low, result.intervals["modulus"].high
    assert low < 2.4e5 < high
    assert high - low < 4e4
