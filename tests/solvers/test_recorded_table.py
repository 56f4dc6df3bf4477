"""A table of recorded runs as a solver."""

from __future__ import annotations

import re

import numpy as np
import pytest

from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import Response
from grainfit.solvers.base import Workspace
from grainfit.solvers.own_model import table_messages as messages
from grainfit.solvers.own_model.recorded_table import RecordedTable
from grainfit.table_files import messages as of_table_files
from grainfit.testing.solver_contract import SolverContract

HEADER = "comment,density,friction,seed,angle,angle.standard_error"


def write(folder, *lines, header=HEADER, encoding="utf-8"):
    path = folder / "the user's runs.csv"
    path.write_text("\n".join([header, *lines]) + "\n", encoding=encoding)
    return path


@pytest.fixture
def csv_file(tmp_path):
    return write(
        tmp_path,
        "first,1000,0.1,1,20.0,0.5",
        "again,1000,0.1,2,21.0,0.5",
        "again,1000,0.1,3,22.0,0.25",
        '"a, b",2000,0.1,1,23,0.5',
        "last,2000,0.5,1,30,0.5",
    )


@pytest.fixture
def table(csv_file):
    return RecordedTable(csv_file, ["density", "friction"], ["angle"])


def look_up(table, folder, seed=1, **parameters):
    return table.run(parameters, seed, Workspace(folder))["angle"]


class TestTable(SolverContract):
    @pytest.fixture
    def solver(self, table):
        return table

    @pytest.fixture
    def parameters(self):
        return {"density": 1000.0, "friction": 0.1}

    @pytest.fixture
    def watched(self, csv_file):
        return [csv_file.parent]

    def test_run_writes_in_its_own_folder_only(
        self, solver, parameters, workspaces, watched, elsewhere
    ):
        # The file lies beside the folders of the runs here.
        (file,) = watched[0].glob("*.csv")
        before = file.read_bytes()
        super().test_run_writes_in_its_own_folder_only(
            solver, parameters, workspaces, [], elsewhere
        )
        assert file.read_bytes() == before


def test_recorded_run_is_found_by_parameters_and_seed(table, tmp_path):
    assert look_up(table, tmp_path, 2, density=1000, friction=0.1) == Response(21.0, 0.5)
    assert look_up(table, tmp_path, 3, density=1000, friction=0.1) == Response(22.0, 0.25)
    assert look_up(table, tmp_path, 1, density=2000, friction=0.5) == Response(30.0, 0.5)


def test_parameters_may_differ_by_rounding(table, tmp_path):
    found = look_up(table, tmp_path, density=1000 * (1 + 1e-12), friction=0.1 - 1e-13)

    assert found.value == 20.0
    with pytest.raises(RunFailedError):
        look_up(table, tmp_path, density=1001, friction=0.1)


def test_seed_that_was_not_recorded_picks_a_replicate(table, tmp_path):
    values = [look_up(table, tmp_path, s, density=1000, friction=0.1).value for s in range(4, 40)]

    assert set(values) == {20.0, 21.0, 22.0}
    assert values == [
        look_up(table, tmp_path, s, density=1000, friction=0.1).value for s in range(4, 40)
    ]


def test_run_that_was_not_recorded_names_the_nearest(table, tmp_path):
    # As plain numbers 1450 is nearest to 1000, but 0.4 is far from 0.1 in the range of frictions.
    with pytest.raises(RunFailedError) as caught:
        look_up(table, tmp_path, density=1450, friction=0.4)

    assert messages.NO_RUN_THERE.is_in(str(caught.value), there="density = 2000, friction = 0.5")
    assert caught.value.kind == "simulation"


def test_nearest_run_stands_in_when_that_is_wanted(csv_file, tmp_path):
    table = RecordedTable(csv_file, ["density", "friction"], ["angle"], nearest=True)

    assert look_up(table, tmp_path, density=1800, friction=0.45).value == 30.0
    assert look_up(table, tmp_path, 3, density=900, friction=0.0).value == 22.0


