"""Tables in files: one reader for all dialects, and faults with file, line and column."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grainfit.errors import InputError
from grainfit.materials.diameters import sieve_curve
from grainfit.options.kinds import Quantity
from grainfit.solvers.own_model.recorded_table import RecordedTable
from grainfit.table_files import messages
from grainfit.table_files.headings import heading
from grainfit.table_files.reading import Reading, TableFaults, Wanted, require_headings
from grainfit.table_files.table import read_table

Numbers = list[list[float | None]]
#: Separator, decimal mark, quotes around a cell, comment above the headings, encoding.
Dialect = tuple[str, str, Callable[[str], str], str, str]
many = settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


def read(
    path: Path, columns: Sequence[int] = (0, 1), unit: str | None = None
) -> tuple[Numbers, str]:
    """Return the numbers of some columns, as they are or in a unit, and what was understood."""
    table, faults = read_table(path), TableFaults()
    require_headings(table)
    wanted = Wanted(Quantity(unit), given="" if unit is None else None)
    reading = Reading(table, dict.fromkeys(columns, wanted), faults)
    numbers = [[reading.number(row, at) for at in columns] for row in reading.rows()]
    faults.require_none(str(path))
    return numbers, reading.describe()


@pytest.fixture
def numbers_of(tmp_path: Path) -> Callable[..., Numbers]:
    def numbers(text: str | bytes, **options: object) -> Numbers:
        path = tmp_path / "table.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read(path, **options)[0]  # type: ignore[arg-type]

    return numbers


@pytest.mark.parametrize(
    ("first", "separator"),
    [("sep=;", ";"), ("SEP=,", ","), ('"sep=;";', ";"), ("sep=|", "|"), ("\nsep=\t", "\t")],
)
def test_a_first_line_names_the_separator(numbers_of, first, separator):
    rows = [("u; v", "f"), ("1.5", "2"), ("x", "3")]
    text = "\r\n".join([first, *(separator.join(f'"{cell}"' for cell in row) for row in rows)])

    with pytest.raises(InputError) as caught:
        numbers_of(text)
    [fault] = caught.value.faults
    assert fault.key == f"line {3 + first.count(chr(10)) + 1}, column u; v"
    assert numbers_of(text.replace("x", "4")) == [[1.5, 2.0], [4.0, 3.0]]


@pytest.mark.parametrize(
    "text",
    [
        "u;f\nmm;kN\n1500;0,002\n",
        "u [mm];f\nmm;[kN]\n1500;0,002\n",
        "u\tf (kN)\n(mm)\t\n1500\t0.002\n",
        "u f remark\nmm kN -\n1500 0.002 a\n",
    ],
)
def test_a_row_of_units_below_the_headings(tmp_path, text):
    path = tmp_path / "table.csv"
    path.write_text(text)
    table, faults = read_table(path), TableFaults()
    wanted = {at: Wanted(Quantity(unit), needs_unit=True) for at, unit in enumerate(("m", "N"))}
    reading = Reading(table, wanted, faults)

    assert [reading.number(row, at) for row in reading.rows() for at in wanted] == [1.5, 2.0]
    assert not faults.found
    assert "u [mm], f [kN]" in reading.describe()


@pytest.mark.parametrize("text", ["u;f\nmm;force\n1;2\n", "u [m];f\nmm;N\n1;2\n"])
def test_units_below_headings_among_other_cells_are_named(numbers_of, text):
    with pytest.raises(InputError) as caught:
        numbers_of(text)

    assert messages.UNIT_BELOW_HEADING.is_in(str(caught.value), name="u", unit="mm")


def test_a_point_beside_a_decimal_comma_may_separate_thousands(numbers_of):
    with pytest.raises(InputError) as caught:
        numbers_of("u;f\n1.000;2,1\n2.000;3,1\n")

    expected = messages.THOUSANDS_OR_DECIMAL
    assert expected.is_in(str(caught.value), whole="1000", decimal="1,000")


@pytest.mark.parametrize(
    "text",
    [
        "u,f\n1.5,-20\n2,0.25\n",
        "u;f\n1,5;-20\n2;0,25\n",
        "u\tf\r\n1,5\t-20\r\n2\t0,25\r\n",
        "u f\n1.5   -20\n  2 2.5e-1\n",
        "# u f\n1.5 -20\n2 0.25\n",
        "# pulled slowly, twice\n# u;f\n1,5;-20\n\n# a pause; a comment, too\n2;0,25\n",
        "# pulled slowly\nu [mm] f [N]\n1,5 -20\n2 0,25\n",
        '"u [mm]";"f, mean [N]"\n"1,5";"-20"\n"2";"0,25"\n',
        'u,f,remark\n"1,5",-20,"good, so far"\n2,"0,25",\n',
        "\ufeffu,f\n1.5,-20\n2,0.25\n",
        "u,f,remark\n1.5,-20\n2,0.25,no cell before this one\n",
        "u;f\n1,5;-20\n2;0,25\n".encode("utf-16"),
    ],
)
def test_dialects_of_a_table_have_the_same_numbers(
    numbers_of: Callable[..., Numbers], text: str | bytes
) -> None:
    assert numbers_of(text) == [[1.5, -20], [2, 0.25]]


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("Height [mm]", "Height", "mm"),
        ("height / mm", "height", "mm"),
        ("height (mm)", "height", "mm"),
        ("stress / kN/m^2", "stress", "kN/m^2"),
        ("stress in kPa", "stress", "kPa"),
        ("stress, kPa", "stress", "kPa"),
        ("stress/kPa", "stress", "kPa"),
        ("flow in l/min", "flow", "l/min"),
        ("strain, %", "strain", "%"),
        ("height (left)", "height (left)", None),
        ("stress/strain", "stress/strain", None),
        ("stress, mean", "stress, mean", None),
        ("F/A", "F/A", None),
        ("l/min", "l/min", None),
        ("load / unload", "load / unload", None),
        ("stress [mean of 3]", "stress", "mean of 3"),
    ],
)
def test_a_heading_states_its_unit(text: str, name: str, unit: str | None) -> None:
    found = heading(0, text)
    assert (found.name, found.unit) == (name, unit)
    assert found.states_unit is (unit not in (None, "mean of 3"))


def test_numbers_are_converted_from_the_unit_in_the_heading(
    numbers_of: Callable[..., Numbers],
) -> None:
    assert numbers_of("a [mm];b / cm;c (m)\n1;1;1\n", columns=(0, 1, 2), unit="m") == [
        [0.001, 0.01, 1]
    ]


def test_a_table_says_how_it_was_understood(tmp_path: Path) -> None:
    path = tmp_path / "sieve.csv"
    path.write_text("d;n;remark;;\n1,5;0;wet;;\n4;100;;;\n")
    assert read(path)[1] == (
        'sieve.csv: separator ";", decimal ",", columns: d, n (ignored: remark), 2 rows'
    )


@pytest.mark.parametrize(
    ("text", "where", "message"),
    [
        ("u;f\n1,234;2\n", "line 2, column u", messages.THOUSANDS_OR_DECIMAL),
        ('u,f\n"1,234",0.5\n', "line 2, column u", messages.THOUSANDS_OR_DECIMAL),
        ("u;f\n1.234;2,5\n0,5;1\n", "line 2, column u", messages.THOUSANDS_OR_DECIMAL),
        ("u;f\n1,234,567;2\n", "line 2, column u", messages.NOT_A_NUMBER),
        ("u;f\n1.234,5;2\n0,5;0,5\n", "line 2, column u", messages.NOT_A_NUMBER),
        ("u;f\n1,5;2,5\n1;2.5\n", "line 3, column f", messages.OTHER_DECIMAL_MARK),
        ("u;f\n1.5;2.5\n1;2,5\n", "line 3, column f", messages.OTHER_DECIMAL_MARK),
        ("u;f\n1;1_000\n", "line 2, column f", messages.NOT_A_NUMBER),
        ("u;f\n1;nan\n", "line 2, column f", messages.NOT_FINITE),
        ("u;f\n-inf;1\n", "line 2, column u", messages.NOT_FINITE),
        ("u;f\n1;\n", "line 2, column f", messages.NO_VALUE),
        ("u;f\n1\n", "line 2, column f", messages.TOO_SHORT),
        ("u;f;g\n1;2\n1;2;3\n", "line 2, column g", messages.TOO_SHORT),
        ("u;f\n1;2;3\n", "line 2, column 3", messages.TOO_LONG),
        ("u,f\n1,5,2,5\n", "line 2, column 3", messages.TOO_LONG),
        ("u;u\n1;2\n", "line 1, column u", messages.REPEATED),
        ('u,f\n1,"2\n', "line 2", messages.NOT_CSV),
        (b"u,f\n1,2\n\xb0,3\n", "line 3", messages.OTHER_ENCODING),
        (b"u,f\n1,\0\n", "line 2", messages.OTHER_ENCODING),
        (b"\xff\xfeu", "line 1", messages.OTHER_ENCODING),
        ("\n", "", messages.EMPTY),
    ],
)
def test_a_fault_has_its_line_and_its_column(
    numbers_of: Callable[..., Numbers], text: str | bytes, where: str, message: messages.Message
) -> None:
    with pytest.raises(InputError, match=message.pattern) as caught:
        numbers_of(text)
    assert caught.value.faults[0].key == where
    assert caught.value.source.endswith("table.csv")


def test_an_ambiguous_number_is_refused_with_both_readings(
    numbers_of: Callable[..., Numbers],
) -> None:
    expected = messages.THOUSANDS_OR_DECIMAL(shown="'1,234'", whole="1234", decimal="1.234")
    with pytest.raises(InputError, match=re.escape(expected)):
        numbers_of("u;f\n1,234;2\n")
    assert numbers_of("u;f\n1,234;2,5\n") == [[1.234, 2.5]], "another number tells"
    assert numbers_of("u;f\n0,125;2\n") == [[0.125, 2]]
    assert numbers_of("u,f\n1.234,2\n") == [[1.234, 2]]


def test_only_regular_files_are_opened(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    with pytest.raises(InputError, match=messages.NO_REGULAR_FILE.pattern):
        read_table(pipe)
    for path in (tmp_path, tmp_path / "none.csv", Path("a\0b")):
        with pytest.raises(InputError, match=messages.CANNOT_BE_READ.pattern):
            read_table(path)


# --- any table, in any dialect --------------------------------------------------------------------

PIECES = [b",", b";", b"\n", b'"', b"nan", b"1,"]
numbers = st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-6)
tables = st.integers(2, 5).flatmap(
    lambda width: st.lists(
        st.lists(numbers, min_size=width, max_size=width), min_size=1, max_size=8
    )
)


@st.composite
def dialects(draw: st.DrawFn) -> Dialect:
    separator = draw(st.sampled_from([",", ";", "\t", " ", "   "]))
    mark = "." if separator == "," else draw(st.sampled_from(".,"))
    quoted = draw(st.booleans())
    comment = draw(st.sampled_from(["", "# ", "# measured: 3, 4; 5\n"]))
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]))
    return separator, mark, (lambda cell: f'"{cell}"' if quoted else cell), comment, encoding


def written(table: Numbers, dialect: Dialect, end: str) -> bytes:
    separator, mark, quote, comment, encoding = dialect
    head = comment + separator.join(f"c{at} [m]" for at in range(len(table[0])))
    rows = [
        separator.join(quote(f"{number:.9e}".replace(".", mark)) for number in row) for row in table
    ]
    return (end.join([head.replace("\n", end), *rows]) + end).encode(encoding)


@many
@given(table=tables, dialect=dialects(), end=st.sampled_from(["\n", "\r\n"]))
def test_a_table_reads_back_the_same_in_any_dialect(
    tmp_path: Path,
    table: Numbers,
    dialect: Dialect,
    end: str,
) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes(written(table, dialect, end))
    found, _ = read(path, range(len(table[0])), "m")
    assert found == [[float(f"{number:.9e}") for number in row] for row in table]


@many
@given(
    table=tables,
    dialect=dialects(),
    damage=st.lists(
        st.tuples(
            st.integers(0, 400),
            st.integers(0, 3),
            st.one_of(st.binary(max_size=3), st.sampled_from(PIECES)),
        ),
        max_size=4,
    ),
)
def test_damage_gives_numbers_or_a_fault_with_its_place(
    tmp_path: Path,
    table: Numbers,
    dialect: Dialect,
    damage: list[tuple[int, int, bytes]],
) -> None:
    data = written(table, dialect, "\n")
    for at, cut, new in damage:
        data = data[:at] + new + data[at + cut :]
    path = tmp_path / "table.csv"
    path.write_bytes(data)
    readers: list[Callable[[], object]] = [
        lambda: RecordedTable(path, ["c0"], ["c1"]),
        lambda: sieve_curve(path),
        lambda: read(path),
    ]
    for reader in readers:
        for text in faults_of(reader):
            assert "table.csv" in text
            has_place = re.search(r"line \d+", text) or "more faults" in text
            assert has_place or messages.EMPTY.is_in(text), text


def faults_of(reader: Callable[[], object]) -> list[str]:
    """Return the faults that keep a reader from numbers."""
    try:
        reader()
    except InputError as error:
        return [f"{error.source}: {fault}" for fault in error.faults] or ["no fault"]
    return []
