"""The study of published materials: its table is that of kept results, which were registered."""

from __future__ import annotations

import pytest

from grainfit.calibration_file.build import build_calibration
from grainfit.calibration_file.load import load_calibration_file
from grainfit.result import Result
from studies.real_materials.page import KEPT, MATERIALS, PAGE, ROOT, page


def result(name: str) -> Result:
    return Result.from_json(KEPT / name / "result.json")


def test_the_table_of_the_page_is_that_of_the_results() -> None:
    words = "Run: python -m studies.real_materials"
    assert PAGE.read_text(encoding="utf-8") == page(), words


@pytest.mark.parametrize("name", MATERIALS)
def test_a_kept_result_has_the_measured_values_of_its_example(name: str) -> None:
    example = ROOT / "examples" / name / "calibration.toml"
    setup = build_calibration(load_calibration_file(example))
    kept = result(name)
    fitted = {name: found.target for name, found in kept.responses.items()}
    assert fitted == {target.name: target.value for target in setup.problem.targets}
    assert {
        (one.test, response): found.measured
        for one in kept.holdouts
        for response, found in one.responses.items()
    } == {(one.name, target.name): target.value for one in setup.holdouts for target in one.targets}


@pytest.mark.parametrize("name", MATERIALS)
def test_what_was_held_out_was_registered_before_the_first_run(name: str) -> None:
    for one in result(name).holdouts:
        assert one.registration is not None
        assert one.registration.runs == 0
        assert not one.registration.changed
        assert all(found.verdict for found in one.responses.values())
