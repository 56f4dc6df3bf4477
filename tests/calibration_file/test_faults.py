"""Every fault of a file has one message that names the key, the value and the remedy."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from grainfit.calibration_file.load import load_calibration_file
from grainfit.errors import InputError
from grainfit.options import messages
from grainfit.options.places import FileFault

FaultsOf = Callable[..., list[FileFault]]

DENSITY = 'density = { min = "1407 kg/m^3", max = "2793 kg/m^3" }'
FRICTION = "rolling_friction = { min = 0.449, max = 0.891 }"
TARGET = 'targets.bulk_density = { value = "1500 kg/m^3", uncertainty = "1 %" }'
ANGLE = 'targets.angle_of_repose = { value = "22 deg", uncertainty = "0.5 deg" }'
SOLVER = 'solver = "lammps"'
DIAMETER = 'diameter = "10 mm"'


@pytest.mark.parametrize(
    ("old", "new", "key", "value", "remedy"),
    [
        # keys
        (DENSITY, "densty = 2100", "particle.densty", "", '"density"'),
        (SOLVER, SOLVER + "\nlift_sped = 1", "test[0].lift_sped", "", '"lift_speed"'),
        (SOLVER, SOLVER + "\nzzz = 1", "test[0].zzz", "", "lift_speed"),
        ("[wall]", "restitution = 0.5\n[wall]", "particle.restitution", "", "particle_wall"),
        ("[wall]", "[wal]\n[wall]", "wal", "", '"wall"'),
        ('name = "glass beads"', "", "name", "", 'name = "glass beads"'),
        ("poissons_ratio = 0.30", "", "wall.poissons_ratio", "", "poissons_ratio = "),
        (SOLVER, "", "test[0].solver", "", '"lammps"'),
        ('type = "heap"', "", "test[0].type", "", "heap"),
        ('type = "heap"', 'type = "heep"', "test[0].type", "heep", '"heap"'),
        (SOLVER, 'solver = "lamps"', "test[0].solver", "lamps", '"lammps"'),
        ('name = "glass beads"', 'nam = "x"', "nam", "", '"name"'),
        (SOLVER, 'solvr = "lammps"', "test[0].solvr", "", '"solver"'),
        # units
        (DIAMETER, 'diameter = "10 kg"', "particle.diameter", "10 kg", "10 mm"),
        (DIAMETER, 'diameter = "10"', "particle.diameter", "10", "10 mm"),
        (DIAMETER, 'diameter = "0,01 m"', "particle.diameter", "0,01 m", "decimal point"),
        (DIAMETER, 'diameter = "wide"', "particle.diameter", "wide", "10 mm"),
        (DIAMETER, f'diameter = "{"9^" * 99}9 m"', "particle.diameter", "9^9^", "10 mm"),
        (
            "sliding_friction = 0.18",
            'sliding_friction = "10 deg"',
            "particle_particle.sliding_friction",
            "10 deg",
            "plain number",
        ),
        # keys of other places
        (DENSITY, 'density = { value = "2 g/cm^3" }', "density.value", "", 'density = "2100'),
        (SOLVER, SOLVER + "\nslot_width = 1", "test[0].slot_width", "", '"draw_down"'),
        (TARGET, "targets.mass_flow = 1", "test[0].targets.mass_flow", "", '"discharge"'),
        # kinds of value
        (DIAMETER, "diameter = true", "particle.diameter", "true", "10 mm"),
        (DIAMETER, "diameter = 1979-05-27", "particle.diameter", "1979", "10 mm"),
        (DIAMETER, "diameter = { value = 1 }", "particle.diameter", "value", "mass_fraction"),
        ('name = "glass beads"', "name = 3", "name", "3", "quotes"),
        ('name = "glass beads"', 'name = "a\\nb"', "name", "a", "one line"),
        ("[wall]", "[[wall]]", "wall", "", "[wall]"),
        ("[[test]]", "[test]", "test", "", "[[test]]"),
        (SOLVER, SOLVER + '\nwalls = "steel"', "test[0].walls", "steel", "{ cylinder = ..."),
        (SOLVER, SOLVER + "\nranks = 1.5", "test[0].ranks", "1.5", "example"),
        (SOLVER, SOLVER + "\nranks = true", "test[0].ranks", "true", "example"),
        (SOLVER, SOLVER + "\nranks = 0", "test[0].ranks", "0", "from 1"),
        (SOLVER, SOLVER + '\ntimeout = "0 s"', "test[0].timeout", "0 s", "above 0"),
        (SOLVER, SOLVER + '\nname = "a/b"', "test[0].name", "a/b", "letters"),
        # intervals
        (FRICTION, "rolling_friction = { min = 0.9, max = 0.4 }", "", "0.9", "min must be below"),
        (FRICTION, "rolling_friction = { min = 0.4, max = 0.4 }", "", "equal", "min must be below"),
        (FRICTION, "rolling_friction = [0.4, 0.9]", "", "[0.4, 0.9]", "{ min = ..., max = ... }"),
        (FRICTION, 'rolling_friction = "0.4 - 0.9"', "", "0.4 - 0.9", "{ min = ..., max = ... }"),
        (FRICTION, 'rolling_friction = "0.4..0.9"', "", "0.4..0.9", "{ min = ..., max = ... }"),
        (FRICTION, "rolling_friction = { min = 0.4 }", ".max", "missing", ""),
        (FRICTION, "rolling_friction = { min = -1, max = 1 }", ".min", "-1", "from 0 to 10"),
        (FRICTION, "rolling_friction = { min = nan, max = 1 }", ".min", "nan", "finite"),
        (FRICTION, "rolling_friction = { min = 0, max = inf }", ".max", "inf", "finite"),
        (
            FRICTION,
            'rolling_friction = { min = 0, max = 1, scale = "log" }',
            ".min",
            "0",
            "above 0",
        ),
        (
            FRICTION,
            'rolling_friction = { min = 0.1, max = 1, scale = "logarithmic" }',
            ".scale",
            "logarithmic",
            "linear, log",
        ),
        (FRICTION, "rolling_friction = { min = 0.1, max = 1, step = 1 }", ".step", "", "min"),
        # physical limits
        (
            "poissons_ratio = 0.22",
            "poissons_ratio = 0.6",
            "particle.poissons_ratio",
            "0.6",
            "0.4999",
        ),
        (
            'youngs_modulus = "0.36 MPa"',
            'youngs_modulus = "0.36 mPa"',
            "particle.youngs_modulus",
            "0.36 mPa",
            "1000",
        ),
        (
            "restitution = 0.79",
            "restitution = 1e999",
            "particle_particle.restitution",
            "inf",
            "finite",
        ),
        ("restitution = 0.79", f"restitution = {'9' * 400}", ".restitution", "inf", "finite"),
        (DIAMETER, "diameter = 10", "particle.diameter", "10", "1 m"),
        (DIAMETER, 'diameter = "-1 mm"', "particle.diameter", "-1 mm", "from 1e-07"),
        # particle sizes
        (DIAMETER, "diameter = []", "particle.diameter", "0 entries", "at least 1"),
        (DIAMETER, 'diameter = ["8 mm"]', "particle.diameter[0]", "8 mm", "mass_fraction = ..."),
        (
            DIAMETER,
            'diameter = [{ value = "8 mm", mass_fraction = 30 }]',
            "particle.diameter[0].mass_fraction",
            "30",
            '"25 %"',
        ),
        (
            DIAMETER,
            'diameter = [{ value = "8 mm", mass_fraction = 0.3 }, '
            '{ value = "9 mm", mass_fraction = 0.6 }]',
            "particle.diameter",
            "0.9",
            "sum to 1",
        ),
        (
            DIAMETER,
            'diameter = [{ value = "8 mm", mass_fraction = 0.3 }, '
            '{ value = "8 mm", mass_fraction = 0.7 }]',
            "particle.diameter",
            "twice",
            "Add up",
        ),
        (
            DIAMETER,
            'diameter = [{ value = "8 mm" }]',
            "particle.diameter[0].mass_fraction",
            "missing",
            "mass_fraction = 0.3",
        ),
        (
            DIAMETER,
            'diameter = [{ value = "8 mm", mass_fraction = 0 }]',
            "particle.diameter[0].mass_fraction",
            "0",
            "above 0",
        ),
        # targets
        (
            TARGET,
            "targets.bulk_density = 1500",
            "test[0].targets.bulk_density",
            "1500",
            "{ value =",
        ),
        (TARGET, "targets.bulk_density = {}", ".bulk_density.value", "missing", "measure"),
        (TARGET, "targets.bulk_density.value = 0", ".bulk_density.value", "0", "above 0"),
        (TARGET, 'targets.bulk_density.value = "-3 kg/m^3"', ".value", "-3 kg/m^3", "above 0"),
        (TARGET, 'targets.bulk_density.value = "1 %"', ".value", "1 %", "kg/m^3"),
        (
            TARGET,
            'targets.bulk_density = { value = 1500, uncertainty = "0 %" }',
            ".uncertainty",
            "0 %",
            "above 0",
        ),
        (
            TARGET,
            'targets.bulk_density = { value = 1500, tolerance = "5 m" }',
            ".tolerance",
            "5 m",
            "kg/m^3",
        ),
        (TARGET, "targets.bulk_density = { value = 1500, weight = 0 }", ".weight", "0", "above 0"),
        (
            TARGET,
            "targets.bulk_density = { value = 1500, weight = 1e20 }",
            "bulk_density.weight",
            "1e+20",
            "1e+06",
        ),
        (
            TARGET,
            "targets.bulk_density = { value = 1500, uncertainty = 1e-12 }",
            "bulk_density.uncertainty",
            "the value is 1500",
            "exact",
        ),
        (
            TARGET,
            "targets.bulk_density.measurements = [1500, 1500.0000000001]",
            "bulk_density.measurements",
            "the value is 1500",
            "exact",
        ),
        (
            FRICTION,
            "rolling_friction = { min = 0.4, max = 0.4000000000000001 }",
            "rolling_friction",
            "almost equal",
            "Fix",
        ),
        (
            TARGET,
            'targets.bulk_density = { value = 1500, statistic = "mode" }',
            ".statistic",
            "mode",
            "median",
        ),
        (
            TARGET,
            "targets.angle_of_rest = { value = 20 }",
            "test[0].targets.angle_of_rest",
            "",
            '"angle_of_repose"',
        ),
        (TARGET, "targets.flow_rate = { value = 20 }", ".flow_rate", "", "bulk_density"),
        (TARGET, "targets.bulk_density.measurements = [1500]", ".measurements", "1", "at least 2"),
        (TARGET, "targets.bulk_density.measurements = [9, 9]", ".measurements", "9", "value and"),
        (
            TARGET,
            'targets.bulk_density.measurements = [9, "x"]',
            ".measurements[1]",
            "x",
            "kg/m^3",
        ),
        (
            TARGET,
            "targets.bulk_density = { measurements = [8, 9], uncertainty = 1 }",
            ".uncertainty",
            "beside measurements",
            "remove uncertainty",
        ),
        # geometry that the test refuses
        (SOLVER, SOLVER + '\nplate_radius = "1 mm"', "test[0].plate_radius", "0.001", "wider"),
        # strategy
        (ANGLE, ANGLE + "\n[strategy]\nmax_run = 3", "strategy.max_run", "", '"max_runs"'),
        (ANGLE, ANGLE + "\n[strategy]\nseed = -1", "strategy.seed", "-1", "at least 0"),
        (
            ANGLE,
            ANGLE + '\n[strategy]\nname = "staged"\nprefer = "accuracy"',
            "strategy.prefer",
            "no meaning",
            "sequential",
        ),
        (
            ANGLE,
            ANGLE + "\n[strategy]\nrayleigh_weight = 1",
            "strategy.rayleigh_weight",
            "no meaning",
            "staged",
        ),
        (
            ANGLE,
            ANGLE + '\n[strategy]\nextend_intervals = "yes"',
            "strategy.extend_intervals",
            "yes",
            "true",
        ),
        *(
            (
                ANGLE,
                ANGLE + f"\n[strategy]\nwanted_half_width = {value}",
                "strategy.wanted_half_width",
                value.strip('"'),
                'such as "25 %"',
            )
            for value in ('"0 %"', '"-5 %"', "3", '"abc"', '"25 kg"')
        ),
        (ANGLE, ANGLE + '\n[strategy]\nname = "stages"', "strategy.name", "stages", '"staged"'),
        (ANGLE, ANGLE + "\n[strategy]\nrayleigh_weight = nan", "weight", "nan", "finite"),
    ],
)
def test_one_fault_has_one_clear_message(
    faults_of: FaultsOf, old: str, new: str, key: str, value: str, remedy: str
) -> None:
    [fault] = faults_of((old, new))
    assert key in fault.key
    assert value in fault.message
    assert remedy in fault.remedy
    assert fault.line is not None or fault.key == "name"
    assert str(fault).isprintable()
    assert len(str(fault)) < 600


OWN_MODEL = """\
name = "own"
[parameters]
cohesion = { min = 1, max = 2 }
[[test]]
type = "python"
function = "model.py:simulate"
targets.angle = { value = 30 }
"""
FUNCTION = 'type = "python"\nfunction = "model.py:simulate"'
COMMAND = 'type = "command"\nfolder = "."\ncommand = ["true"]'


@pytest.mark.parametrize(
    ("old", "new", "key", "value", "remedy"),
    [
        ("{ min = 1, max = 2 }", "{ min = 2, max = 1 }", "parameters.cohesion", "2", "below"),
        ("{ min = 1,", '{ min = "1 J",', "parameters.cohesion.min", "1 J", "unit ="),
        ("max = 2 }", 'max = "2 m", unit = "J" }', "parameters.cohesion.max", "2 m", "J"),
        ("max = 2 }", 'max = "2 J", unit = "x^y" }', "parameters.cohesion.max", "2 J", "unit ="),
        ("cohesion", '"a b"', "parameters.'a b'", "a b", "letters"),
        ("cohesion", "particle", "parameters.particle", "particle", "another name"),
        ("cohesion", "particle_density", "parameters.particle_density", "", "another name"),
        ("cohesion", "seed", "parameters.seed", "seed", "another name"),
        ("30", '"30 deg"', "test[0].targets.angle.value", "30 deg", "unit ="),
        ("30", '"30 deg", unit = "m"', "test[0].targets.angle.value", "30 deg", "in m"),
        (".angle", '."an gle"', "test[0].targets.'an gle'", "an gle", "letters"),
        ("model.py:", "modell.py:", "test[0].function", "modell.py", "paths start at"),
        (":simulate", ":simulat", "test[0].function", "simulat", "simulate"),
        (":simulate", "", "test[0].function", "model.py", "model.py:simulate"),
        ("model.py", "broken.py", "test[0].function", "broken.py", ""),
        (
            FUNCTION,
            'type = "table"\nfile = "runs.csv"',
            "test[0].file",
            "runs.csv",
            "paths start at",
        ),
        (FUNCTION, 'type = "table"\nfile = "."', "test[0].file", "no such file", "paths start at"),
        (FUNCTION, 'type = "table"\nnearest = 1', "test[0].nearest", "1", "true or false"),
        (FUNCTION, FUNCTION + '\ntimeout = "1 s"', "test[0].timeout", "known key", "function"),
        (
            FUNCTION,
            COMMAND + '\nresponses = "r.json"\nevaluate = "model.py:simulate"',
            "test[0].responses",
            "together with evaluate",
            "Keep",
        ),
        (
            FUNCTION,
            COMMAND + '\nevaluate = "model.py:simulat"',
            "test[0].evaluate",
            "simulat",
            "simulate",
        ),
        (
            FUNCTION,
            COMMAND.replace('"."', '"model.py"') + '\nresponses = "r.json"',
            "test[0].folder",
            "no such folder",
            "paths start at",
        ),
        (
            FUNCTION,
            COMMAND.replace('["true"]', '"true"') + '\nresponses = "r.json"',
            "test[0].command",
            "true",
            "[...]",
        ),
    ],
)
def test_faults_of_own_models(
    faults_of: FaultsOf, tmp_path: Path, old: str, new: str, key: str, value: str, remedy: str
) -> None:
    (tmp_path / "model.py").write_text("def simulate(parameters, seed): ...", encoding="utf-8")
    (tmp_path / "broken.py").write_text("def simulate(parameters", encoding="utf-8")
    fault = faults_of((old, new), text=OWN_MODEL)[-1]
    assert key in fault.key
    assert value in fault.message
    assert remedy in fault.remedy


def test_own_parameters_need_a_test_that_uses_them(faults_of: FaultsOf) -> None:
    [fault] = faults_of(("[wall]", "[parameters]\ncohesion = { min = 1, max = 2 }\n[wall]"))
    assert fault.key == "parameters.cohesion"
    assert "no test" in fault.message


def test_every_fault_is_listed_in_the_order_of_the_file(faults_of: FaultsOf) -> None:
    faults = faults_of(
        (DIAMETER, 'diameter = "10 kg"'),
        (DENSITY, 'density = { min = "1 GPa", max = "2800 kg/m^3", scal = "log" }'),
        ("restitution = 0.82", ""),
        (SOLVER, 'solver = "edem"\nranks = -1'),
        (TARGET, "targets.bulk_density = { value = -1, uncertainty = -1 }"),
        (ANGLE, "targets.angle = { value = 22 }"),
    )
    keys = [fault.key for fault in faults]
    assert keys == [
        "particle.diameter",
        "particle.density.scal",
        "particle.density.min",
        "particle_wall.restitution",
        "test[0].solver",
        "test[0].ranks",
        "test[0].targets.bulk_density.value",
        "test[0].targets.bulk_density.uncertainty",
        "test[0].targets.angle",
    ]


TEXT_OF_MANY_LINES = """\
name = "x"