def test_real_recorded_runs_are_all_found_again(tmp_path):
    random = np.random.default_rng(1)
    rows = [
        {"x": random.uniform(1e5, 1e7), "y": random.uniform(0, 1), "angle": random.uniform(20, 30)}
        for _ in range(200)
    ]
    table = RecordedTable(rows, ["x", "y"], ["angle"])

    for row in rows:
        assert look_up(table, tmp_path, x=row["x"], y=row["y"]).value == row["angle"]


def test_one_column_with_one_value(tmp_path):
    rows = [{"x": 5.0, "y": y, "angle": 10 * y} for y in (1.0, 2.0)]
    table = RecordedTable(rows, ["x", "y"], ["angle"])

    assert look_up(table, tmp_path, x=5.0, y=2.0).value == 20.0
    with pytest.raises(RunFailedError):
        look_up(table, tmp_path, x=5.1, y=2.0)


def test_definition_follows_the_contents_not_the_place(csv_file, tmp_path):
    names = (["density", "friction"], ["angle"])
    point = {"density": 1000.0, "friction": 0.1}
    copy = tmp_path / "copy.csv"
    copy.write_bytes(csv_file.read_bytes())
    before = RecordedTable(csv_file, *names).definition(point, 1)

    assert RecordedTable(copy, *names).definition(point, 1) == before
    copy.write_text(copy.read_text().replace("30", "31"))
    assert RecordedTable(copy, *names).definition(point, 1) != before
    assert RecordedTable(csv_file, *names, nearest=True).definition(point, 1) != before


def test_file_saved_by_a_spreadsheet(tmp_path):
    path = write(tmp_path, "a, 1000 ,0.1,1,20.0,0.5", "", ",,,,,", encoding="utf-8-sig")
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    table = RecordedTable(path, ["density", "friction"], ["angle"])

    assert look_up(table, tmp_path, density=1000, friction=0.1).value == 20.0


def faults_of(path, parameters=("density", "friction"), responses=("angle",)):
    with pytest.raises(InputError) as caught:
        RecordedTable(path, parameters, responses)
    return str(caught.value).splitlines()


def test_missing_file_and_empty_files(tmp_path):
    assert "cannot be read: No such file" in faults_of(tmp_path / "none.csv")[0]
    (tmp_path / "empty.csv").write_text("\n\n")
    assert "empty.csv: is empty" in faults_of(tmp_path / "empty.csv")[0]
    assert messages.NO_RUNS.is_in(faults_of(write(tmp_path))[0])
    assert messages.NO_RUNS.is_in(faults_of([])[0])


def test_all_missing_columns_are_named(tmp_path):
    path = write(tmp_path, "1,2", header="density,angel")

    lines = faults_of(path)

    assert "line 1, column friction: is missing. There are: density, angel." in lines[0]
    assert 'line 1, column angle: is missing. Is it "angel"?' in lines[1]


def test_units_in_headings_are_converted_where_the_wanted_ones_are_known(tmp_path):
    path = write(tmp_path, "1;2,5;30", header="density [g/cm^3];friction;angle / deg")
    names = (["density", "friction"], ["angle"])
    units = {"density": "kg/m^3", "angle": "deg"}
    table = RecordedTable(path, *names, units=units)

    assert look_up(table, tmp_path, density=1000, friction=2.5).value == 30.0
    assert table.readiness() == (
        f'{path.name}: separator ";", decimal ",", columns: density [g/cm^3], friction, '
        "angle [deg], 1 row."
    )
    with pytest.raises(InputError, match=r"line 1, column density: is in .*, and nothing"):
        RecordedTable(path, *names)


