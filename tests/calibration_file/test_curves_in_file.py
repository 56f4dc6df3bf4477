"""Measured curves in the calibration file: units, faults with their places, a calibration."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import grainfit as gf
from grainfit.bulk_tests import messages as of_bulk_tests
from grainfit.calibration.readiness import require_ready
from grainfit.calibration_file import messages as of_calibration_file
from grainfit.calibration_file.build import CalibrationSetup, load_calibration
from grainfit.calibration_file.checks import messages as of_checks
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.cli.console import print_plan
from grainfit.errors import InputError
from grainfit.messages import Message
from grainfit.options import messages as of_options
from grainfit.problem import CurveTarget
from grainfit.table_files import messages
from grainfit.work_folder import messages as of_work_folder
from grainfit.work_folder.analyse_runs import analyse_runs
from grainfit.work_folder.repeat_runs import repeat_runs
from grainfit.work_folder.stiffness_study import stiffness_study

MODEL = """
def simulate(parameters, seed):
    stiffness, noise = parameters["stiffness"], 1 + 0.002 * (seed % 7 - 3)
    strains = [i / 50 for i in range(11)]
    stresses = [1000 * stiffness * x * (1 + 3 * x) * noise for x in strains]
    return {"stress": {"coordinates": strains, "values": stresses}}
