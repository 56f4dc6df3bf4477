"""Every check has a file that triggers it, and names a line of it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

import grainfit as gf
from grainfit.calibration_file.checks import messages
from grainfit.calibration_file.checks.registry import all_checks
from grainfit.calibration_file.plan import describe_plan
from grainfit.calibration_file.starter import starter_file
from grainfit.cli.app import app

ROOT = Path(__file__).parents[2]
BEADS = (ROOT / "examples" / "glass_beads" / "calibration.toml").read_text(encoding="utf-8")
THREE_TESTS = (ROOT / "examples" / "three_tests" / "calibration.toml").read_text(encoding="utf-8")
BLADE = (ROOT / "examples" / "blade" / "calibration.toml").read_text(encoding="utf-8")
REFERENCE = (ROOT / "docs" / "command_line.md").read_text(encoding="utf-8")

TYPE = 'type = "heap"'
PACKING = (
    '[[test]]\ntype = "packing"\nsolver = "liggghts"\ntargets.bulk_density = { value = 1500 }\n'
)
DISCHARGE = (
    '[[test]]\ntype = "discharge"\nsolver = "lammps"\nslot_width = "15 mm"\n'
    "targets.mass_flow = { value = 1 }\n"
)
HUGE = (
    'cylinder_radius = "200 mm"\nplate_radius = "700 mm"\n'
    'strike_off_height = "400 mm"\nlift_height = "500 mm"'
)
STIFF = ('youngs_modulus = "0.36 MPa"', 'youngs_modulus = "100 MPa"')
RESTITUTION = "restitution = 0.79"
DIAMETER = 'diameter = "10 mm"'
CLASSES = (
    'diameter = [{ value = "10 mm", mass_fraction = 0.001 },'
    ' { value = "8 mm", mass_fraction = 0.999 }]'
)
#: A column that begins below its gate; the force on the gate is recorded at once.
GATE = """
from grainfit.scenes import *

def scene(material, sizes, seed, gravity, time_step):
    particles = random_column(sizes, 20, Round(0.05), seed)
    top = particles.height + 0.01
    fill = Stage("fill", AtRest(1.0), series=Series({"load": Force("gate", "z")}, every=0.01))
    return Scene(
        title="gate", material=material, sizes=sizes, particles=particles,
        box=Box((-0.1, -0.1, -0.1), (0.1, 0.1, 2 * top)),
        walls={"gate": Wall(Plane("z", top, upwards=False))}, stages=(fill,),
        gravity=gravity, time_step=time_step, quiet_speed=0.01, check_interval=0.01,
    )
