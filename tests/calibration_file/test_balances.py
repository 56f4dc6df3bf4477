"""Targets that are measured on the records of a balance."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.calibration_file import messages
from grainfit.calibration_file.build import CalibrationSetup
from grainfit.table_files import messages as of_tables
from tests.beads_file import BEADS

HOPPER = f'{BEADS}[[test]]\ntype = "hopper"\nsolver = "lammps"\n'


def record(
    flow: float = 0.5, opened: float = 2.0, total: float = 3.0, *, hanging: bool = False
) -> str:
    """A record of a balance, g: nothing, a steady flow, and the end."""
    time = np.arange(0.0, 12.0, 0.05)
    mass = np.clip(flow * (time - opened), 0.0, total)
    mass = 5.2 - mass if hanging else mass
    mass = mass + 0.0003 * np.random.default_rng(7).normal(size=len(mass))
    rows = [f"{t:.2f};{1000 * m:.1f}".replace(".", ",") for t, m in zip(time, mass, strict=True)]
    return "time [s];mass [g]\n" + "\n".join(rows) + "\n"


Load = Callable[..., CalibrationSetup]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    def loaded(targets: str, *records: str) -> CalibrationSetup:
        for number, text in enumerate(records, 1):
            (tmp_path / f"run_{number}.csv").write_text(text)
        (tmp_path / "beads.toml").write_text(HOPPER + targets)
        return gf.load(tmp_path / "beads.toml")

    return loaded


FLOW = 'targets.mass_flow = { balance = "run_1.csv" }\n'


@pytest.mark.parametrize("hanging", [False, True])
def test_a_flow_is_that_of_the_record(load: Load, hanging: bool) -> None:
    target = load(FLOW, record(hanging=hanging)).problem.targets[0]

    assert target.value == pytest.approx(0.5, rel=0.005)
    assert 0 < target.standard_uncertainty < 0.01


def test_repeats_tell_the_uncertainty(load: Load) -> None:
    files = '["run_1.csv", "run_2.csv", "run_3.csv"]'
    setup = load(
        f'targets.mass_flow = {{ balance = {files}, systematic = "1 %" }}\n',
        *(record(flow) for flow in (0.48, 0.50, 0.52)),
    )
    by_hand = gf.Target.of_measurements("mass_flow", [0.48, 0.50, 0.52], systematic="1 %")

    assert setup.problem.targets[0].value == pytest.approx(0.5, rel=0.005)
    assert setup.problem.targets[0].uncertainty == pytest.approx(by_hand.uncertainty, rel=0.05)
    assert any("run_2.csv: mass flow 0.5" in line for line in setup.file.tables)


def test_the_time_begins_when_the_outlet_is_opened(load: Load) -> None:
    setup = load(
        'targets.discharge_time = { balance = ["run_1.csv", "run_2.csv"] }\n'
        'targets.discharged_mass = { balance = ["run_1.csv", "run_2.csv"] }\n',
        record(opened=2.0),
        record(flow=0.505, opened=3.5),
    )
    # 99 % of 3 kg at 0.5 kg/s.
    assert setup.problem.targets[0].value == pytest.approx(5.94, rel=0.01)
    curve = setup.problem.curves[0]
    at = np.interp(3.0, curve.coordinates, curve.values)
    assert at == pytest.approx(1.5, rel=0.02)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (record().replace("[g]", ""), of_tables.NO_UNIT),
        (record(total=9.0), messages.NO_END),
        (record() + record().partition("\n")[2].replace("\n", "\n9", 200), None),
        (record(total=0.0), messages.NO_DISCHARGE),
    ],
)
def test_a_bad_record_is_named_with_what_to_do(load: Load, text: str, said: object) -> None:
    with pytest.raises(gf.InputError) as error:
        load(FLOW, text)

    assert "line 25, test 1, targets.mass_flow.balance[0]: " in str(error.value)
    assert "run_1.csv" in str(error.value)
    if said is not None:
        assert said.is_in(str(error.value))  # type: ignore[attr-defined]


def test_a_curve_of_one_record_has_no_uncertainty(load: Load) -> None:
    with pytest.raises(gf.InputError) as error:
        load('targets.discharged_mass = { balance = "run_1.csv" }\n', record())
    assert messages.ONE_RECORD.is_in(str(error.value))


@pytest.mark.parametrize("begun", [1.0, 1.01])
def test_a_record_without_scatter_is_read_wherever_its_flow_begins(
    load: Load, begun: float
) -> None:
    """Also where the outlet is opened just when a line is written."""
    rows = [f"{t:.2f};{min(max(t - begun, 0) * 10, 20):.4f}" for t in np.arange(0.0, 5.0, 0.02)]
    table = "t [s];m [g]\n" + "\n".join(rows) + "\n"

    [target] = load(
        'targets.mass_flow = { balance = "run_1.csv", tolerance = "3 %" }\n', table
    ).problem.targets

    assert target.value == pytest.approx(0.01, rel=1e-3)
    assert target.uncertainty > 0
