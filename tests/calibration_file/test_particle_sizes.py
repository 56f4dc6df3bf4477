"""Particle sizes in the calibration file: distributions, their faults, and their price."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import pytest

import grainfit as gf
from grainfit.bulk_tests.workload import workload
from grainfit.calibration_file import messages
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.plan import describe_plan
from grainfit.materials.size_classes import MOST_CLASSES
from grainfit.options.places import FileFault
from grainfit.solvers.dem.lammps.program import Lammps
from tests.calibration_file.conftest import GLASS_BEADS

DIAMETER = 'diameter = "10 mm"'
SIEVES = "opening [mm],passing [%]\n1,0\n2,12\n3.15,55\n4,88\n5.6,100\n"
LINE = GLASS_BEADS[: GLASS_BEADS.index(DIAMETER)].count("\n") + 1

FaultsOf = Callable[..., list[FileFault]]
PACKING = """
name = "sizes"
[particle]
DIAMETER
youngs_modulus = "10 MPa"
poissons_ratio = 0.22
density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }
[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"
[particle_particle]
sliding_friction = 0.18
rolling_friction = 0.3
restitution = 0.79
rolling_damping = 0.25
[particle_wall]
sliding_friction = 0.27
rolling_friction = 0.005
restitution = 0.82
rolling_damping = 0.25
[[test]]
type = "packing"
solver = "lammps"
targets.bulk_density = { value = "1500 kg/m^3", uncertainty = "1 %" }
"""


@pytest.fixture
def written(tmp_path: Path) -> Callable[[str], Path]:
    """Write a file of a packing test with these particle sizes."""

    def write(diameter: str, sieves: str = SIEVES) -> Path:
        (tmp_path / "sieve.csv").write_text(sieves, encoding="utf-8")
        path = tmp_path / "sizes.toml"
        path.write_text(PACKING.replace("DIAMETER", diameter), encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize(
    ("diameter", "expected"),
    [
        (
            'diameter = { sieve_curve = "sieve.csv" }',
            lambda: gf.SieveCurve((0.001, 0.002, 0.00315, 0.004, 0.0056), (0, 0.12, 0.55, 0.88, 1)),
        ),
        (
            "diameter.log_normal = { median = 0.003, geometric_standard_deviation = 1.4 }",
            lambda: gf.LogNormal(median=0.003, geometric_standard_deviation=1.4),
        ),
        (
            'diameter.log_normal = { d10 = "2 mm", d90 = "4500 um" }',
            lambda: gf.LogNormal(d10=0.002, d90=0.0045),
        ),
        (
            'diameter.rosin_rammler = { d63 = "3 mm", exponent = 3 }',
            lambda: gf.RosinRammler(d63=0.003, exponent=3),
        ),
    ],
)
def test_distributions_are_read(
    written: Callable[[str], Path],
    diameter: str,
    expected: Callable[[], gf.LogNormal | gf.RosinRammler | gf.SieveCurve],
) -> None:
    sizes = load_calibration_file(written(diameter)).sizes

    assert sizes is not None
    classes = gf.divide_into_classes(expected())
    assert sizes.diameters == pytest.approx(classes.diameters, rel=1e-12)
    assert sizes.mass_fractions == classes.mass_fractions


def test_classes_and_limits_are_read(written: Callable[[str], Path]) -> None:
    path = written(
        'diameter.log_normal = { d10 = "2 mm", d90 = "4.5 mm" }\n'
        'diameter.classes = 3\ndiameter.smallest = "2 mm"\ndiameter.largest = "4 mm"'
    )

    distribution = gf.LogNormal(d10="2 mm", d90="4.5 mm")
    classes = gf.divide_into_classes(distribution, 3, smallest="2 mm", largest="4 mm")
    assert load_calibration_file(path).sizes == classes


@pytest.mark.parametrize(
    ("header", "unit", "factor"),
    [
        ("sieve (um)", "", 1000.0),
        ("d [mm]", "", 1.0),
        ("opening", ', opening_unit = "mm"', 1.0),
        ("opening (um)", ', opening_unit = "um"', 1000.0),
    ],
)
def test_the_unit_of_openings_is_in_the_header_or_the_file(
    written: Callable[..., Path], header: str, unit: str, factor: float
) -> None:
    sieves = f"{header},passing\n{1 * factor:g},0\n{4 * factor:g},100\n"

    path = written(f'diameter = {{ sieve_curve = "sieve.csv", classes = 1{unit} }}', sieves)

    known = gf.divide_into_classes(gf.SieveCurve((0.001, 0.004), (0, 1)), 1)
    sizes = load_calibration_file(path).sizes
    assert sizes is not None
    assert sizes.diameters == pytest.approx(known.diameters)
    if not unit:
        assert gf.sieve_curve(path.parent / "sieve.csv").openings == pytest.approx((0.001, 0.004))


@pytest.mark.parametrize(
    ("header", "line"),
    [
        ("foo [mm],bar", "{opening},{passing}"),
        ("opening [mm],mass [g],passing [%]", "{opening},7,{passing}"),
        ("cumulative passing [%],opening [mm]", "{passing},{opening}"),
        (
            "sieve,sieve opening (mm),retained (g),retained (%),finer (%)",
            "1,{opening},7,7,{passing}",
        ),
        ("opening [mm],retained [%],Q3", "{opening},7,{passing}"),
        ("x [mm],q3 [1/mm],Q3 [%]", "{opening},7,{passing}"),
        ("d [mm],standard error,mass [%]", "{opening},7,{passing}"),
        ("opening [mm],passing [%],passing again [%]", "{opening},{passing},7"),
        ("opening [mm],passing [-]", "{opening},{passing}"),
    ],
)
def test_columns_of_a_sieve_curve_are_those_that_their_headings_say(
    tmp_path: Path, header: str, line: str
) -> None:
    path = tmp_path / "sieve.csv"
    lines = [
        line.format(opening=opening, passing=passing) for opening, passing in ((1, 0), (4, 100))
    ]
    path.write_text("\n".join([header, *lines]), encoding="utf-8")

    found = gf.sieve_curve(path)

    assert found.openings == pytest.approx((0.001, 0.004))
    assert found.passing_shares == (0, 1)


def test_the_order_of_sieves_does_not_matter(written: Callable[..., Path]) -> None:
    first, *lines = SIEVES.splitlines()
    path = written('diameter = { sieve_curve = "sieve.csv" }')
    as_given = load_calibration_file(path).sizes
    written('diameter = { sieve_curve = "sieve.csv" }', "\n".join([first, *reversed(lines)]))

    assert load_calibration_file(path).sizes == as_given


@pytest.mark.parametrize(
    ("given", "key", "words"),
    [
        ("{ classes = 3 }", "particle.diameter", 'one of { sieve_curve = "sieve.csv" }'),
        (
            "{ log_normal = { d10 = 1e-3, d90 = 2e-3 }, clases = 3 }",
            "particle.diameter.clases",
            'Did you mean "classes"?',
        ),
        (
            "{ log_normal = { d10 = 1e-3, d90 = 2e-3 }, rosin_rammler = { d63 = 1 } }",
            "particle.diameter",
            "has log_normal and rosin_rammler",
        ),
        ("{ log_normal = 3 }", "particle.diameter.log_normal", "must be a table"),
        ("{ log_normal = { median = 1e-3 } }", "particle.diameter.log_normal", "has median"),
        (
            '{ log_normal = { d10 = "1 kg", d90 = "2 mm" } }',
            "particle.diameter.log_normal.d10",
            "kg",
        ),
        (
            "{ rosin_rammler = { d63 = 1e-3 } }",
            "particle.diameter.rosin_rammler.exponent",
            "missing",
        ),
        (
            f"{{ rosin_rammler = {{ d63 = 1e-3, exponent = 3 }}, classes = {MOST_CLASSES + 1} }}",
            "particle.diameter.classes",
            f"{MOST_CLASSES + 1}",
        ),
        (
            "{ rosin_rammler = { d63 = 1e-3, exponent = 3 }, smallest = 2e-3, largest = 1e-3 }",
            "particle.diameter.smallest",
            "not below",
        ),
        (
            "{ rosin_rammler = { d63 = 1e-3, exponent = 0.8 } }",
            "particle.diameter.smallest",
            "is infinite",
        ),
        (
            '{ rosin_rammler = { d63 = 1e-3, exponent = 3 }, opening_unit = "mm" }',
            "particle.diameter.opening_unit",
            "without sieve_curve",
        ),
        ('{ sieve_curve = "no.csv" }', "particle.diameter.sieve_curve", "there is no such file"),
    ],
)
def test_faults_of_distributions_are_named_with_their_line(
    faults_of: FaultsOf, given: str, key: str, words: str
) -> None:
    faults = faults_of((DIAMETER, f"diameter = {given}"))

    assert key in [fault.key for fault in faults]
    fault = next(fault for fault in faults if fault.key == key)
    assert words in str(fault)
    assert fault.line == LINE


@pytest.mark.parametrize(
    ("sieves", "options", "words"),
    [
        ("", "", "is empty"),
        ("opening,passing\n1,0\n2,100\n", "", "sieve.csv, line 1, column opening has no unit"),
        ("opening [kg],passing\n1,0\n2,100\n", "", "has the unit 'kg'"),
        ("opening,passing\n1,0\n2,100\n", ', opening_unit = "s"', "opening_unit"),
        ("opening [mm],passing\n1,0\n2,110\n", "", "line 3 has a passing of 110 %"),
        (
            "opening [mm],passing\n1,0\n4,100\n",
            ', opening_unit = "cm"',
            "line 1, column opening states 'mm', and its numbers are taken in cm. Write "
            'opening_unit = "mm", or correct the heading.',
        ),
        ("opening [mm],passing\n1,0\n2,100.4\n", "", "line 3 has a passing of 100.4 %"),
        ("opening [mm],passing\n1,0\n4,99.99\n", "", "only 99.99 % of the mass pass the coarsest"),
        (
            "opening [mm],passing\n1,0\n2,60\n3,50\n4,100\n",
            "",
            "line 4 has a passing of 50 % at 3 mm, below the 60 % at 2 mm.",
        ),
        ("opening [mm],passing\n1,0\n1,40\n4,100\n", "", "line 3, column opening is the same"),
        ("opening [mm],passing\n0,0\n1,40\n4,100\n", "", "line 2 has an opening of 0 m"),
        ("opening [mm],passing\n1,0\n4,1\n", "", "only 1 % of the mass pass the coarsest"),
        ("opening [mm],passing\n1,3\n4,100\n", "", "3 % of the mass pass the finest sieve, 1 mm"),
        ("opening [mm],passing\n1,a\n4,100\n", "", "line 2, column passing is 'a'"),
        ("opening [mm]\n1\n4\n", "", "line 1 has one column"),
        ("opening [mm],passing\n5,6,100\n7,100\n", "", "line 2, column 3 is in a row of 3"),
        ("opening [mm],passing [Pa]\n1,0\n4,100\n", "", "column passing states 'Pa'"),
        (
            "opening [mm],retained [%]\n1,0\n4,100\n",
            "",
            "has the columns 'opening [mm]', 'retained [%]', and none of them is the cumulative "
            'passing. Give one column the heading "passing [%]": 100 % minus all that this sieve '
            "and the coarser ones retain.",
        ),
        ("opening [mm],mass [g]\n1,0\n4,100\n", "", "and none of them is the cumulative passing"),
        ("opening [mm],passing [g]\n1,0\n4,100\n", "", 'the heading "passing [%]"'),
        ("opening [mm],a,b\n1,0,0\n4,100,0\n", "", "none of them is the cumulative passing"),
        (
            "opening [mm],first passing [%],second passing [%]\n1,0,0\n4,100,100\n",
            "",
            "more than one of them may be the cumulative passing",
        ),
        (
            "from [mm],to [mm],passing [%]\n1,2,0\n4,5,100\n",
            "",
            'more than one of them may be the opening. Give one column the heading "opening [mm]"',
        ),
        ("opening [mm],passing\n1,0\n", "", "line 2 ends a table of 1 points"),
    ],
)
def test_faults_of_sieve_curves_are_named_with_their_line(
    faults_of: FaultsOf, tmp_path: Path, sieves: str, options: str, words: str
) -> None:
    (tmp_path / "sieve.csv").write_text(sieves, encoding="utf-8")

    faults = faults_of((DIAMETER, f'diameter = {{ sieve_curve = "sieve.csv"{options} }}'))

    assert words in " ".join(map(str, faults))
    assert {fault.line for fault in faults} == {LINE}


def plan_of(path: Path) -> tuple[str, str]:
    """Lines and notes of the plan."""
    plan = describe_plan(gf.load(path))
    return "\n".join(plan.lines), "\n".join(plan.notes)


def test_the_plan_tells_the_price_of_the_finest_class(written: Callable[..., Path]) -> None:
    lines, _ = plan_of(written('diameter = { sieve_curve = "sieve.csv" }'))

    told = re.search(
        r"The finest class, (\S+) mm, has 20 % of the mass and (\S+) % of the particles, and sets "
        r"the time step: without it, a run would take (\S+) of the time",
        lines,
    )
    assert told, lines
    curve = gf.SieveCurve((0.001, 0.002, 0.00315, 0.004, 0.0056), (0, 0.12, 0.55, 0.88, 1))
    sizes = gf.divide_into_classes(curve)
    assert float(told[1]) == pytest.approx(1000 * sizes.diameters[0], rel=5e-3)
    assert float(told[2]) == pytest.approx(100 * sizes.number_fractions[0], rel=5e-3)

    whole, without = (seconds_of(one) for one in (sizes, sizes.without(0)))
    assert float(told[3]) == pytest.approx(without / whole, rel=0.05)
    told = re.search(r'With smallest = "(\S+) mm", .* the finest 5 % .* take (\S+) of the', lines)
    assert told, lines
    left = gf.divide_into_classes(curve, smallest=f"{told[1]} mm")
    assert float(told[2]) == pytest.approx(seconds_of(left) / whole, rel=0.05)


def test_a_price_is_told_of_what_is_left(written: Callable[..., Path]) -> None:
    lines, _ = plan_of(
        written(
            "diameter.log_normal = { median = 3e-3, geometric_standard_deviation = 1.6 }\n"
            'diameter.smallest = "1.2 mm"'
        )
    )

    share = 100 * gf.LogNormal(median=3e-3, geometric_standard_deviation=1.6).passing(1.2e-3)
    assert f"The finest {share:.3g} % of the mass are left out." in lines
    assert messages.WITHOUT_FINEST.is_in(lines, which="another", mass="5 %")


def test_prices_name_real_sizes_where_particles_are_coarse_grained(
    written: Callable[..., Path],
) -> None:
    def lines_of(factor: int) -> str:
        path = written('diameter = { sieve_curve = "sieve.csv" }\ncoarse_graining = ' + f"{factor}")
        # Room for the large ones.
        path.write_text(f'{path.read_text()}cylinder_radius = "25 mm"\n')
        return plan_of(path)[0]

    def told(lines: str) -> list[str]:
        found = [one for one in lines.splitlines() if "Particle sizes:" in one or "finest" in one]
        return [re.sub(r"take \S+ of", "take", line) for line in found]

    real, coarse = told(lines_of(1)), told(lines_of(2))
    assert len(real) == 3
    assert coarse == real


def seconds_of(sizes: gf.ParticleSizes) -> float:
    material = {
        "particle.density": 2100.0,
        "particle.youngs_modulus": 1e7,
        "particle.poissons_ratio": 0.22,
    }
    return Lammps.speed.cost(workload(gf.tests.Packing(sizes), material)).wall_seconds


def test_a_fine_class_of_a_list_has_its_price_too(written: Callable[..., Path]) -> None:
    classes = "{ value = 1e-3, mass_fraction = 0.03 }, { value = 4e-3, mass_fraction = 0.97 }"

    lines, _ = plan_of(written(f"diameter = [{classes}]"))

    assert messages.FINEST_CLASS.is_in(lines, diameter="1 mm", mass="3 %", particles="66.4 %")
    assert "smallest" not in lines


@pytest.mark.parametrize(
    "diameter",
    [
        "3e-3",
        "[{ value = 3e-3, mass_fraction = 0.5 }, { value = 3.1e-3, mass_fraction = 0.5 }]",
    ],
)
def test_sizes_that_cost_little_have_no_price(written: Callable[..., Path], diameter: str) -> None:
    lines, notes = plan_of(written(f"diameter = {diameter}"))

    assert "finest" not in lines
    assert "leave out the ends" not in notes


@pytest.mark.parametrize(("coarse", "is_told"), [(0.05, True), (0.5, False)])
def test_a_class_of_few_particles_is_told(
    written: Callable[..., Path], coarse: float, is_told: bool
) -> None:
    path = written(
        f"diameter = [{{ value = 2e-3, mass_fraction = {1 - coarse} }}, "
        f"{{ value = 9e-3, mass_fraction = {coarse} }}]"
    )
    small = 'fill_height = "25 mm"\ncylinder_radius = "20 mm"\nbulk_density_top = "20 mm"'
    path.write_text(f"{path.read_text()}{small}\n")

    _, notes = plan_of(path)

    told = re.search(r"Test packing has (\d) particles of 9 mm, for 5 % of the mass", notes)
    assert bool(told) == is_told, notes
    if told:
        volume = math.pi * 0.02**2 * 0.025
        expected = 0.05 * 0.58 * volume / (math.pi / 6 * 0.009**3)
        assert float(told[1]) == pytest.approx(expected, abs=1)


def test_prices_of_clumps_are_those_of_clumps(written: Callable[..., Path]) -> None:
    sizes = "diameter.log_normal = { median = 3e-3, geometric_standard_deviation = 1.4 }\n"
    shares = []
    for shape in ("", 'shape = "two_spheres"\naspect_ratio = 1.5'):
        lines, _ = plan_of(written(sizes + shape))
        told = re.search(r'With smallest = "\S+ mm", .* the finest 5 % .* take (\S+) of', lines)
        assert told, lines
        shares.append(float(told[1]))

    assert shares[1] == pytest.approx(shares[0], abs=0.05)