"""
#: Two tests on the output of the same command, and on the same function.
COMMANDS, FUNCTIONS = (
    'name = "sand"\n[parameters]\nfriction = { min = 0.1, max = 0.9 }\n'
    + "".join(
        f'[[test]]\nname = "{name}"\n{model}\ntargets.{name} = {{ value = 1 }}\n'
        for name, model in (("angle", first), ("flow", second))
    )
    for first, second in [
        [
            'type = "command"\nfolder = "model"\ncommand = ["sh", "drum.sh", "{{ friction }}"]\n'
            f'evaluate = "measure.py:{name}"'
            for name in ("angle", "flow")
        ],
        ['type = "python"\nfunction = "measure.py:angle"\nparameters = ["friction"]'] * 2,
    ]
)


GLASS_WALL = """
[wall.glass]
youngs_modulus = "50 GPa"
poissons_ratio = 0.2
density = "2500 kg/m^3"
[particle_wall.glass]
sliding_friction = 0.3
rolling_friction = 0.05
restitution = 0.8
rolling_damping = 0
"""


def changed(*changes: tuple[str, str], text: str = BEADS) -> str:
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def heap(lines: str) -> str:
    return changed((TYPE, f"{TYPE}\n{lines}"))


#: By check: its severity, a file that triggers it, and the line that it names, as that begins.
CASES = {
    "too-few-targets": (
        "note",
        changed((RESTITUTION, "restitution = { min = 0.5, max = 0.9 }")),
        "",
    ),
    "open-parameters": (
        "note",
        changed((RESTITUTION, "restitution = { min = 0.5, max = 0.9 }")),
        "",
    ),
    "further-response": ("note", THREE_TESTS, ""),
    "mpi-ranks": ("warning", heap("ranks = 4096"), ""),
    "more-ranks": ("note", f"{BEADS}\n[strategy]\nworkers = 1\n", ""),
    "soft-particles": ("note", BEADS, "youngs_modulus = "),
    "solvers-differ": ("warning", f"{BEADS}\n{PACKING}", ""),
    "large-time-step": ("warning", heap("time_step_fraction = 0.3"), "time_step_fraction = "),
    "long-runs": ("note", changed((TYPE, f"{TYPE}\n{HUGE}"), STIFF), "[[test]]"),
    "shared-simulation": ("note", COMMANDS, "[[test]]"),
    "repeated-simulation": ("note", FUNCTIONS, "[[test]]"),
    "few-particles": ("warning", changed((DIAMETER, CLASSES)), "diameter = "),
    "assumed-size": ("warning", starter_file(["drum"]), "[[test]]"),
    "near-spheres": (
        "note",
        changed((DIAMETER, f'{DIAMETER}\nshape = "two_spheres"\naspect_ratio = 1.05')),
        "aspect_ratio = ",
    ),
    "impossible-bulk-density": (
        "warning",
        changed(('max = "2793 kg/m^3"', 'max = "1700 kg/m^3"')),
        "targets.bulk_density = ",
    ),
    "surplus-particles": ("note", heap("particle_count = 40000"), "particle_count = "),
    "small-plate": (
        "warning",
        heap('plate_radius = "65 mm"\ntargets.heap_height = { value = "53 mm" }'),
        "plate_radius = ",
    ),
    "base-of-disc": (
        "warning",
        heap('base = "disc"\ntargets.base_radius = { value = "130 mm" }'),
        "targets.base_radius = ",
    ),
    "smooth-plate": (
        "warning",
        changed(("plate_sliding_friction = 0.5", "plate_sliding_friction = 0.1")),
        "plate_sliding_friction = ",
    ),
    "assumed-plate": (
        "warning",
        changed(("plate_sliding_friction = 0.5", "# ")),
        "[[test]]",
    ),
    "narrow-cylinder": (
        "warning",
        heap('cylinder_radius = "45 mm"'),
        "cylinder_radius = ",
    ),
    "fast-lift": ("warning", heap('lift_speed = "0.2 m/s"'), "lift_speed = "),
    "funnel-in-heap": (
        "warning",
        starter_file(["funnel"]).replace(
            'type = "funnel"', 'type = "funnel"\nfunnel_height = "40 mm"\nraise_speed = 0'
        ),
        "funnel_height",
    ),
    "flow-depth": ("warning", f"{BEADS}\n{DISCHARGE}", "targets.mass_flow = "),
    "unusual-flow": (
        "warning",
        f"{BEADS}\n{DISCHARGE}".replace("{ value = 1 }", "{ value = 1000 }"),
        "targets.mass_flow = ",
    ),
    "fast-drum": (
        "warning",
        starter_file(["drum"]).replace('type = "drum"', 'type = "drum"\nfroude_number = 0.05'),
        "froude_number",
    ),
    "soft-drum": (
        "note",
        starter_file(["drum"]).replace('youngs_modulus = "10 MPa"', 'youngs_modulus = "0.4 MPa"'),
        "[[test]]",
    ),
    "few-taps": ("warning", starter_file(["tapped"]), "[[test]]"),
    "fast-compression": (
        "warning",
        starter_file(["triaxial"]).replace(
            'type = "triaxial"', 'type = "triaxial"\ninertial_number = 0.01'
        ),
        "inertial_number",
    ),
    "short-compression": (
        "warning",
        starter_file(["triaxial"]).replace(
            'type = "triaxial"', 'type = "triaxial"\naxial_strain = 0.2'
        ),
        "axial_strain",
    ),
    "no-end-caps": (
        "warning",
        starter_file(["drum"]).replace('type = "drum"', 'type = "drum"\nwalls = { caps = "glass" }')
        + GLASS_WALL,
        "[[test]]",
    ),
    "coarse-caps": (
        "note",
        starter_file(["drum"])
        .replace('type = "drum"', 'type = "drum"\nend_caps = true')
        .replace('diameter = "10 mm"', 'diameter = "10 mm"\ncoarse_graining = 1.25'),
        "end_caps",
    ),
    "fast-shear": ("note", starter_file(["shear"]), "[[test]]"),
    "no-cohesion": ("warning", starter_file(["shear_cell"]), "targets.ffc = "),
    "preshear-stress": (
        "warning",
        starter_file(["shear_cell"]).replace('stress = "500 Pa"', 'stress = "5 kPa"'),
        "targets.major_consolidation_stress = ",
    ),
    "unusual-value": (
        "warning",
        changed(('value = "22 deg"', "value = 0.38")),
        "targets.angle_of_repose = ",
    ),
    "narrow-orifice": ("warning", f"{BEADS}\n{DISCHARGE}", "slot_width = "),
    "smooth-walls": (
        "warning",
        changed(
            ("rolling_friction = 0.05 ", "rolling_friction = 0.005 "),
            text=starter_file(["draw_down"]),
        ),
        "rolling_friction = 0.005",
    ),
    "coarse-grained-scene": (
        "note",
        changed((DIAMETER, f"{DIAMETER}\ncoarse_graining = 2"), text=BLADE),
        "scene = ",
    ),
    "particles-not-held": (
        "warning",
        changed(("blade.py:scene", "gate.py:scene"), text=BLADE),
        "scene = ",
    ),
    "forces-after-fill": (
        "note",
        changed(("blade.py:scene", "gate.py:scene"), text=BLADE),
        "scene = ",
    ),
    "finer-than-instruments": (
        "warning",
        changed(('uncertainty = "1 %"', "uncertainty = 1")),
        "targets.bulk_density = ",
    ),
    "fine-tolerance": (
        "note",
        changed(('uncertainty = "1 %"', "uncertainty = 1")),
        "targets.bulk_density = ",
    ),
    "short-timeout": ("warning", heap('timeout = "1 s"'), "timeout = "),
    "long-calibration": ("note", changed((TYPE, f"{TYPE}\n{HUGE}"), STIFF), ""),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Folder of a calibration file with the models of all tests."""
    shutil.copy(ROOT / "examples" / "blade" / "blade.py", tmp_path)
    (tmp_path / "gate.py").write_text(GATE)
    (tmp_path / "model").mkdir()
    code = "def angle(*given):\n    return {}\n\n\ndef flow(*given):\n    return {}\n"
    for place in (tmp_path, tmp_path / "model"):
        (place / "measure.py").write_text(code)
        (place / "drum.sh").write_text("true\n")
    return tmp_path