def test_cells_that_are_no_numbers_are_named_by_line_and_column(tmp_path):
    path = write(
        tmp_path,
        "a,1000,0.1,1,20.0,0.5",
        'b,"1,000",0.1,2,nan,0.5',
        "",
        "c,1000,,3,20.0,-0.5",
    )

    lines = faults_of(path)

    assert [line.partition(".csv: ")[2] for line in lines] == [
        "line 3, column density: is '1,000': 1000 or 1.000? Write 1000 or 1.000, without a "
        "separator of thousands.",
        "line 3, column angle: is nan. Leave the row out.",
        "line 5, column friction: has no value. Complete the row, or leave it out.",
        "line 5, column angle.standard_error: is -0.5; a standard error is not negative.",
    ]


def test_lines_of_other_lengths(tmp_path):
    path = write(tmp_path, "a,1000,0.1,1,20.0,0.5", "b,1000,0.1", "c,1000,0.1,1,20.0,0.5,9")

    lines = faults_of(path)

    assert re.search(
        f"line 3, column seed: {of_table_files.TOO_SHORT.matching(count=3, width=6)}", lines[0]
    )
    assert re.search(f"line 4, column 7: {of_table_files.TOO_LONG.matching(count=7)}", lines[1])


def test_standard_error_under_its_former_name(tmp_path):
    header = HEADER.replace(".standard_error", "_std_error")
    path = write(tmp_path, "a,1000,0.1,1,20,0.5", header=header)

    assert [line.partition(".csv: ")[2] for line in faults_of(path)] == [
        "line 1, column angle_std_error: is the name of the standard error of angle in version "
        "0.1.0. Name it angle.standard_error."
    ]


def test_runs_of_a_table_of_version_0_1_0_are_the_same_runs():
    rows = [{"x": 1.0, "angle": 2.0, "angle.standard_error": 0.5, "seed": 1}]
    found = RecordedTable(rows, ["x"], ["angle"]).definition({"x": 1.0}, 1)

    # Of the same rows with angle_std_error, by version 0.1.0.
    hash_then = "e8d8f46dd7f820dc0c92b7850338682aa43ab56bed81b417af59ebd608561813"
    assert found.model["table"] == hash_then


def test_run_recorded_twice(tmp_path):
    path = write(tmp_path, "a,1000,0.1,1,20.0,0.5", "b,1000,0.1,2,20.0,0.5", "c,1e3,0.1,1,21,0.5")

    assert re.search(
        f"line 4: {messages.REPEATED_RUN.matching(first='line 2')}", faults_of(path)[0]
    )


def test_column_that_is_there_twice(tmp_path):
    path = write(tmp_path, "1,2,3,4", header="density,friction,angle,density")

    assert re.search(
        f"line 1, column density: {of_table_files.REPEATED.pattern}", faults_of(path)[0]
    )


def test_files_that_are_no_tables(tmp_path):
    path = tmp_path / "heap.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff\xfe")
    assert re.search(
        f"line 1: {of_table_files.OTHER_ENCODING.matching(encoding='UTF-8')}", faults_of(path)[0]
    )
    path.write_text('a,"b\n')
    assert re.search(f"line 1: {of_table_files.NOT_CSV.pattern}", faults_of(path)[0])


def test_many_faults_are_not_all_listed(tmp_path):
    path = write(tmp_path, *(f"a,x,0.1,{i},20.0,0.5" for i in range(100)))

    lines = faults_of(path)

    assert len(lines) == 21
    assert lines[-1].endswith("has 80 more faults.")


@pytest.mark.parametrize("columns", [[], "density"])
def test_columns_must_be_listed(csv_file, columns):
    assert faults_of(csv_file, parameters=columns)[0].startswith("parameters: are")
    assert faults_of(csv_file, responses=columns)[0].startswith("responses: are")


def test_rows_are_named_by_number():
    rows = [{"x": 1.0, "angle": 2.0}, {"x": 2.0}]

    assert faults_of(rows, ["x"]) == ["row 2, column angle: is missing. Give it in each row."]
