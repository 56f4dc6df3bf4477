"""Series of a run, as measurement reads them."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.errors import NotMeasurableError
from grainfit.scenes.run_output import RunOutput


def test_series_has_every_time_once(tmp_path: Path) -> None:
    text = "time,inside\n0.1,5.0\n0.2,4.0\n0.2,4.0\n0.3,3.5\n"
    (tmp_path / "series_flow.csv").write_text(text)
    series = RunOutput(tmp_path).series("flow")

    assert series["time"].tolist() == [0.1, 0.2, 0.3]
    assert series["inside"].tolist() == [5.0, 4.0, 3.5]


def test_series_without_records_is_empty(tmp_path: Path) -> None:
    (tmp_path / "series_flow.csv").write_text("time,inside\n")

    assert len(RunOutput(tmp_path).series("flow")["time"]) == 0


def test_a_series_without_a_needed_column_is_refused(tmp_path: Path) -> None:
    (tmp_path / "series_flow.csv").write_text("time,outside\n0.1,5.0\n")
    run = RunOutput(tmp_path)

    assert set(run.series("flow", ["outside"])) == {"time", "outside"}
    with pytest.raises(NotMeasurableError, match=r"series_flow\.csv: has no column inside\."):
        run.series("flow", ["outside", "inside"])