def test_every_registered_check_is_tested_here() -> None:
    # Those of pictures and videos are tested with these: test_photos_in_file.py, test_drums.py.
    assert {*CASES, "changed-picture", "other-speed"} == {check.name for check in all_checks()}


@pytest.mark.parametrize("name", CASES)
def test_a_check_names_itself_its_severity_and_a_line(folder: Path, name: str) -> None:
    severity, text, line = CASES[name]
    path = folder / "calibration.toml"
    path.write_text(text, encoding="utf-8")

    findings = describe_plan(gf.load(path)).findings

    found = next(finding for finding in findings if finding.check == name)
    assert found.severity == severity
    assert "\n" not in found.text
    lines = ["", *text.splitlines()]
    assert lines[found.line or 0].startswith(line)
    assert bool(line) == (found.line is not None)


@pytest.mark.parametrize(
    ("before", "after", "is_found"),
    [
        ("sliding_friction = 0.18", "sliding_friction = 8", True),
        ("sliding_friction = 0.27", "sliding_friction = 8", True),
        ("sliding_friction = 0.27", 'sliding_friction = {{ measured_angle = "60 deg" }}', False),
        ("sliding_friction = 0.27", "sliding_friction = 1.2", False),
        ("sliding_friction = 0.27", "sliding_friction = {{ min = 8, max = 9 }}", True),
        ("sliding_friction = 0.27", "sliding_friction = {{ min = 0.1, max = 9 }}", False),
        ("plate_sliding_friction = 0.5 ", "plate_sliding_friction = 8 ", True),
        ("plate_sliding_friction = 0.5 ", 'plate_sliding_friction = "particle_particle" ', False),
    ],
)
def test_a_friction_that_may_be_an_angle_is_told(
    folder: Path, before: str, after: str, is_found: bool
) -> None:
    path = folder / "calibration.toml"
    assert before in starter_file()
    path.write_text(starter_file().replace(before, after.format()), encoding="utf-8")

    said = " ".join(one.text for one in describe_plan(gf.load(path)).findings)

    assert messages.LARGE_FRICTION.is_in(said) is is_found