"""
HEAD = 'name = "piston"\n[parameters]\nstiffness = { min = 2, max = 20 }\n'
TEST = '[[test]]\nname = "press"\ntype = "python"\nfunction = "model.py:simulate"\n'
#: In SI units, with a stiffness of 10.
CURVE = "strain,stress\n0.05,575\n0.01,103\n0.1,1300\n0.15,2175\n"
TARGET = 'targets.stress = {{ curve = "curve.csv"{} }}\n'
#: Student's factors at 95 %, t / 1.96, for 4 and 9 measurements.
STUDENT_4, STUDENT_9 = 3.182446 / 1.96, 2.306004 / 1.96
ERRORS = ', uncertainty = "2 %", systematic = "1 %"'


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    def file(options: str = ERRORS, curve: str = CURVE, test: str = TEST, head: str = HEAD) -> Path:
        (tmp_path / "model.py").write_text(MODEL)
        (tmp_path / "curve.csv").write_text(curve)
        path = tmp_path / "piston.toml"
        path.write_text(head + test + TARGET.format(options))
        return path

    return file


@pytest.fixture
def curve_of(write: Callable[..., Path]) -> Callable[..., CurveTarget]:
    def read(*arguments: str, **given: str) -> CurveTarget:
        (test,) = load_calibration_file(write(*arguments, **given)).tests
        assert test.targets == ()
        (curve,) = test.curves
        return curve

    return read


@pytest.fixture
def fault_of(write: Callable[..., Path]) -> Callable[..., str]:
    def read(*arguments: str, **given: str) -> str:
        with pytest.raises(InputError) as caught:
            load_calibration_file(write(*arguments, **given))
        return "\n".join(map(str, caught.value.faults))

    return read


def test_curve_is_sorted_by_its_first_column(curve_of: Callable[..., CurveTarget]) -> None:
    curve = curve_of()
    assert (curve.name, curve.coordinate) == ("stress", "strain")
    assert curve.coordinates == (0.01, 0.05, 0.1, 0.15)
    assert curve.values == (103, 575, 1300, 2175)
    assert (curve.uncertainty, curve.systematic) == ("2 %", "1 %")


def test_curve_in_other_units_and_columns(curve_of: Callable[..., CurveTarget]) -> None:
    curve = curve_of(
        ', x = "strain", y = "load", x_unit = "%", y_unit = "kPa", uncertainty = "0.02 kPa"',
        "load,number,strain\n0.103,1,1\n0.575,2,5\n\n1.3,3,10\n",
    )
    assert curve.coordinates == (0.01, 0.05, 0.1)
    assert curve.values == (103, 575, 1300)
    assert curve.uncertainty == (20, 20, 20)
    assert (curve.unit, curve.coordinate_unit) == ("Pa", "")


@pytest.mark.parametrize(
    ("curve", "errors"),
    [
        ("x,y,sd,n\n1,2,0.3,9\n2,3,0.4,4\n", (0.1 * STUDENT_9, 0.2 * STUDENT_4)),
        ("x;y;std. error\n1;2;0,1\n2;3;0,2\n", (0.1, 0.2)),
        (
            "x,y,standard deviation,number of tests\n2,3,0.4,4\n1,2,0.3,9\n",
            (0.1 * STUDENT_9, 0.2 * STUDENT_4),
        ),
        ("x,y,sd\n1,2,0.3\n2,3,0.4\n", "uncertainty: is missing"),
        ("x,y,sd,n\n1,2,0.3,1\n2,3,0.4,4\n", "line 2, column n is 1. A deviation needs"),
        ("x,y,sd,n\n1,2,-1,4\n2,3,0.4,4\n", "line 2, column sd is -1"),
    ],
)
def test_columns_of_a_curve_tell_its_uncertainty(
    write: Callable[..., Path], curve: str, errors: tuple[float, ...] | str
) -> None:
    path = write("", curve)
    if isinstance(errors, str):
        with pytest.raises(InputError, match=errors):
            load_calibration_file(path)
        return
    (found,) = load_calibration_file(path).tests[0].curves
    assert found.uncertainty == pytest.approx(errors)


def test_spread_of_a_curve_has_the_unit_of_its_values(tmp_path: Path) -> None:
    path = tmp_path / "compression.toml"
    path.write_text(compression_file(TARGET.format("")))
    for header, sd in (
        ("strain [%],stress [kPa],sd,n", 0.1),
        ("strain / %,stress (kPa),sd [Pa],n", 100),
    ):
        (tmp_path / "curve.csv").write_text(f"{header}\n1,1,{sd},4\n2,2,{sd},4\n")
        (curve,) = load_calibration_file(path).tests[0].curves
        assert (curve.coordinates, curve.values) == ((0.01, 0.02), (1000, 2000))
        assert curve.uncertainty == pytest.approx((50 * STUDENT_4, 50 * STUDENT_4))


def test_plain_uncertainty_is_not_clear_where_the_heading_has_another_unit(tmp_path: Path) -> None:
    path = tmp_path / "compression.toml"
    path.write_text(compression_file(TARGET.format(", uncertainty = 0.02")))
    (tmp_path / "curve.csv").write_text("strain,stress [kPa]\n0.1,1\n0.2,2\n")
    with pytest.raises(
        InputError, match=of_calibration_file.UNIT_NOT_CLEAR.matching(value=0.02, unit="kPa")
    ):
        load_calibration_file(path)


def test_curve_of_a_model_in_its_own_unit(curve_of: Callable[..., CurveTarget]) -> None:
    own = ', unit = "kPa", y_unit = "Pa", coordinate_unit = "%", uncertainty = "20 Pa"'
    curve = curve_of(own)
    assert curve.values == (0.103, 0.575, 1.3, 2.175)
    assert curve.uncertainty == pytest.approx([0.02] * 4)
    assert (curve.unit, curve.coordinate_unit) == ("kPa", "%")


@pytest.mark.parametrize(
    ("header", "values", "unit"),
    [
        ("strain [%],stress [kPa]", (100, 1300), "Pa"),
        ("strain (%),stress / kPa", (100, 1300), "Pa"),
        ('"strain, %",stress in kPa', (100, 1300), "Pa"),
        ("strain,stress\n%,kPa", (100, 1300), "Pa"),
        ("strain [%],stress (mean)", (0.1, 1.3), ""),
        ("strain [%],stress [mean]", (0.1, 1.3), ""),
    ],
)
def test_headings_state_the_units_of_a_curve_of_an_own_model(
    curve_of: Callable[..., CurveTarget], header: str, values: tuple[float, ...], unit: str
) -> None:
    curve = curve_of(curve=f"{header}\n1,0.1\n10,1.3\n")
    assert curve.coordinates == (0.01, 0.1)
    assert (curve.values, curve.unit) == (values, unit)


def test_a_heading_is_converted_to_the_unit_of_the_own_model(
    curve_of: Callable[..., CurveTarget], fault_of: Callable[..., str]
) -> None:
    points = "strain [%],load [N],stress [Pa]\n1,7,100\n10,8,1300\n"
    own = ', y = "stress", unit = "kPa", coordinate_unit = "%"'
    curve = curve_of(f'{own}, uncertainty = "20 Pa"', points)
    assert (curve.coordinates, curve.values) == ((1, 10), (0.1, 1.3))
    assert curve.uncertainty == pytest.approx([0.02] * 2)
    assert '"3 Pa"' in fault_of(f"{own}, uncertainty = 3", points)


def test_covariance_follows_the_order_of_the_lines(
    curve_of: Callable[..., CurveTarget], tmp_path: Path
) -> None:
    (tmp_path / "covariance.csv").write_text("4,1,0\n1,9,2\n0,2,16\n")
    curve = curve_of(
        ', y_unit = "kPa", covariance = "covariance.csv"', "x,y\n0.2,2\n0.1,1\n0.3,3\n"
    )
    kilopascal_squared = np.array([[9, 1, 2], [1, 4, 0], [2, 0, 16]])
    assert np.array(curve.covariance) == pytest.approx(1e6 * kilopascal_squared)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (', x = "strian"' + ERRORS, ["line 1, column strian is missing", 'Is it "strain"?']),
        (', x = "stress"' + ERRORS, ["line 1, column stress", messages.BOTH_X_AND_Y()]),
        (', y_unit = "mm"' + ERRORS + ', unit = "Pa"', ["stress.y_unit", "Pa"]),
        (', y_unit = "widgets"' + ERRORS, ["stress.y_unit", "not a known unit"]),
        (', y_unit = "kPa", uncertainty = 0.02', ["stress.uncertainty", '"0.02 kPa"']),
        ("", ["stress.uncertainty", "is missing", "covariance"]),
        (', systematic = "1 %"', ["stress.uncertainty", "is missing"]),
        (', uncertainty = "-1 %"', ["stress.uncertainty", "above 0"]),
        (ERRORS + ', covariance = "curve.csv"', ["systematic", "beside covariance"]),
        (', covariance = "none.csv"', ["stress.covariance", "no such file"]),
        (', covariance = "curve.csv"', ["stress.covariance", "line 5 ends a table of 5 rows"]),
        (', common_uncertainty = "1 %"' + ERRORS, ["common_uncertainty", "systematic now"]),
        (ERRORS + ', tolerance = "0 %"', ["stress.tolerance", "above 0"]),
        (
            ERRORS + ', measurements = ["curve.csv", "curve.csv"]',
            ["stress.curve", "beside measurements"],
        ),
    ],
)
def test_fault_of_an_option_of_a_curve(
    fault_of: Callable[..., str], options: str, words: list[str]
) -> None:
    fault = fault_of(options)
    assert "line 8, test 1, targets.stress" in fault
    assert [word for word in words if word not in fault] == []


@pytest.mark.parametrize("key", ["tolerence", "covarianc", "uncertainity", "weight"])
def test_a_wrong_key_of_a_curve_is_one_fault(fault_of: Callable[..., str], key: str) -> None:
    fault = fault_of(f'{ERRORS}, {key} = "2 %"')
    assert re.search(rf"targets\.stress\.{key}: {of_options.UNKNOWN_KEY.pattern}", fault)
    assert "\n" not in fault


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        ("", ["curve.csv is empty"]),
        ("x,y\n", ["curve.csv, line 1 ends a table of 0 points", "2 to 400"]),
        ("x,y\n1,2\n", ["curve.csv, line 2 ends a table of 1 points"]),
        ("x,y\n" + "".join(f"{i},{i + 1}\n" for i in range(401)), ["of 401 points", "average"]),
        ("x,y\n1,2\n2,many\n", ["curve.csv, line 3, column y is 'many', not a number"]),
        ("x,y\n1,\n2,3\n", ["line 2, column y has no value"]),
        ("x,y\n1,2\n2\n", ["line 3, column y has no cell"]),
        ("x,y\n1,inf\n2,3\n", ["line 2, column y is inf"]),
        ("x,y\n1,1_000\n2,3\n", ["line 2, column y is '1_000'"]),
        ("x,y\n0,1,2\n0,3,4\n", ["line 2, column 3 is in a row of 3 cells", "decimal points"]),
        ("x|y\n1|2\n2|3\n", ["line 1 has one column, 'x|y'", "commas, semicolons, tabs"]),
        ("1,2\n2,3\n", ["line 1 has no names of columns"]),
        ("x,y\n1,2\n3,4\n1,5\n", ["line 4, column x is the same as in line 2, 1."]),
        ("x,y\n1,0\n2,5\n", ["stress.uncertainty", "line 2 of curve.csv is 0", "absolute"]),
        ('x,y\n"1,2\n', ["line 2 is not CSV"]),
        ("x,y,y\n1,2,3\n2,3,4\n", ["line 1, column y is there more than once", "Keep one"]),
        ("x,x\n1,2\n2,3\n", ["column x is there more than once"]),
        ("x,n,stress\n1,3,9\n2,3,9\n", ["column n has a number of measurements", 'y = "..."']),
    ],
)
def test_fault_of_the_points_of_a_curve(
    fault_of: Callable[..., str], curve: str, words: list[str]
) -> None:
    fault = fault_of(ERRORS, curve)
    assert "line 8, test 1, targets.stress" in fault
    assert [word for word in words if word not in fault] == []


def test_columns_of_one_name_that_are_no_points_are_left_alone(
    curve_of: Callable[..., CurveTarget],
) -> None:
    curve = curve_of(curve="x,y,note,note,,\n1,2,a,b,,\n2,3,a,b,,\n")
    assert curve.values == (2, 3)


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_curve_in_another_encoding_names_the_line(write: Callable[..., Path], mark: bytes) -> None:
    path = write()
    (path.parent / "curve.csv").write_bytes(mark + "x,y\n1,2\nü,3\n".encode("latin-1"))
    with pytest.raises(InputError, match=r"curve: curve\.csv, line 3 is not UTF-8 text\. Save"):
        load_calibration_file(path)


def test_curve_with_many_faults_names_the_first_ones(fault_of: Callable[..., str]) -> None:
    fault = fault_of(ERRORS, "x,y\n" + "1,many\n" * 50)
    assert fault.count("not a number") == 20
    assert "curve.csv has 30 more faults" in fault


def test_curve_without_a_file(fault_of: Callable[..., str]) -> None:
    test = TEST + 'targets.other = { curve = "none.csv", uncertainty = "2 %" }\n'
    fault = fault_of(test=test)
    assert "line 8, test 1, targets.other.curve" in fault
    assert "no such file" in fault


def test_large_file_of_a_curve_is_refused(write: Callable[..., Path], tmp_path: Path) -> None:
    path = write()
    with (tmp_path / "curve.csv").open("wb") as file:
        # Sparse: it takes no room on the disk.
        file.truncate(10**9)
    with pytest.raises(
        InputError, match=r"curve\.csv cannot be read: it has 1000 MB, and at most 10 MB"
    ):
        load_calibration_file(path)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("1,0\n2,1\n", "is not symmetric"),
        ("1,1\n1,1\n", "is not positive definite"),
        ("1,0\n0,x\n", "line 2, column 2 is 'x', not a number"),
        ("1,0\n0,nan\n", "line 2, column 2 is nan"),
        ("1,0\n0\n", "line 2, column 1 ends a row of 1 numbers"),
    ],
)
def test_fault_of_a_covariance(
    fault_of: Callable[..., str], tmp_path: Path, rows: str, words: str
) -> None:
    (tmp_path / "covariance.csv").write_text(rows)
    fault = fault_of(', covariance = "covariance.csv"', "x,y\n1,2\n2,3\n")
    assert "test 1, targets.stress.covariance" in fault
    assert words in fault


REPEATS = {
    "first.csv": "strain,stress\n0.05,500\n0.1,1000\n0.15,1500\n",
    "second.csv": "strain,stress\n0.04,420\n0.1,1050\n0.16,1600\n",
    "third.csv": "strain,stress\n0.0,1\n0.05,480\n0.1,970\n0.15,1490\n",
}
MEASURED = "targets.stress = {{ measurements = [{}]{} }}\n"
ALL_REPEATS = '"first.csv", "second.csv", "third.csv"'


@pytest.fixture
def write_repeats(tmp_path: Path) -> Callable[..., Path]:
    def file(options: str, files: str = ALL_REPEATS) -> Path:
        for name, text in REPEATS.items():
            (tmp_path / name).write_text(text)
        (tmp_path / "model.py").write_text(MODEL)
        path = tmp_path / "piston.toml"
        path.write_text(HEAD + TEST + MEASURED.format(files, options))
        return path

    return file


def test_curve_of_several_tables_has_mean_scatter_systematic_part_and_tolerance(
    write_repeats: Callable[..., Path],
) -> None:
    path = write_repeats(', systematic = "3 %", tolerance = "5 %"')

    (curve,) = load_calibration_file(path).tests[0].curves

    assert curve.coordinates == (0.05, 0.1, 0.15)
    assert curve.values == pytest.approx((501.667, 1006.667, 1499.444), rel=1e-5)
    assert curve.systematic[0] > 0.03 * 501
    assert curve.tolerances == pytest.approx([0.05 * value for value in curve.values])


@pytest.mark.parametrize(
    ("options", "files", "words"),
    [
        ("", '"first.csv"', "measurements: has 1 entry"),
        ("", '"first.csv", "first.csv"', "are fewer than two curves"),
        ("", '"first.csv", "fourth.csv"', "is 'fourth.csv', but there is no such file"),
        (', uncertainty = "2 %"', ALL_REPEATS, "uncertainty: is given beside measurements"),
        (', y_unit = "kPa", systematic = 0.1', ALL_REPEATS, "systematic: is 0.1"),
        ("", '"first.csv", 3', "measurements[1]"),
    ],
)
def test_fault_of_a_curve_of_several_tables(
    write_repeats: Callable[..., Path], options: str, files: str, words: str
) -> None:
    with pytest.raises(InputError) as caught:
        load_calibration_file(write_repeats(options, files))
    assert words in str(caught.value)


def test_recorded_table_has_no_curves(fault_of: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "runs.csv").write_text("stiffness,stress\n2,3\n")
    fault = fault_of(test='[[test]]\ntype = "table"\nfile = "runs.csv"\n')
    assert re.search(rf"targets\.stress: {of_calibration_file.CURVE_OF_TABLE.pattern}", fault)


def test_planned_file_has_no_curves(write: Callable[..., Path]) -> None:
    with pytest.raises(InputError, match=r"targets\.stress: is a curve"):
        load_calibration_file(write(), planned=True)


def test_measurements_of_a_planned_file_tell_value_and_accuracy(tmp_path: Path) -> None:
    repeats = (
        '{ measurements = ["1490 kg/m^3", "1500 kg/m^3", "1510 kg/m^3"], systematic = "5 kg/m^3" }'
    )
    path = tmp_path / "planned.toml"
    path.write_text(compression_file(f"targets.bulk_density = {repeats}\n"))

    (test,) = load_calibration_file(path, planned=True).tests

    planned = test.planned["bulk_density"]
    random = 4.302653 / 1.96 * 10 / np.sqrt(3)
    assert planned.value == pytest.approx(1500)
    assert planned.accuracy is not None
    assert planned.accuracy.of(1500) == pytest.approx(np.hypot(random, 5), rel=1e-6)


def test_curve_has_no_correlations(fault_of: Callable[..., str]) -> None:
    test = TEST + 'correlations = [["stress", "peak", 0.5]]\ntargets.peak = { value = 3 }\n'
    assert "correlations" in fault_of(test=test)


def compression_file(target: str) -> str:
    glass_beads = (
        Path(__file__).parents[2] / "examples" / "glass_beads" / "calibration.toml"
    ).read_text(encoding="utf-8")
    material = glass_beads[: glass_beads.index("[[test]]")].replace("0.36 MPa", "36 MPa")
    return f'{material}[[test]]\ntype = "compression"\nsolver = "lammps"\n{target}'


@pytest.mark.parametrize(
    ("units", "header", "faults"),
    [
        (', x_unit = "kPa"', "strain [%],stress [kPa]", ["does not belong here"]),
        (', x_unit = "%", y_unit = "kPa"', "strain (%),stress [kN/m^2]", []),
        (', y_unit = "kPa"', "strain [-],stress [Pa]", ["states 'Pa'"]),
        ("", "strain [mm],stress [mean of 3]", ["mm"]),
        ("", "strain,stress [-]", ["is said to have no unit, and is in Pa"]),
        ("", "strain,stress [Pa]", []),
    ],
)
def test_heading_with_a_unit_is_not_taken_for_another_one(
    tmp_path: Path, units: str, header: str, faults: list[str]
) -> None:
    (tmp_path / "curve.csv").write_text(f"{header}\n0.1,1\n0.2,2\n")
    path = tmp_path / "compression.toml"
    path.write_text(compression_file(TARGET.format(f'{units}, uncertainty = "2 %"')))
    if not faults:
        assert load_calibration_file(path).tests[0].curves
        return
    with pytest.raises(InputError) as caught:
        load_calibration_file(path)
    found = [str(fault) for fault in caught.value.faults]
    assert len(found) == len(faults)
    assert all(words in fault for words, fault in zip(faults, found, strict=True))


def test_curve_of_a_bulk_test_has_its_units(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text("strain,stress\n1,0.1\n2,0.4\n")
    target = TARGET.format(', x_unit = "%", y_unit = "kPa", uncertainty = "0.02 kPa"')
    path = tmp_path / "compression.toml"
    path.write_text(compression_file(target))
    problem = load_calibration(path).problem
    (curve,) = problem.curves
    assert problem.responses == ("stress",)
    assert (curve.unit, curve.coordinate, curve.coordinate_unit) == ("Pa", "strain", "")
    assert (curve.coordinates, curve.values) == ((0.01, 0.02), (100, 400))
    assert curve.uncertainty == (20, 20)


def test_curve_of_a_bulk_test_is_not_a_number(tmp_path: Path) -> None:
    path = tmp_path / "compression.toml"
    path.write_text(compression_file("targets.stress = { value = 3 }"))
    with pytest.raises(InputError, match=r"targets\.stress\.curve: is missing"):
        load_calibration_file(path)


def measured_between(folder: Path, test: str, curve: str, places: str) -> CalibrationSetup:
    """A calibration on a curve of two points at some coordinates."""
    first, last, unit = places.split()
    (folder / "curve.csv").write_text(f"x,y\n{first},0.1\n{last},0.2\n")
    target = (
        f'targets.{curve} = {{ curve = "curve.csv", x_unit = "{unit}", uncertainty = "2 %" }}\n'
    )
    path = folder / "measured.toml"
    path.write_text(compression_file(target).replace('"compression"', f'"{test}"'))
    return load_calibration(path)


@pytest.mark.parametrize(
    ("test", "curve", "places", "words"),
    [
        # By default the piston presses with 10 kPa, after seating with 500 Pa.
        (
            "compression",
            "strain",
            "0.4 4 kPa",
            'below 500 Pa. Set seating_stress = "400 Pa", leave',
        ),
        ("compression", "strain", "0 4 kPa", "below 500 Pa. Leave these points out, or correct"),
        ("compression", "strain", "-0.5 4 kPa", "below 500 Pa. Leave these points out, or"),
        ("compression", "strain", "1 12 kPa", 'above 10000 Pa. Set stress = "12000 Pa", leave'),
        ("compression", "strain", "4 5 Pa", 'below 500 Pa. Set seating_stress = "4 Pa", leave'),
        (
            "compression",
            "stress",
            "0 150 %",
            "from 0 to 1.5, and runs of this test have no values a",
        ),
        ("discharge", "discharged_mass", "-1 4 s", "below 0 s. Leave these points out, or correct"),
        ("heap", "profile", "-5 5 mm", "below 0 m. Leave these points out, or correct"),
        # Of 80 mm by default.
        ("drum", "surface", "-90 85 mm", "below -0.08 m and above 0.08 m. Set drum_radius = "),
        ("drum", "surface", "-90 85 mm", 'drum_radius = "0.09 m", leave'),
    ],
)
def test_curve_beyond_the_options_of_its_test_keeps_it_from_running(
    tmp_path: Path, test: str, curve: str, places: str, words: str
) -> None:
    setup = measured_between(tmp_path, test, curve, places)

    [problem] = describe_plan(setup).problems
    assert f"test {test}, {curve}: is measured from" in problem
    assert words in problem
    with pytest.raises(InputError) as caught:
        setup.calibrate(workdir=tmp_path / "work")
    assert str(caught.value) in problem


@pytest.mark.parametrize(
    ("test", "curve", "places"),
    [
        ("compression", "strain", "0.5 10 kPa"),
        ("compression", "stress", "0 5 %"),
        # What has left stays away, and beyond a heap there is none.
        ("discharge", "discharged_mass", "0 1000 s"),
        ("heap", "profile", "0 1000 mm"),
        ("drum", "surface", "-60 60 mm"),
    ],
)
def test_curve_that_the_options_of_its_test_reach_is_ready(
    tmp_path: Path, test: str, curve: str, places: str
) -> None:
    setup = measured_between(tmp_path, test, curve, places)

    assert describe_plan(setup).problems == ()


def file_with_curve(folder: Path, test: str, curve: str, values: str) -> Path:
    """A file with a curve of these values, in SI units, at the places 1, 2, ..."""
    rows = [f"{place},{value}\n" for place, value in enumerate(values.split(), 1)]
    (folder / "curve.csv").write_text("".join(["x,y\n", *rows]))
    target = f'targets.{curve} = {{ curve = "curve.csv", uncertainty = 0.01 }}\n'
    path = folder / "measured.toml"
    path.write_text(compression_file(target).replace('"compression"', f'"{test}"'))
    return path


@pytest.mark.parametrize(
    ("test", "curve", "values", "line", "message"),
    [
        # The mass that is left.
        ("discharge", "discharged_mass", "3 2 1 0", 5, of_bulk_tests.FALLS),
        ("hopper", "discharged_mass", "-3 1", 2, of_bulk_tests.TOO_LOW),
        ("compression", "strain", "0.4 0.8 1.2 1.3", 4, of_bulk_tests.TOO_HIGH),
        ("compression", "strain", "-0.01 -0.02", 2, of_bulk_tests.TOO_LOW),
        ("compression", "stress", "300 200", 3, of_bulk_tests.FALLS),
        ("shear_cell", "shear_stress", "300 -200", 3, of_bulk_tests.TOO_LOW),
        ("tapped", "compaction", "1500 1400", 3, of_bulk_tests.FALLS),
        ("triaxial", "deviatoric_stress", "0 -900", 3, of_bulk_tests.TOO_LOW),
        ("triaxial", "volumetric_strain", "0.5 1.2", 3, of_bulk_tests.TOO_HIGH),
        ("heap", "profile", "0.05 -0.01", 3, of_bulk_tests.TOO_LOW),
    ],
)
def test_a_curve_that_is_physically_impossible_is_refused_by_its_line(
    tmp_path: Path, test: str, curve: str, values: str, line: int, message: Message
) -> None:
    with pytest.raises(InputError) as caught:
        load_calibration_file(file_with_curve(tmp_path, test, curve, values))

    [fault] = caught.value.faults
    assert fault.key == f"test[0].targets.{curve}.curve"
    assert f"curve.csv, line {line} is " in str(fault)
    assert message.is_in(str(fault))


@pytest.mark.parametrize(
    ("test", "curve", "values"),
    [
        ("discharge", "discharged_mass", "-0.01 1 2 1.99"),
        ("compression", "stress", "-3 200 400 395"),
        ("tapped", "compaction", "1500 1490"),
        ("triaxial", "deviatoric_stress", "900 300"),
        ("triaxial", "volumetric_strain", "0.01 -0.03"),
        ("drum", "surface", "-0.02 0.03"),
        ("heap", "profile", "0.05 0.01"),
    ],
)
def test_a_curve_with_noise_or_of_any_trend_is_taken(
    tmp_path: Path, test: str, curve: str, values: str
) -> None:
    path = file_with_curve(tmp_path, test, curve, values)

    assert len(load_calibration_file(path).tests[0].curves) == 1


def test_a_curve_of_python_that_is_physically_impossible_is_refused(tmp_path: Path) -> None:
    setup = measured_between(tmp_path, "discharge", "discharged_mass", "0 4 s")
    [curve] = setup.problem.curves
    left = replace(curve, values=curve.values[::-1])

    with pytest.raises(InputError, match=r"^discharged_mass, point 2: is 0.1 kg"):
        require_ready(replace(setup.problem, curves=[left]), setup.solvers)


def test_a_measured_discharge_goes_on_to_rest(tmp_path: Path) -> None:
    setup = measured_between(tmp_path, "discharge", "discharged_mass", "0 4 s")
    assert setup.file.tests[0].options["flow_until"] == "rest"

    path = tmp_path / "measured.toml"
    text = path.read_text().replace('"discharge"', '"discharge"\nflow_until = "measured"', 1)
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_calibration(path)
    [fault] = caught.value.faults
    assert fault.key.endswith("flow_until")
    message = of_calibration_file.CURVE_NEEDS
    assert message.is_in(str(fault), curve="discharged_mass", name="flow_until", value="rest")


@pytest.fixture
def setup(write: Callable[..., Path]) -> CalibrationSetup:
    return load_calibration(write())


def test_curves_of_several_tests_have_their_names(write: Callable[..., Path]) -> None:
    other = TEST.replace("press", "other") + TARGET.format(ERRORS)
    problem = load_calibration(write(test=other + TEST)).problem
    assert problem.responses == ("other.stress", "press.stress")
    assert [scope.targets for scope in problem.scopes] == [("other.stress",), ("press.stress",)]


def test_plan_shows_curves(setup: CalibrationSetup) -> None:
    console = Console(file=StringIO(), width=120)
    print_plan(console, describe_plan(setup))
    text = console.file.getvalue()  # type: ignore[attr-defined]
    assert "4 points over strain, 0.01 to 0.15" in text
    assert "uncertainty up to 48.63" in text
    assert 'Table curve.csv: separator ",", decimal ".", columns: strain, stress, 4 rows.' in text


def test_plan_counts_a_curve_as_a_target_at_least(write: Callable[..., Path]) -> None:
    head = HEAD + "other = { min = 2, max = 20 }\n"
    notes = describe_plan(load_calibration(write(head=head))).notes
    assert of_checks.FEW_TARGETS_WITH_CURVES.is_in(notes[0], free=2, targets="1 target")


def test_calibration_of_a_file_with_a_curve(
    setup: CalibrationSetup, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = setup.calibrate(workdir=tmp_path / "work", workers=1)
    assert result.status == "calibrated"
    assert result.parameters["stiffness"] == pytest.approx(10, rel=0.02)
    assert list(result.curves) == ["stress"]
    said = str(analyse_runs(setup, tmp_path / "work"))
    assert "stiffness is determined" in said
    assert "measured" not in said


def test_repeated_runs_show_mean_and_scatter_of_a_curve(
    setup: CalibrationSetup, tmp_path: Path
) -> None:
    runs = repeat_runs(setup, repeat=7, workdir=tmp_path / "runs", workers=1)
    [curve] = runs.curves
    middle = np.interp(
        [0.01, 0.05, 0.1, 0.15],
        np.arange(11) / 50,
        [11000 * x * (1 + 3 * x) for x in np.arange(11) / 50],
    )
    # Of the factors 0.994 to 1.006 in steps of 0.002.
    deviations = 0.002 * np.sqrt(28 / 6) * middle
    assert curve.mean == pytest.approx(middle)
    assert curve.standard_deviations == pytest.approx(deviations)
    # Student's t of six degrees of freedom.
    assert curve.mean_intervals == pytest.approx(2.4469 / np.sqrt(7) * deviations, rel=1e-4)
    errors = np.hypot(0.02, 0.01) * np.array([103, 575, 1300, 2175])
    assert curve.in_uncertainties == pytest.approx(deviations / errors)
    assert curve.runs_for_tolerance == 1
    table = str(runs)
    assert [line.split()[0] for line in table.splitlines()[1:5]] == ["0.01", "0.05", "0.1", "0.15"]
    assert "575 ± 13" in table
    assert "one run scatters" not in table


def test_repeated_runs_of_a_curve_that_scatters_say_how_many_it_takes(
    write: Callable[..., Path], tmp_path: Path
) -> None:
    setup = load_calibration(write(', uncertainty = "0.05 %"'))
    runs = repeat_runs(setup, repeat=7, workdir=tmp_path / "runs", workers=1)
    [curve] = runs.curves
    largest = max(curve.in_uncertainties)
    assert curve.runs_for_tolerance == np.ceil((1.96 * largest / 2) ** 2) > 20
    assert f"the mean of {curve.runs_for_tolerance} runs is within 2 σ at each point" in str(runs)
    assert "repeats" in str(runs)


def test_repeated_runs_say_which_curves_they_do_not_show(
    write: Callable[..., Path], tmp_path: Path
) -> None:
    file = write(curve="x,y\n0.1,1300\n0.4,4000\n")
    short = repeat_runs(file, repeat=2, workdir=tmp_path / "runs", workers=1)
    assert str(short).startswith("2 of 2 simulated curves of stress do not hold all")
    (tmp_path / "model.py").write_text(MODEL.replace('{"stress"', '{"load": 3, "stress"'))
    file.write_text(HEAD + TEST + "targets.load = { value = 3, uncertainty = 0.1 }\n")
    other = repeat_runs(file, repeat=2, workdir=tmp_path / "runs", workers=1)
    assert "stress is a curve that was not measured" in str(other)


def test_table_of_runs_has_no_curves(setup: CalibrationSetup, tmp_path: Path) -> None:
    table = tmp_path / "runs.csv"
    table.write_text("stiffness\n3\n")
    with pytest.raises(InputError, match=r"runs\.csv: stress: ") as caught:
        analyse_runs(setup, table)
    assert of_work_folder.CURVE.is_in(str(caught.value))


def test_table_of_runs_can_do_without_the_curve_of_a_test_with_numbers(
    write: Callable[..., Path], tmp_path: Path
) -> None:
    (tmp_path / "runs.csv").write_text("stiffness,load\n3,3\n")
    file = write(test=TEST + "targets.load = { value = 3, uncertainty = 0.1 }\n")
    with pytest.raises(
        InputError, match=of_work_folder.CURVE_BESIDE_NUMBERS.matching(test="press")
    ):
        analyse_runs(file, tmp_path / "runs.csv")


def test_stiffness_study_needs_single_numbers(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text(CURVE)
    path = tmp_path / "compression.toml"
    path.write_text(compression_file(TARGET.format(ERRORS)))
    with pytest.raises(InputError, match=f"targets: {of_work_folder.CURVES_ONLY.pattern}"):
        stiffness_study(path, workdir=tmp_path / "work")


def test_stiffness_study_names_the_curves_that_it_leaves_out(
    write: Callable[..., Path], tmp_path: Path
) -> None:
    head = HEAD.replace("[parameters]", "[particle]\nyoungs_modulus = 1e6\n[parameters]")
    path = write(head=head, test=TEST + "targets.density = { value = 20, uncertainty = 1 }\n")
    model = MODEL.replace('return {"stress"', 'return {"density": 2 * stiffness, "stress"')
    (tmp_path / "model.py").write_text(model)
    study = stiffness_study(path, factors=[1, 4], seeds=1, workdir=tmp_path / "work", workers=1)
    assert [list(row.responses) for row in study.rows] == [["density"], ["density"]]
    assert "Not compared: stress, which is a curve." in str(study)


def test_expected_narrowing_is_not_known_of_curves(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text(CURVE)
    path = tmp_path / "compression.toml"
    path.write_text(
        compression_file(TARGET.format(ERRORS) + "targets.lateral_stress_ratio = { value = 0.4 }\n")
    )
    setup = load_calibration(path)
    assert gf.expected_narrowing(setup.problem, setup.solvers).narrowing == {}
