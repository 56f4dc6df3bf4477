"""The shear cell: procedure, peaks of failure, validity, and how a tester's report is entered."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.bulk_tests.shear.flow import Record
from grainfit.bulk_tests.shear_cell import ShearCell, messages
from grainfit.bulk_tests.shear_cell.failure import Failure, frictions_with_errors
from grainfit.calibration.readiness import require_ready
from grainfit.errors import InputError, NotMeasurableError, RunFailedError
from grainfit.evaluation import Measured, curves, scalars
from grainfit.scenes.run_output import RunOutput
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.testing.materials import ROUGH_SPHERES


def small(**options: object) -> ShearCell:
    """Return a shear cell that runs in few seconds."""
    given = {"length": 0.07, "depth": 0.04, "gap": 0.07, "transient_strain": 0.5}
    procedure = {"points": 2, "cycles": 2, "preshear_strain": 0.3, "failure_strain": 0.2}
    return ShearCell(diameter=0.010, **{**given, **procedure, **options})


# --- procedure ---------------------------------------------------------------------------------


def test_every_point_has_a_preshear_and_its_load_from_the_highest_down():
    test = ShearCell(diameter=0.010, normal_stress="400 Pa", points=4, cycles=2)
    stages = test.scene(ROUGH_SPHERES, 3).stages
    assert [stage.name.rstrip("0123456789") for stage in stages] == [
        "close",
        "transient",
        *8 * ["preshear", "unload", "shear"],
    ]
    area = 0.14 * 0.07
    loads = [-stage.motions_of("upper")[-1].force / area for stage in stages]
    assert loads[2::3] == pytest.approx(8 * [400.0])
    falling = [300.0, 700 / 3, 500 / 3, 100.0]
    assert loads[3::3] == pytest.approx(2 * falling)
    assert loads[4::3] == pytest.approx(2 * falling)
    # The plate stands still along the shear while the load is reduced.
    assert all(len(stage.motions_of("upper")) == 1 for stage in stages[3::3])
    for first, strain in ((2, 0.5), (4, 0.25)):
        sheared = stages[first::3]
        ways = [stage.until.time * stage.motions_of("upper")[0].speed for stage in sheared]
        assert ways == pytest.approx(8 * [strain * 0.08])


@pytest.mark.parametrize(
    ("options", "key", "message"),
    [
        ({"lowest_stress": "380 Pa"}, "lowest_stress", "380 Pa is not below"),
        ({"highest_stress": "480 Pa"}, "highest_stress", "480 Pa is more than 90% of"),
        ({"preshear_strain": 0.8}, "preshear_strain", "the plate moves by 0.064 m"),
        ({"failure_strain": 0.1}, "failure_strain", "0.1"),
        ({"cycles": 1}, "cycles", "1"),
    ],
)
def test_an_impossible_procedure_is_named_with_its_value_and_a_remedy(options, key, message):
    with pytest.raises(InputError) as caught:
        ShearCell(diameter=0.010, **options)
    (fault,) = caught.value.faults
    assert fault.key == key
    assert message in fault.message
    assert fault.remedy


# --- peaks -------------------------------------------------------------------------------------


def _record(frictions: np.ndarray, stress: float = 200.0, step: float = 0.005) -> Record:
    strains = step * np.arange(len(frictions))
    normal = np.full(len(frictions), stress)
    return Record(strains, 0.08 * strains, frictions * stress, normal)


def test_the_peak_is_the_largest_mean_over_a_strain_of_a_tenth():
    strains = 0.005 * np.arange(80)
    course = 0.4 + 0.2 * ((strains > 0.1) & (strains < 0.2))
    found = Failure.of([_record(course), _record(course)], 0.08)
    assert found.friction == pytest.approx(0.59, abs=0.011)
    assert found.middles[found.peak] == pytest.approx(0.15, abs=0.01)
    assert found.normal_stress == pytest.approx(200.0)
    # A spike of a fifth of that length is no peak of the material.
    spike = 0.4 + 0.2 * ((strains > 0.1) & (strains < 0.12))
    assert Failure.of([_record(spike)] * 2, 0.08).friction < 0.45


def test_the_error_of_a_peak_is_the_scatter_of_the_cycles_at_all_stresses():
    random, scatter, cycles = np.random.default_rng(5), 0.04, 3
    stated, values = [], []
    for _ in range(300):
        failures = [
            Failure.of(
                [
                    _record(0.5 * (1 + random.normal(0, scatter)) * np.ones(50))
                    for _ in range(cycles)
                ],
                0.08,
            )
            for _ in range(3)
        ]
        found = frictions_with_errors(failures)
        stated.append(found[0].standard_error)
        values.append(found[0].value)
    assert np.sqrt(np.mean(np.square(stated))) == pytest.approx(np.std(values), rel=0.12)


def test_a_record_that_is_too_short_is_refused():
    with pytest.raises(NotMeasurableError, match=messages.FEW_RECORDS.pattern):
        Failure.of([_record(np.ones(10))] * 2, 0.08)


# --- validity: a real run, and what was changed in it -------------------------------------------


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Measured]]:
    """Folder and responses of a small run without cohesion."""
    folder = tmp_path_factory.mktemp("cell")
    return folder, Lammps(small(), ROUGH_SPHERES).run({}, 4, Workspace(folder, 300.0))


@pytest.fixture
def changed(finished: tuple[Path, dict[str, Measured]], tmp_path: Path) -> Path:
    """Return a copy of the run, to be changed."""
    return Path(shutil.copytree(finished[0], tmp_path / "run"))


def _scale(folder: Path, files: str, factors: dict[str, float]) -> None:
    """Multiply columns of series."""
    for path in folder.glob(f"series_{files}.csv"):
        header, *rows = path.read_text().splitlines()
        names = header.split(",")
        table = np.array([[float(v) for v in row.split(",")] for row in rows])
        table *= [factors.get(name, 1.0) for name in names]
        lines = [",".join(map(repr, row)) for row in table.tolist()]
        path.write_text("\n".join([header, *lines]) + "\n")


def test_a_small_bed_flows_as_in_plane_shear_and_has_hardly_any_cohesion(finished):
    found = scalars(finished[1])
    assert found["phi_sf"].value == pytest.approx(23.5, abs=3)
    assert abs(found["cohesion"].value) < 0.1 * 500
    assert found["bulk_density"].value == pytest.approx(1240, rel=0.04)
    curve = curves(finished[1])["shear_stress"]
    assert curve.coordinates == pytest.approx((125.0, 375.0))
    assert curve.values == pytest.approx((60.0, 170.0), rel=0.25)


def test_stresses_count_those_of_the_plate_that_stands_still(finished, changed):
    _scale(changed, "*", {"normal_upper": 1.3, "shear_upper": 0.7})
    assert small().measure(RunOutput(changed)) == finished[1]


@pytest.mark.parametrize(
    ("files", "factors", "reason"),
    [
        ("preshear*", {"normal_lower": 1.05}, "normal stress was not held: 5"),
        ("shear[13]", {"normal_lower": 1.3}, "not held at failure: 4.* Pa instead of 375 Pa"),
        ("shear[24]", {"shear_lower": 4.0}, "no yield locus: .* does not rise"),
    ],
)
def test_a_run_that_means_nothing_fails_with_its_reason(changed, files, factors, reason):
    _scale(changed, files, factors)
    with pytest.raises(RunFailedError, match=reason):
        small().measure(RunOutput(changed))


# --- entering a report -------------------------------------------------------------------------

FILE = """
name = "powder"

