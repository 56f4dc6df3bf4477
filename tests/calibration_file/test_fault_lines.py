"""Lines of faults that are found after a calibration file has been read."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.fault_lines import with_lines
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.planned import load_tests
from grainfit.errors import Fault, InputError
from grainfit.options.places import FileFault

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")


@pytest.fixture
def beads(tmp_path: Path) -> Path:
    path = tmp_path / "beads.toml"
    path.write_text(GLASS_BEADS, encoding="utf-8")
    return path


def changed(path: Path, old: str, new: str) -> int:
    """Replace a text of a file, and return the line of what replaces it."""
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")
    return text[: text.index(old)].count("\n") + new.rstrip().count("\n") + 1


def raised(path: Path, fault: Fault, source: str = "", besides: tuple[str, ...] = ()) -> InputError:
    with pytest.raises(InputError) as caught, with_lines(path, besides):
        raise InputError(fault, source)
    return caught.value


def test_cohesion_that_a_solver_does_not_have_has_its_line(beads: Path) -> None:
    key = "cohesion_energy_density"
    line = changed(beads, "[particle_particle]\n", f'[particle_particle]\n{key} = "5 kJ/m^3"\n')

    with pytest.raises(InputError) as caught:
        load_tests(beads)

    words = f"{beads}: line {line}, test 1, particle_particle.{key}: belongs to the contact model"
    assert str(caught.value).startswith(words)


def test_a_budget_that_is_too_small_has_its_line(beads: Path) -> None:
    text = beads.read_text(encoding="utf-8")
    beads.write_text(f"{text}\n[strategy]\nmax_runs = 4\n", encoding="utf-8")
    line = text.count("\n") + 3

    (problem,) = [p for p in describe_plan(load_calibration(beads)).problems if "too few" in p]

    assert problem.startswith(f"{beads}: line {line}, strategy.max_runs: 4 runs are too few")


def test_a_fault_of_a_key_that_is_not_there_has_the_line_of_its_test(beads: Path) -> None:
    error = raised(beads, Fault("test[0].ranks", "is 3."), str(beads))

    line = GLASS_BEADS[: GLASS_BEADS.index("[[test]]")].count("\n") + 1
    assert error.faults == (FileFault("test[0].ranks", "is 3.", "", line),)


def test_faults_of_something_else_are_not_those_of_the_file(beads: Path) -> None:
    beads.write_text(f"{GLASS_BEADS}\n[strategy]\nmax_runs = 4\n", encoding="utf-8")
    fault = Fault("max_runs", "is 3.")

    assert raised(beads, fault, besides=("max_runs",)).faults == (fault,)
    assert raised(beads, fault, "other.toml").faults == (fault,)
    assert raised(beads, Fault("store", "is locked.")).source == ""


def test_faults_of_the_command_line_are_not_those_of_the_file(beads: Path) -> None:
    fault = FileFault("max_runs", "is 0.")
    assert raised(beads, fault, besides=("max_runs",)).source == ""


@pytest.mark.parametrize(
    ("key", "place"),
    [
        ("test heap, particle.youngs_modulus", "youngs_modulus"),
        ("particle.youngs_modulus", "youngs_modulus"),
        ("test[0].particle.youngs_modulus", "youngs_modulus"),
        ("test[0].solver", "solver"),
        ("solver", "solver"),
    ],
)
def test_keys_of_a_test_are_found_as_they_are_told(beads: Path, key: str, place: str) -> None:
    [fault] = raised(beads, Fault(key, "is wrong."), str(beads)).faults

    text = beads.read_text(encoding="utf-8")
    assert isinstance(fault, FileFault)
    assert fault.line is not None
    assert text.splitlines()[fault.line - 1].startswith(place)


def test_a_key_that_a_test_lacks_is_not_that_of_the_file(beads: Path) -> None:
    [fault] = raised(beads, Fault("test[0].name", "is missing."), str(beads)).faults
    test = GLASS_BEADS[: GLASS_BEADS.index("[[test]]")].count("\n") + 1
    assert isinstance(fault, FileFault)
    assert fault.line == test


def test_what_a_test_refuses_of_an_interval_has_its_line(beads: Path) -> None:
    text = beads.read_text(encoding="utf-8")
    sticky = "surface_energy = { min = 0, max = 50 }\n"
    beads.write_text(text.replace("[particle_particle]\n", f"[particle_particle]\n{sticky}"))
    line = next(n for n, row in enumerate(text.splitlines(), 1) if row.startswith("youngs_modulus"))

    (problem,) = [p for p in describe_plan(load_calibration(beads)).problems if "too soft" in p]

    assert problem.startswith(f"{beads}: line {line}, test heap, particle.youngs_modulus: ")