[particle]
diameter = [
    { value = "8 mm", mass_fraction = 0.5 },  # [ no bracket
    { value = "9 kg", mass_fraction = 0.5 },
]
[particle.density]
min = 1.0
# text in between
max = -1
[[test]]
type = "heap"
[[test]]
note = '''

type = "command"
'''
"type" = "tables"
"""


def test_the_line_of_the_key_is_told(faults_of: FaultsOf) -> None:
    lines = {fault.key: fault.line for fault in faults_of(text=TEXT_OF_MANY_LINES)}
    assert lines["particle.diameter[1].value"] == 6
    assert lines["particle.density.max"] == 11
    assert lines["test[0].targets"] == 12  # missing: the line of its table
    assert lines["test[1].type"] == 19


def test_nothing_to_find_is_a_fault(faults_of: FaultsOf) -> None:
    [fault] = faults_of((DENSITY, "density = 2100"), (FRICTION, "rolling_friction = 0.5"))
    assert "no free parameter" in fault.message
    assert "min" in fault.remedy


def test_a_faulty_interval_is_not_taken_for_a_fixed_value(faults_of: FaultsOf) -> None:
    faults = faults_of((DENSITY, "density = 2100"), (FRICTION, "rolling_friction = { min = 1 }"))
    assert [fault.key for fault in faults] == ["particle_particle.rolling_friction.max"]


def test_no_target_is_a_fault(faults_of: FaultsOf) -> None:
    [fault] = faults_of((TARGET, ""), (ANGLE, ""))
    assert fault.key == "test[0].targets"
    [fault] = faults_of((TARGET, "targets = {}"), (ANGLE, ""))
    assert fault.key == "test[0].targets"


def test_tests_need_names_of_their_own(faults_of: FaultsOf) -> None:
    second = '\n[[test]]\ntype = "heap"\nsolver = "liggghts"\ntargets.bulk_density.value = 1500\n'
    [fault] = faults_of((ANGLE, ANGLE + second))
    assert fault.key == "test[1].name"
    assert "heap" in fault.message


def test_a_heap_needs_a_material(faults_of: FaultsOf) -> None:
    test = '[[test]]\ntype = "heap"\nsolver = "lammps"\ntargets.bulk_density.value = 1\n'
    keys = {fault.key for fault in faults_of(text='name = "x"\n' + test)}
    assert {"particle", "wall", "particle_particle", "particle_wall"} <= keys


def test_keys_of_a_test_whose_header_is_missing_belong_in_a_test(faults_of: FaultsOf) -> None:
    found = {fault.key: fault.remedy for fault in faults_of(("[[test]]", ""))}
    for key in ("type", "solver", "targets"):
        assert found.pop(f"particle_wall.{key}") == "It belongs in [[test]]."
    for key in ("plate_sliding_friction", "plate_rolling_friction"):
        assert messages.MEANT.is_in(found.pop(f"particle_wall.{key}"))
    assert [*found] == ["test"]


@pytest.mark.parametrize(
    ("data", "message", "line"),
    [
        (b"", "missing", None),
        (b'name = "x"\n[particle\n', "brackets that do not match", 2),
        (b'name = "x"\nname = "y"\n', "gives name again", 2),
        (b'name = "x"\n# \xff\xfe\n', "not UTF-8", 2),
        (b'\xef\xbb\xbfname = "x"\n# \xff\xfe\n', "not UTF-8", 2),
        (b"\xff\xfen\x00", "not UTF-8", 1),
        (b"\x00\x01\x02", "not valid TOML", 1),
        (b"x = " + b"[" * 50_000, "nested", None),
        (b"x = " + b"9" * 5_000, "not valid TOML", None),
        (b"#" * 2_000_000, "1 MB", None),
    ],
)
def test_what_is_not_a_calibration_file_is_said(
    tmp_path: Path, data: bytes, message: str, line: int | None
) -> None:
    path = tmp_path / "calibration.toml"
    path.write_bytes(data)
    with pytest.raises(InputError, match=message) as caught:
        load_calibration_file(path)
    assert caught.value.source == str(path)
    if message != "missing":
        assert [fault.line for fault in caught.value.faults] == [line]


def test_a_folder_or_nothing_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="folder"):
        load_calibration_file(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        load_calibration_file(tmp_path / "missing.toml")
    with pytest.raises(InputError, match=r"no such file|cannot be read"):
        load_calibration_file("nul\0byte.toml")
    with pytest.raises(InputError, match=r"no such file|cannot be read"):
        load_calibration_file("x" * 5000)


def test_hostile_keys_and_values_are_shown_harmlessly(faults_of: FaultsOf) -> None:
    faults = faults_of(
        (DIAMETER, 'diameter = "\\u001b[2J"\n"\\u001b[31m" = 1'),
        (SOLVER, f'solver = "{"x" * 3000}"\n"{"y" * 3000}" = 1'),
    )
    faults += faults_of((TARGET, 'targets.bulk_density = "\\u001f"'))
    assert len(faults) == 5
    for fault in faults:
        assert str(fault).isprintable()
        assert len(str(fault)) < 600


CLUSTER = '[cluster]\nwalltime = "2 h"\n'
WALL = "\n[wall]\n"


@pytest.mark.parametrize(
    ("lines", "key", "value", "remedy"),
    [
        ("jobs = 2", "walltime", "missing", 'walltime = "2 h"'),
        ('walltime = "30 s"', "walltime", "30 s", "1 minute"),
        ('walltime = "2 kg"', "walltime", "2 kg", "10 min"),
        (f"{CLUSTER}jobs = 0", "jobs", "0", "from 1 to"),
        (f"{CLUSTER}runs_per_job = -1", "runs_per_job", "-1", "from 1 to"),
        (f'{CLUSTER}scheduler = "slrm"', "scheduler", "slrm", '"slurm"'),
        # what would become a directive, or a command, that nobody is shown
        (f'{CLUSTER}partition = "a\\n#SBATCH --uid=0"', "partition", "SBATCH", "one line"),
        (f'{CLUSTER}partition = "a --uid=0"', "partition", "a --uid=0", "letters"),
        (f'{CLUSTER}account = "$(reboot)"', "account", "reboot", "letters"),
        (f'{CLUSTER}options = ["--mem=4G\\nreboot"]', "options[0]", "reboot", "one line"),
        (f'{CLUSTER}options = ["reboot"]', "options", "reboot", "--mem=4G"),
        (f'{CLUSTER}setup = ["true\\nreboot"]', "setup[0]", "reboot", "one line"),
        # what grainfit decides itself
        (f'{CLUSTER}options = ["--time=9"]', "options", "--time=9", "walltime"),
        (f'{CLUSTER}options = ["--arr=1-9"]', "options", "--arr=1-9", "Remove it"),
        (f"{CLUSTER}runs_per_node = 1", "runs_per_node", "", "runs_per_job"),
        # a Parsl configuration of one's own
        ('parsl = "config"', "parsl", "config", "my_parsl.py:config"),
        ('parsl = "my_parsl.py:config"', "parsl", "my_parsl.py", "no such file"),
        ('parsl = "own.py:confg"', "parsl", "confg", "my_parsl.py:config"),
        ('parsl = "own.py:config"\nwalltime = "2 h"', "walltime", "beside parsl", "your Parsl"),
    ],
)
def test_faults_of_the_cluster(
    faults_of: FaultsOf, tmp_path: Path, lines: str, key: str, value: str, remedy: str
) -> None:
    (tmp_path / "own.py").write_text("config = 1\nraise SystemExit('executed')\n")
    table = lines if lines.startswith("[cluster]") else f"[cluster]\n{lines}"
    [fault] = faults_of((WALL, f"\n{table}\n{WALL}"))
    assert fault.key == f"cluster.{key}"
    assert value in fault.message
    assert remedy in f"{fault.message} {fault.remedy}"
    assert fault.line is not None


def test_all_faults_of_the_cluster_are_told_at_once(faults_of: FaultsOf) -> None:
    table = """
[cluster]
walltime = "2 parsec"
jobs = 0
partition = "a b"
options = ["--nodes=3"]
"""
    keys = {fault.key for fault in faults_of((WALL, f"{table}{WALL}"))}
    assert keys == {f"cluster.{key}" for key in ("walltime", "jobs", "partition", "options")}


def test_keys_of_the_cluster_are_sent_home(faults_of: FaultsOf) -> None:
    [fault] = faults_of((WALL, f"{WALL}walltime = 7200\n"))
    assert "[cluster]" in fault.remedy