[particle]
diameter = "10 mm"
density = "2100 kg/m^3"
youngs_modulus = "0.36 MPa"
poissons_ratio = 0.22

[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.3
density = "7700 kg/m^3"

[particle_particle]
restitution = 0.6
sliding_friction = {{ min = 0.2, max = 0.8 }}
rolling_friction = 0.2
rolling_damping = 0

[particle_wall]
restitution = 0.6
sliding_friction = 0.4
rolling_friction = 0.1
rolling_damping = 0

[[test]]
type = "shear_cell"
solver = "lammps"
targets.{targets}
"""


def _load(folder: Path, targets: str, last: str = "375,172") -> gf.CalibrationSetup:
    (folder / "locus.csv").write_text(f"sigma [Pa],tau [Pa]\n125,75\n250,125\n{last}\n")
    (folder / "cell.toml").write_text(FILE.format(targets=targets), encoding="utf-8")
    return gf.load(folder / "cell.toml")


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("internal_friction_angle", messages.ENTER_STEADY_ANGLE()),
        ("yield_locus", messages.ENTER_CURVE()),
        ("sigma_1", messages.ENTER_CONSOLIDATION()),
        ("fc", messages.ENTER_STRENGTH()),
    ],
)
def test_other_names_of_a_report_are_answered_with_the_response(name, remedy, tmp_path):
    with pytest.raises(InputError) as caught:
        _load(tmp_path, f"{name} = {{ value = 20, tolerance = 1 }}")
    assert remedy in {fault.remedy for fault in caught.value.faults}


def test_points_of_a_locus_are_a_target_as_the_tester_prints_them(tmp_path):
    targets = 'shear_stress = { curve = "locus.csv", uncertainty = "3 %" }'
    setup = _load(tmp_path, targets)
    assert [curve.name for curve in setup.problem.curves] == ["shear_stress"]
    require_ready(setup.problem, setup.solvers)
    beyond = _load(tmp_path, targets, last="450,200")
    with pytest.raises(InputError, match="highest_stress"):
        require_ready(beyond.problem, beyond.solvers)