def test_json_lists_what_the_terminal_shows(folder: Path) -> None:
    path = folder / "calibration.toml"
    path.write_text(heap('timeout = "1 s"\nparticle_count = 40000'), encoding="utf-8")
    shown = CliRunner().invoke(app, ["check", str(path)])
    document = json.loads(CliRunner().invoke(app, ["check", str(path), "--json"]).output)

    findings = document["findings"]
    assert [finding["check"] for finding in findings] == [
        "soft-particles",
        "assumed-size",
        "surplus-particles",
        "short-timeout",
    ]
    assert findings[2]["key"] == "test[0].particle_count"
    assert [finding["text"] for finding in findings] == document["notes"]
    flat = " ".join(shown.output.split())
    places = [flat.index(finding["text"]) for finding in findings]
    assert places == sorted(places)


def test_the_documentation_lists_all_checks() -> None:
    for check in all_checks():
        row = f"| `{check.name}` | {check.severity} | {check.about} |"
        assert row in REFERENCE, row


def said_of_ranks(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    cores: int,
    text: str,
    check: str = "mpi-ranks",
) -> str:
    monkeypatch.setattr("os.sched_getaffinity", lambda _pid: set(range(cores)))
    (folder / "calibration.toml").write_text(text, encoding="utf-8")
    plan = describe_plan(gf.load(folder / "calibration.toml"))
    return " ".join(f.text for f in plan.findings if f.check == check)


def test_ranks_are_weighed_against_runs_at_a_time(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = said_of_ranks(folder, monkeypatch, 8, heap("ranks = 4"))
    assert said.startswith("With 4 MPI ranks a run and 2 runs at a time, the calibration takes ")
    assert "with ranks = 1 and 8 runs at a time, about " in said
    workers = heap("ranks = 2") + "\n[strategy]\nworkers = 4\n"
    assert said_of_ranks(folder, monkeypatch, 6, workers).startswith(
        "4 runs at a time with 2 MPI ranks each take 8 cores, and there are 6: "
    )
    assert said_of_ranks(folder, monkeypatch, 8, BEADS) == ""


def test_ranks_are_offered_where_a_calibration_leaves_cores_idle(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one_at_a_time = BEADS + "\n[strategy]\nworkers = 1\n"
    said = said_of_ranks(folder, monkeypatch, 4, one_at_a_time, "more-ranks")

    assert messages.RANKS_PAY.is_in(said, ranks=4, runs="1 run")
    assert said_of_ranks(folder, monkeypatch, 4, BEADS, "more-ranks") == ""
    yade = one_at_a_time.replace('solver = "lammps"', 'solver = "yade"')
    yade = yade.replace("rolling_damping = 0.25", "rolling_damping = 0")
    assert said_of_ranks(folder, monkeypatch, 4, yade, "more-ranks") == ""
