"""A valid file is read completely, in SI units."""

from __future__ import annotations

import dataclasses
import math
import re
import statistics
from pathlib import Path

import pytest

from grainfit.bulk_tests.abilities import starter_remarks
from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration.holdout import require_holdouts
from grainfit.calibration.readiness import obstacles
from grainfit.calibration_file import messages as of_calibration_file
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.content import CalibrationFile, SearchOptions
from grainfit.calibration_file.load import load_calibration_file
from grainfit.calibration_file.starter import starter_file
from grainfit.calibration_file.tests_section import layout_of_test
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.contact_models.registry import MATERIAL_PARAMETERS
from grainfit.errors import GrainfitError, InputError, SolverNotFoundError
from grainfit.materials.sizes import ParticleSizes
from grainfit.problem import Parameter, Target
from grainfit.solvers.registry import types_of_test
from grainfit.strategies.sequential.strategy import Sequential
from grainfit.testing.materials import ROUGH_PLATE

EXAMPLES = Path(__file__).parents[2] / "examples"
GLASS_BEADS = (EXAMPLES / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")

OWN_MODEL = """
name = "my powder"

[parameters]
cohesion = { min = 0, max = 7e4, unit = "J/m^3" }
adhesion = { min = "1 kJ/m^2", max = "2 kJ/m^2", unit = "J/m^2" }
gap = 3

[[test]]
type = "python"
function = "model.py:simulate"
targets.angle_10rpm = { value = 36.0, uncertainty = 0.5 }
targets.torque = { value = "50 N*cm", unit = "N*m", tolerance = "10 %", weight = 2 }
"""


def load(text: str, folder: Path) -> CalibrationFile:
    path = folder / "file.toml"
    path.write_text(text, encoding="utf-8")
    return load_calibration_file(path)


def replaced(old: str, new: str) -> str:
    assert GLASS_BEADS.count(old) == 1
    return GLASS_BEADS.replace(old, new)


def test_the_glass_beads() -> None:
    path = EXAMPLES / "glass_beads" / "calibration.toml"
    file = load_calibration_file(path)
    assert file.path == path
    assert file.sizes == ParticleSizes((0.010,))
    assert file.fixed == {
        "particle.youngs_modulus": 3.6e5,
        "particle.poissons_ratio": 0.22,
        "wall.youngs_modulus": 2.11e11,
        "wall.poissons_ratio": 0.30,
        "wall.density": 7700.0,
        "particle_particle.sliding_friction": 0.18,
        "particle_particle.restitution": 0.79,
        "particle_particle.rolling_damping": 0.25,
        "particle_wall.sliding_friction": 0.27,
        "particle_wall.rolling_friction": 0.005,
        "particle_wall.restitution": 0.82,
        "particle_wall.rolling_damping": 0.25,
    }
    assert file.parameters == (
        Parameter("particle.density", 1407.0, 2793.0, unit="kg/m^3"),
        Parameter("particle_particle.rolling_friction", 0.449, 0.891),
    )
    [test] = file.tests
    assert (test.name, test.type, dict(test.options)) == (
        "heap",
        "heap",
        {**ROUGH_PLATE, "solver": "lammps"},
    )
    assert test.targets == (
        Target("bulk_density", 1500.0, uncertainty=15.0, unit="kg/m^3"),
        Target("angle_of_repose", 22.0, uncertainty=0.5, unit="deg"),
    )
    assert file.strategy == SearchOptions()


def test_the_narrow_interval_is_the_only_difference_of_its_example() -> None:
    wide = load_calibration_file(EXAMPLES / "glass_beads" / "calibration.toml")
    narrow = load_calibration_file(EXAMPLES / "glass_beads" / "narrow_interval.toml")
    assert narrow.parameters[0] == Parameter("particle.density", 1995.0, 2205.0, unit="kg/m^3")
    assert (narrow.fixed, narrow.parameters[1:], narrow.tests) == (
        wide.fixed,
        wide.parameters[1:],
        wide.tests,
    )


@pytest.mark.parametrize(
    "path", sorted(EXAMPLES.rglob("*.toml")), ids=lambda path: f"{path.parent.name}/{path.stem}"
)
def test_every_example_loads_and_is_not_refused(path: Path) -> None:
    setup = load_calibration(path)
    found = [one.error for one in obstacles(setup.problem, setup.solvers)]
    for holdout in setup.holdouts:
        try:
            require_holdouts(setup.problem, setup.solvers, [holdout])
        except GrainfitError as error:
            found.append(error)
    # Its program may be missing on this machine.
    assert not [str(one) for one in found if not isinstance(one, SolverNotFoundError)]


def test_units_sizes_scale_and_geometry(tmp_path: Path) -> None:
    text = replaced(
        'diameter = "10 mm"',
        'diameter = [{ value = "8 mm", mass_fraction = "30 %" }, '
        "{ value = 0.01, mass_fraction = 0.7 }]",
    )
    text = text.replace(
        'youngs_modulus = "0.36 MPa"',
        'youngs_modulus = { min = "0.1 MPa", max = "1e8 Pa", scale = "log" }',
    ).replace(
        'solver = "lammps"',
        'solver = "liggghts"\nname = "small"\nranks = 2\ntimeout = "10 min"\nviews = 8\n'
        'cylinder_radius = "7 cm"\nlift_speed = "3 m/min"\n[strategy]\nmax_runs = 50\nseed = 0\n',
    )
    text, _, targets = text.partition("targets.")
    text = text.replace("[strategy]", f"targets.{targets}[strategy]")
    file = load(text, tmp_path)
    assert file.sizes == ParticleSizes((0.008, 0.010), (0.3, 0.7))
    assert Parameter("particle.youngs_modulus", 1e5, 1e8, "log", "Pa") in file.parameters
    [test] = file.tests
    assert test.name == "small"
    assert test.options == {
        **ROUGH_PLATE,
        "solver": "liggghts",
        "ranks": 2,
        "timeout": 600.0,
        "views": 8,
        "cylinder_radius": 0.07,
        "lift_speed": 0.05,
    }
    assert file.strategy == SearchOptions(max_runs=50, seed=0, strategy=Sequential())


def test_measurements_give_value_and_uncertainty(tmp_path: Path) -> None:
    angles = [21.6, 22.4, 22.9, math.degrees(0.38)]
    text = replaced(
        '{ value = "22 deg", uncertainty = "0.5 deg" }',
        '{ measurements = ["21.6 deg", 22.4, "22.9°", "0.38 rad"] }',
    )
    [_, target] = load(text, tmp_path).tests[0].targets
    assert target.value == pytest.approx(statistics.fmean(angles), rel=1e-12)
    # Student's t of 0.975 with 3 degrees of freedom is 3.1824.
    error = statistics.stdev(angles) / 2
    assert target.uncertainty == pytest.approx(3.1824 / 1.96 * error, rel=1e-4)


def test_the_systematic_part_and_the_tolerance_are_apart(tmp_path: Path) -> None:
    text = replaced(
        '{ value = "22 deg", uncertainty = "0.5 deg" }',
        '{ measurements = [22, 22], systematic = "0.4 deg", tolerance = "1 deg" }',
    )
    [_, target] = load(text, tmp_path).tests[0].targets
    assert (target.value, target.uncertainty, target.tolerance) == (22.0, 0.4, 1.0)
    assert target == Target.of_measurements(
        "angle_of_repose", ["22 deg"] * 2, systematic="0.4 deg", tolerance="1 deg"
    )


def test_own_model_keeps_its_own_units(tmp_path: Path) -> None:
    # Reading a file must not execute what it names.
    code = "raise SystemExit('executed')\ndef simulate(parameters, seed): ..."
    (tmp_path / "model.py").write_text(code, encoding="utf-8")
    file = load(OWN_MODEL, tmp_path)
    assert file.sizes is None
    assert file.fixed == {"gap": 3.0}
    assert file.parameters == (
        Parameter("cohesion", 0.0, 7e4, unit="J/m^3"),
        Parameter("adhesion", 1000.0, 2000.0, unit="J/m^2"),
    )
    [test] = file.tests
    assert test.options == {"function": f"{tmp_path}/model.py:simulate"}
    [angle, torque] = test.targets
    assert angle == Target("angle_10rpm", 36.0, uncertainty=0.5)
    assert (torque.value, torque.tolerance, torque.weight) == pytest.approx((0.5, 0.05, 2.0))
    assert torque.unit == "N*m"


def test_a_target_asks_for_the_median_and_its_default_changes_no_identity(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text("def simulate(parameters, seed): ...", encoding="utf-8")

    def target(statistic: str) -> Target:
        given = f"targets.angle_10rpm = {{ value = 36.0, uncertainty = 0.5{statistic} }}"
        text = OWN_MODEL.replace("targets.angle_10rpm = { value = 36.0, uncertainty = 0.5 }", given)
        return load(text, tmp_path).tests[0].targets[0]

    plain, mean, median = map(target, ("", ', statistic = "mean"', ', statistic = "median"'))
    assert (plain.statistic, median.statistic) == ("mean", "median")
    # Definitions of targets are part of the identity of a calibration.
    assert plain.to_json() == mean.to_json()
    assert plain.to_json().keys() == {
        "name",
        "value",
        "uncertainty",
        "tolerance",
        "weight",
        "unit",
    }
    assert median.to_json() == {**plain.to_json(), "statistic": "median"}
    with pytest.raises(InputError, match=r"statistic.*mean, median"):
        Target("angle_10rpm", 36.0, statistic="mode")  # type: ignore[arg-type]


def test_the_jobs_of_a_cluster(tmp_path: Path) -> None:
    cluster = """
[cluster]
partition = "short,long"
account = "bulk-solids"
walltime = "2 h"
jobs = 4
runs_per_job = 16
setup = ["module load liggghts", "source ~/venv/bin/activate"]
options = ["--mem=4G", "--constraint=skylake"]
"""
    assert load(GLASS_BEADS, tmp_path).cluster is None
    read = load(GLASS_BEADS + cluster, tmp_path).cluster
    assert read == ClusterOptions(
        partition="short,long",
        account="bulk-solids",
        walltime=7200.0,
        jobs=4,
        runs_per_job=16,
        setup=("module load liggghts", "source ~/venv/bin/activate"),
        options=("--mem=4G", "--constraint=skylake"),
    )
    assert read.workers == 64


def test_the_example_of_the_documentation_loads(tmp_path: Path) -> None:
    text = (EXAMPLES.parent / "docs" / "clusters.md").read_text(encoding="utf-8")
    [example, *_] = re.findall(r"```toml\n(\[cluster\]\n.*?)```", text, re.DOTALL)
    read = load(f"{GLASS_BEADS}\n{example}", tmp_path).cluster
    assert read is not None
    assert read.workers == 16


def test_a_parsl_configuration_of_ones_own_is_named_and_not_executed(tmp_path: Path) -> None:
    (tmp_path / "my_parsl.py").write_text("config = 1\nraise SystemExit('executed')\n")
    cluster = '[cluster]\nparsl = "my_parsl.py:config"\njobs = 3\n'
    read = load(f"{GLASS_BEADS}\n{cluster}", tmp_path).cluster
    assert read == ClusterOptions(parsl=f"{tmp_path}/my_parsl.py:config", jobs=3)


def test_relative_paths_start_at_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "calibration").mkdir()
    code = "def simulate(parameters, seed): ..."
    (tmp_path / "calibration" / "model.py").write_text(code, encoding="utf-8")
    (tmp_path / "calibration" / "file.toml").write_text(OWN_MODEL, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    file = load_calibration_file("calibration/file.toml")
    function = file.tests[0].options["function"]
    assert function == f"{tmp_path}/calibration/model.py:simulate"


def test_byte_order_mark_and_windows_line_ends_are_read(tmp_path: Path) -> None:
    path = tmp_path / "file.toml"
    path.write_bytes(b"\xef\xbb\xbf" + GLASS_BEADS.replace("\n", "\r\n").encode())
    assert load_calibration_file(path).name == "glass beads"


@pytest.mark.parametrize("solver", ["lammps", "liggghts"])
def test_the_starter_file_loads(tmp_path: Path, solver: str) -> None:
    file = load(starter_file().replace('"lammps"', f'"{solver}"'), tmp_path)
    assert len(file.parameters) == 2
    assert file.tests[0].options["solver"] == solver


OPTIONS_OF_THE_STARTER = re.findall(r"^# (\w+ = .*)$", starter_file(), re.MULTILINE)


@pytest.mark.parametrize("option", OPTIONS_OF_THE_STARTER)
def test_every_option_of_the_starter_file_is_good(tmp_path: Path, option: str) -> None:
    key = option.partition(" =")[0]
    before, after = starter_file().split(f"# {option}\n")
    if f"\n{key} = " in (section := before[before.rindex("\n[") :]):
        before = before.removesuffix(section) + re.sub(rf"\n{key} = .*", "", section)
    text = f"{before}{option}\n{after}"
    assert load(text, tmp_path) != load(starter_file(), tmp_path)


@pytest.mark.parametrize("name", BUILT_IN)
def test_the_starter_file_of_every_bulk_test_loads_with_any_of_its_options(
    tmp_path: Path, name: str
) -> None:
    text = starter_file([name])
    plain = load(text, tmp_path)
    assert [test.type for test in plain.tests] == [name]
    assert len(plain.tests[0].targets) == len(BUILT_IN[name].responses)
    for key in BUILT_IN[name].option_keys():
        option = f"{key.name} = {key.example}"
        if key.name in starter_remarks(BUILT_IN[name]):
            assert text.count(f"\n{option}") == 1, option
            # The default alone would be said of a value that is another one.
            [line] = [line for line in text.splitlines() if line.startswith(option)]
            assert "by default that of" in line
            continue
        assert text.count(f"# {option}") == 1, option
        changed = text.replace(f"# {option}", option)
        try:
            assert load(changed, tmp_path) != plain, option
        except InputError as error:
            # An option of another choice says which one.
            assert "belongs to" in str(error)  # noqa: PT017


def test_the_starter_file_of_several_tests_gives_equal_ones_their_names(tmp_path: Path) -> None:
    file = load(starter_file(["drum", "heap", "heap"]), tmp_path)
    assert [test.name for test in file.tests] == ["drum", "heap", "heap_2"]


def test_a_starter_file_of_an_unknown_test_is_refused() -> None:
    with pytest.raises(
        InputError, match=rf"{of_calibration_file.NO_BULK_TEST.matching(name='drm')}.*heap"
    ):
        starter_file(["drm"])


def test_the_defaults_in_the_starter_file_are_those_of_the_heap_test() -> None:
    setup = Heap(ParticleSizes((0.010,))).setup
    text = starter_file()
    for key in ("cylinder_radius", "strike_off_height", "plate_radius"):
        assert f'# {key} = "{getattr(setup, key) * 1000:g} mm"' in text
    assert f'# lift_speed = "{setup.lift_speed:g} m/s"' in text


def test_the_file_knows_every_bulk_test() -> None:
    for name, test in BUILT_IN.items():
        keys = {key.name: key for key in layout_of_test(types_of_test()[name]).keys}
        options = {f.name for f in dataclasses.fields(test) if f.init} - {"sizes"}
        assert options == {key.name for key in test.option_keys()}
        assert options <= set(keys)
        kinds = {key.name: key.kind for key in keys["targets"].kind.keys}
        assert kinds.keys() == {*test.responses, *test.curves}
        # Targets may be measured when the file is read: from photographs, or a balance's record.
        given = {n: getattr(kind, "otherwise", kind) for n, kind in kinds.items()}
        assert all(given[n].quantity.unit == info.unit for n, info in test.responses.items())
        assert all(given[n].unit == info.unit for n, info in test.curves.items())


def test_the_file_knows_every_material_parameter() -> None:
    needed = {name for name, known in MATERIAL_PARAMETERS.items() if known.default is None}
    file = load_calibration_file(EXAMPLES / "glass_beads" / "calibration.toml")
    assert set(file.fixed) | {p.name for p in file.parameters} == needed
