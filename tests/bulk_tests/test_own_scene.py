"""A scene of the user: identity, errors by his own lines, runs in real solvers, and records."""

from __future__ import annotations

import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import needs
from grainfit.bulk_tests import messages as of_bulk_tests
from grainfit.bulk_tests.apparatus import apparatus_of
from grainfit.bulk_tests.checks import CheckedTest
from grainfit.bulk_tests.own_scene import OwnScene, user_function
from grainfit.bulk_tests.own_scene import messages as of_own_scene
from grainfit.bulk_tests.registry import recreate_test
from grainfit.bulk_tests.workload import workload
from grainfit.calibration_file.build import load_calibration
from grainfit.calibration_file.plan import describe_plan
from grainfit.campaign.batch import run_folders, simulate_batch
from grainfit.campaign.campaign import CampaignOptions
from grainfit.cards import material_card
from grainfit.checks import Finding
from grainfit.cli import messages as of_cli
from grainfit.contact_models.hertz_mindlin.model import hertz_overlap, particle_moduli
from grainfit.errors import InputError, NotMeasurableError, RunFailedError
from grainfit.evaluation import Proposal
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.report.page import write_report
from grainfit.run_definition import RunDefinition
from grainfit.scenes import messages as of_scenes
from grainfit.scenes.run_output import RunOutput
from grainfit.solvers.base import Workspace
from grainfit.solvers.dem import messages as dem_messages
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import GLASS_BEADS
from grainfit.work_folder import messages as of_work_folder
from grainfit.work_folder.remeasure import measure_path
from grainfit.work_folder.saved_calibration import SavedCalibration
from grainfit.work_folder.solvers_of_runs import solvers_of

CODE = """
import numpy as np
from grainfit.scenes import AtRest, Box, Column, Elapsed, Plane, Scene, Stage, Wall
from grainfit.scenes import Annulus, Block, Cylinder, Disc, Frames, Glued, Mesh, Velocity

def scene(material, sizes, seed, gravity, time_step, options):
    d = sizes.sauter_diameter
    places = np.array([[2 * d * i, 0.0, 0.6 * d + options.get("drop", 0.0)] for i in range(3)])
    return Scene(
        title="Three beads on a floor",
        material=material,
        sizes=sizes,
        particles=Column(places, np.zeros(3, dtype=int), d),
        box=Box((-d, -d, -d), (6 * d, d, 4 * d)),
        walls={"floor": Wall(Plane("z", 0.0))},
        stages=(Stage("settle", AtRest(limit=5.0, at_least=0.1), is_closed=True),),
        gravity=gravity,
        time_step=time_step,
        quiet_speed=1e-5,
        check_interval=0.01,
    )

def measure(run, sizes):
    heights = run.snapshot("end").positions[:, 2]
    return {"height": heights.mean(), "spread": (np.ptp(heights), 0.0)}
"""
GLUED = "gravity=gravity, glued={{'plate': Glued(np.array([[0.0, 0.0, {}]], float), np.array({}))}}"
FILE = """
name = "beads"
particle = { diameter = "10 mm", youngs_modulus = 1e6, poissons_ratio = 0.25, density = 2500 }
wall = { youngs_modulus = 2e11, poissons_ratio = 0.3, density = 7700 }
[particle_particle]
sliding_friction = 0.5
rolling_friction = 0.1
restitution = 0.3
rolling_damping = 0.25
[particle_wall]
sliding_friction = { min = 0.1, max = 0.6 }
rolling_friction = 0.1
restitution = 0.3
rolling_damping = 0.25
[[test]]
type = "scene"
solver = "SOLVER"
scene = "beads.py:scene"
measure = "beads.py:measure"
targets.height = { value = 4.975, uncertainty = 0.01, unit = "mm" }
"""


@pytest.fixture
def beads(tmp_path: Path) -> Path:
    (tmp_path / "beads.py").write_text(CODE)
    return tmp_path / "beads.py"


def make(path: Path, **options: Any) -> OwnScene:
    functions = {"scene": f"{path}:scene", "measure": f"{path}:measure"}
    return OwnScene(diameter="10 mm", **{**functions, **options})


def changed(path: Path, old: str, new: str) -> OwnScene:
    assert old in CODE
    path.write_text(CODE.replace(old, new))
    return make(path)


def installed(solver: str) -> Any:
    if solver != "lammps" and shutil.which(solver) is None:
        pytest.skip(f"{solver} is not installed")
    return DEM_PROGRAMS[solver]


@pytest.mark.parametrize("solver", ["lammps", "liggghts"])
def test_a_scene_runs_in_every_solver_and_is_measured(
    beads: Path, tmp_path: Path, solver: str
) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    program = installed(solver)(make(beads), GLASS_BEADS)

    responses = program.run({}, 1, Workspace(folder, timeout=60.0))

    material = program.run_parameters({})
    mass = material["particle.density"] * np.pi / 6 * 0.01**3
    overlap = hertz_overlap(9.81 * mass, particle_moduli(material, "wall"), 0.005)
    assert responses["height"].value == pytest.approx(0.005 - overlap, abs=0.02 * overlap)
    assert (folder / "particles.png").read_bytes().startswith(b"\x89PNG")


def test_the_identity_is_the_contents_of_the_files_and_the_options(
    beads: Path, tmp_path: Path
) -> None:
    extra, elsewhere = tmp_path / "extra.txt", tmp_path / "elsewhere" / "beads.py"
    extra.write_text("1")
    elsewhere.parent.mkdir()
    shutil.copy(beads, elsewhere)
    first = make(beads, files=[extra]).definition()

    assert make(elsewhere).definition() == make(beads).definition()
    assert make(beads, options={"drop": "1 mm"}).definition()["options"] == {"drop": 0.001}
    assert make(beads).definition() != make(beads, options={"drop": "1 mm"}).definition()
    extra.write_text("2")
    assert make(beads, files=[extra]).definition() != first
    assert changed(beads, "0.6 * d", "0.7 * d").definition() != make(elsewhere).definition()


def test_a_record_has_all_but_the_functions(beads: Path) -> None:
    recorded = make(beads, options={"drop": 0.001, "note": "soft", "dry": True}).definition()

    again = recreate_test(RunDefinition({"test": recorded}, {}, 1))

    assert isinstance(again, OwnScene)
    assert again.definition() == recorded
    assert apparatus_of(again) == ()
    for key in recorded:
        if key not in ("type", "revision", "scenes"):
            damaged = {name: value for name, value in recorded.items() if name != key}
            with pytest.raises(InputError, match=of_bulk_tests.DAMAGED_DEFINITION.pattern):
                recreate_test(RunDefinition({"test": damaged}, {}, 1))


def test_a_process_elsewhere_has_the_contents_that_were_hashed(beads: Path) -> None:
    test = make(beads)
    sent = pickle.dumps(test)
    beads.write_text("raise SystemExit('other code')")

    arrived = pickle.loads(sent)

    assert arrived.definition() == test.definition()
    assert len(arrived.scene(GLASS_BEADS, 1).particles.positions) == 3


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("    d = sizes.sauter", "    1 / 0\n    d = sizes.sauter", "line 7: ZeroDivisionError"),
        ("import numpy as np", "import nump as np", "line 2: ModuleNotFoundError"),
        ("    d = sizes.sauter", "    exit(3)\n    d = sizes.sauter", "line 7: SystemExit: 3"),
        (
            "def measure",
            "scene = (lambda build: lambda colour: build)(scene)\n\ndef measure",
            "takes colour; it can take material, sizes",
        ),
        ("    return Scene(", "    return dict(", "gave dict, not a Scene"),
        ('Plane("z", 0.0)', 'Plane("w", 0.0)', "wall floor: has the axis 'w'"),
        ('"settle", ', '"set tle", ', "'set tle' is not one word"),
        ("gravity=gravity", "gravity=1.62", "is 1.62 m/s^2 in the scene and 9.81 in the test"),
        ("time_step=time_step", "time_step=2*time_step", "Take time_step as an argument"),
        ("check_interval=0.01", "check_interval=0", "check_interval: is 0. Give a number above 0"),
        ("(6 * d, d, 4 * d)", "(3 * d, d, 4 * d)", "1 of 3 begin outside of the box"),
        ("[2 * d * i", "[0.5 * d * i", "2 pairs overlap at the beginning"),
        ("np.zeros(3, dtype=int)", "np.full(3, 1)", "size_indices go from 1 to 1"),
        (
            "(6 * d, d, 4 * d))",
            '(6 * d, d / 2, 4 * d), "y")',
            "repeats along y every 0.015 m, which",
        ),
        ("time_step=time_step", 'time_step="1 ms"', "has a value of a wrong type"),
        ('Wall(Plane("z", 0.0))', "None", "has a value of a wrong type: 'NoneType'"),
        ("AtRest(limit=5.0, at_least=0.1)", "Elapsed(0.0)", "has the time 0.0"),
        ('"settle", ', '"settle", snapshot="bed", until=', "leaves the snapshot 'bed'"),
        ('Wall(Plane("z", 0.0))', 'Wall(Plane("z", 0.0), "glass")', "surface 'glass'"),
        (", is_closed=True),)", "),) * 2", "'settle' is there twice"),
        (
            "is_closed=True),)",
            'is_closed=True), Stage("second", AtRest(1.0), strike_off=0.1))',
            "stage second: ends at rest: a bed that is at rest",
        ),
        ('Wall(Plane("z", 0.0))', 'Wall(Mesh("floor.stl"))', 'Write files = ["floor.stl"]'),
        ('Wall(Plane("z", 0.0))', "Wall(Cylinder(0.1, 2.0, 1.0))", "bottom is below top"),
        (", is_closed=True),)", ', frames=Frames("film", 0.0)),)', "has frames every 0.0 s"),
        (
            "is_closed=True),)",
            'motions={"floor": Velocity("z", float("nan"))}),)',
            "moves floor by Velocity(along='z', speed=nan). Give finite numbers",
        ),
        ("gravity=gravity", GLUED.format(0, "[2]"), "glued plate: size_indices go from 2 to 2"),
        ("gravity=gravity", GLUED.format("np.nan", "[0]"), "positions that are no numbers"),
        ("gravity=gravity", GLUED.format(9, "[0]"), "begins outside of the box with 1 particles"),
        ('Wall(Plane("z", 0.0))', "Wall(Disc(0.0, 0.0))", "has no radius above 0"),
        ('Wall(Plane("z", 0.0))', "Wall(Block((0, 0, 0), (1, 0, 1)))", "low is below high"),
    ],
)
def test_a_fault_of_the_scene_has_file_and_line_and_no_line_of_grainfit(
    beads: Path, old: str, new: str, words: str
) -> None:
    test = changed(beads, old, new)

    with pytest.raises(RunFailedError) as caught:
        test.scene(GLASS_BEADS, 1)

    assert words in caught.value.reason
    assert "beads.py" in caught.value.reason
    assert "grainfit/bulk_tests" not in caught.value.log_tail
    with pytest.raises(InputError, match=r"^scene: "):
        workload(test, GLASS_BEADS)


def finished(beads: Path, folder: Path) -> OwnScene:
    test = make(beads)
    folder.mkdir()
    DEM_PROGRAMS["lammps"](test, GLASS_BEADS).run({}, 1, Workspace(folder, timeout=60.0))
    return test


def test_a_fault_of_the_measurement_has_its_line_and_a_restless_run_is_none(
    beads: Path, tmp_path: Path
) -> None:
    test = finished(beads, tmp_path / "run")
    run = RunOutput(tmp_path / "run")

    with pytest.raises(NotMeasurableError) as missing:
        run.snapshot("ende")
    assert of_scenes.NO_OUTPUT.is_in(str(missing.value), name="ende", known="end")
    for old, new, words in [
        ("    heights = ", "    run.series('push')\n    heights = ", "beads.py, line 24: "),
        ("heights.mean()", "float('nan')", "response height from measure() in beads.py is nan"),
        ("return {", "return 3, {", "gave (3, {"),
    ]:
        with pytest.raises(RunFailedError) as caught:
            changed(beads, old, new).measure(run)
        assert words in caught.value.reason
    with pytest.raises(RunFailedError, match="no response force; there are: height, spread"):
        test.with_targets(["force"]).measure(run)
    stages = tmp_path / "run" / "stages.csv"
    good = stages.read_text()
    stages.write_text(good.replace("at_rest", "restless"))
    with pytest.raises(RunFailedError, match=of_scenes.RESTLESS.matching(stage="settle")):
        test.measure(RunOutput(tmp_path / "run"))
    stages.write_text(good)
    (tmp_path / "run" / "snapshots" / "end.dump").unlink()
    with pytest.raises(RunFailedError, match=of_scenes.ENDED_EARLY.matching(stages="settle")):
        test.measure(RunOutput(tmp_path / "run"))


def test_a_function_that_does_not_return_fails_the_run(
    beads: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    beads.write_text("import time\ndef scene(seed):\n    time.sleep(5)\ndef measure(run): pass\n")
    monkeypatch.setattr(user_function.call, "__defaults__", (0.05,))

    with pytest.raises(
        RunFailedError, match=of_own_scene.DID_NOT_RETURN.matching(limit=0.05)
    ) as caught:
        make(beads).scene(GLASS_BEADS, 1)

    assert caught.value.kind == "timeout"


def test_a_file_is_checked_and_simulated_and_a_known_run_is_not_repeated(
    beads: Path, tmp_path: Path
) -> None:
    path = tmp_path / "beads.toml"
    path.write_text(FILE.replace("SOLVER", "lammps"))
    setup = load_calibration(path)

    plan = describe_plan(setup)

    assert plan.problems == ()
    assert any(f"{beads}:scene" in line for line in plan.executes)
    assert any("3 particles" in line for line in plan.lines)
    proposal, work = Proposal(setup.values([]), 1, "design"), tmp_path / "work"
    [once] = simulate_batch(setup.solvers, [proposal], work, CampaignOptions(1))
    folders = run_folders(setup.solvers, once, work)
    assert once.responses["height"].value == pytest.approx(0.004975, abs=2e-6)
    [again] = simulate_batch(setup.solvers, [proposal], work, CampaignOptions(1))
    assert again.reused == 1
    assert again.responses == once.responses
    # Measured again by the copy that was kept with the run, not by a file that has changed since.
    beads.write_text(CODE.replace("heights.mean()", "1.0"))
    measured = measure_path(folders["scene"])
    assert measured["height"].value == once.responses["height"].value
    copy = folders["scene"] / "functions" / "beads.py"
    copy.write_text("def measure(run): return {'height': 1.0}")
    with pytest.raises(NotMeasurableError, match=of_own_scene.FUNCTION_CHANGED.pattern):
        measure_path(folders["scene"])


def test_problems_of_a_scene_stop_a_calibration_before_its_first_run(
    beads: Path, tmp_path: Path
) -> None:
    path = tmp_path / "beads.toml"
    path.write_text(FILE.replace("SOLVER", "lammps"))
    beads.write_text(CODE.replace("AtRest(limit=5.0, at_least=0.1)", "AtRst()"))

    assert describe_plan(load_calibration(path), call_scenes=False).problems == ()
    (problem,) = describe_plan(load_calibration(path)).problems
    assert "beads.py, line 16: NameError: name 'AtRst' is not defined" in problem
    with pytest.raises(InputError, match=r"beads\.py, line 16"):
        load_calibration(path).calibrate(tmp_path / "work")


@pytest.mark.parametrize("options", [[], ["--json"]])
def test_a_scene_that_needs_more_memory_than_there_is_is_said(
    beads: Path, tmp_path: Path, options: list[str]
) -> None:
    path = tmp_path / "beads.toml"
    path.write_text(FILE.replace("SOLVER", "lammps"))
    beads.write_text(
        CODE.replace("    d = sizes.sauter", "    np.empty(10**18)\n    d = sizes.sauter")
    )

    command = [sys.executable, "-m", "grainfit", "check", str(path), *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)

    assert done.returncode == 1
    shown = " ".join((done.stdout + done.stderr).split())
    assert of_cli.NO_MEMORY.is_in(shown)
    assert "left: unable to allocate" in shown
    assert "Traceback" not in done.stderr


def test_two_scenes_are_loaded_without_executing_anything(beads: Path, tmp_path: Path) -> None:
    path = tmp_path / "beads.toml"
    content = FILE.replace("SOLVER", "lammps")
    test = content[content.index("[[test]]") :]
    path.write_text(content + 'name = "one"\n' + test + 'name = "two"\n')
    executed = tmp_path / "executed"
    beads.write_text(CODE + f"\nopen({str(executed)!r}, 'w').close()\n")

    setup = load_calibration(path)

    assert [scope.seconds for scope in setup.problem.tests] == [None, None]
    assert describe_plan(setup, call_scenes=False).problems == ()
    assert not executed.exists()


def test_enlarged_particles_are_noted_with_what_keeps_the_apparatus(beads: Path) -> None:
    real = ParticleSizes((0.01,))
    functions = {"scene": f"{beads}:scene", "measure": f"{beads}:measure"}

    def findings(test: OwnScene) -> list[Finding]:
        checked = CheckedTest(test, {}, {}, {})
        return [finding for check in test.checks for finding in check(checked)]

    [found] = findings(OwnScene(real.coarse_grained(2), **functions))

    assert of_own_scene.MAY_BE_ENLARGED.is_in(found.text, file="beads.py")
    assert not findings(OwnScene(real, **functions))


@needs.YADE
def test_a_concept_that_the_solver_lacks_is_refused_with_what_to_use(
    beads: Path, tmp_path: Path
) -> None:
    beads.write_text(CODE.replace('Plane("z", 0.0)', "Annulus(0.001, 0.1, 0.0)"))
    path = tmp_path / "beads.toml"
    path.write_text(FILE.replace("SOLVER", "yade").replace("damping = 0.25", "damping = 0.0"))

    (problem,) = describe_plan(load_calibration(path)).problems

    assert dem_messages.LACKS_CONCEPT.is_in(problem)
    assert "use a slot, a cone, or" in problem


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("beads.py:scene", "sand.py:scene", "there is no such file"),
        ("beads.py:scene", "beads.py:build", "has no function 'build'. It defines: scene"),
        ('measure = "beads.py:measure"', "", "measure: is missing"),
        ('targets.height = { value = 4.975, uncertainty = 0.01, unit = "mm" }', "", "targets"),
        ('solver = "SOLVER"', 'solver = "lammps"\noptions = { a = [1] }', "a number, a text, true"),
        ('solver = "SOLVER"', 'solver = "lammps"\nfiles = ["no.stl"]', "there is no such file"),
        ("particle = {", "particles = {", '"particle"'),
    ],
)
def test_a_faulty_file_is_refused_without_executing_anything(
    beads: Path, tmp_path: Path, old: str, new: str, words: str
) -> None:
    beads.write_text(CODE + "\nraise SystemExit('executed')\n")
    path = tmp_path / "beads.toml"
    assert old in FILE
    path.write_text(FILE.replace(old, new).replace("SOLVER", "lammps"))

    with pytest.raises(InputError) as caught:
        load_calibration(path)

    assert words in str(caught.value)
    assert "executed" not in str(caught.value)


@pytest.mark.parametrize("options", ["{ a = [1] }", "{ a = nan, b = 1 }", '{ "a b" = 1 }', "[1]"])
def test_a_faulty_option_is_one_fault(beads: Path, tmp_path: Path, options: str) -> None:
    path = tmp_path / "beads.toml"
    path.write_text(FILE.replace('"SOLVER"', f'"lammps"\noptions = {options}'))

    with pytest.raises(InputError) as caught:
        load_calibration(path)

    [fault] = caught.value.faults
    assert fault.key.startswith("test[0].options")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "def measure(run, sizes)",
            "def measure(run, foo)",
            "measure: .* takes foo. It can take run",
        ),
        ("def measure(run, sizes)", "def measure(run, *, foo, bar=1)", "measure: .* takes foo. "),
        (
            "def measure(run, sizes)",
            "def measure(run, /, sizes)",
            "measure: .* takes run by position only. ",
        ),
        ("(material, sizes, seed,", "(material, size, seed,", "scene: .* takes size. .*, sizes, "),
        ("heights = ", "heights = = ", "measure: is 'beads.py:measure': line 24 is not valid"),
    ],
)
def test_a_function_that_cannot_be_called_is_refused_before_any_run(
    beads: Path, tmp_path: Path, old: str, new: str, words: str
) -> None:
    assert old in CODE
    beads.write_text(CODE.replace(old, new) + "\nraise SystemExit('executed')\n")
    path = tmp_path / "beads.toml"
    path.write_text(FILE.replace("SOLVER", "lammps"))

    with pytest.raises(InputError, match=f"line [0-9]+, test 1, {words}"):
        load_calibration(path)


@pytest.mark.parametrize(
    "measure",
    [
        "def measure(run, foo=1, **others): pass",
        "def measure(foo): pass\ndef measure(run, *more, sizes): pass",
        "def measure(foo): pass\nmeasure = print",
        "from functools import cache\n@cache\ndef measure(foo): pass",
        "def measure(foo): pass\nfrom mine import *",
    ],
)
def test_a_function_that_may_be_callable_is_not_refused(beads: Path, measure: str) -> None:
    beads.write_text(CODE.partition("def measure")[0] + measure)

    assert make(beads).functions.keys() == {"scene", "measure"}


@pytest.mark.slow
def test_a_calibration_with_a_scene_keeps_results_and_is_read_back(
    beads: Path, tmp_path: Path
) -> None:
    path = tmp_path / "beads.toml"
    strategy = "\n[strategy]\nmax_runs = 7\nworkers = 1\nkeep = 'results'\n"
    path.write_text(FILE.replace("SOLVER", "lammps") + strategy)

    load_calibration(path).calibrate(tmp_path / "work")

    saved = SavedCalibration.open(tmp_path / "work")
    assert saved.result is not None
    assert len(list((tmp_path / "work" / "runs").glob("*/particles.png"))) == len(saved.evaluations)
    assert list((tmp_path / "work" / "runs").glob("*/functions")) == []
    assert write_report(tmp_path / "work", tmp_path / "report.html").exists()
    assert material_card(saved).write("json", tmp_path / "card.json").exists()
    with pytest.raises(InputError) as caught:
        solvers_of(saved, "")
    assert of_work_folder.SCENE_NOT_IN_RUNS.is_in(str(caught.value))


def test_particles_of_a_scene_are_clumps_of_the_aspect_ratio_of_the_material(
    beads: Path, tmp_path: Path
) -> None:
    sizes = ParticleSizes((0.010,), shape=ParticleShape("two_spheres"))
    test = OwnScene(sizes, scene=f"{beads}:scene", measure=f"{beads}:measure")
    again = recreate_test(
        RunDefinition({"solver": "lammps", "test": test.definition()}, GLASS_BEADS, 1)
    )
    solver = DEM_PROGRAMS["lammps"](test, {**GLASS_BEADS, "particle.aspect_ratio": 1.5})
    found = solver.run({}, 1, Workspace(tmp_path))

    assert again is not None
    assert again.sizes == sizes
    # Lying on the floor with both spheres of 0.84 of the diameter.
    assert found["height"].value == pytest.approx(0.0042, abs=5e-5)
    assert RunOutput(tmp_path).snapshot("end").count == 3


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "dtype=int), d)",
            "dtype=int), d, orientations=np.ones((2, 4)))",
            "orientations are not one for each clump",
        ),
        ("2 * d * i", "0.5 * d * i", "3 pairs overlap"),
        ("Box((-d,", "Box((-0.1 * d,", "1 of 3 begin outside"),
        (
            "Box((-d, -d, -d), (6 * d, d, 4 * d))",
            'Box((d, -d, -d), (9 * d, d, 4 * d), periodic="x")',
            "1 of 3 begin outside",
        ),
    ],
)
def test_clumps_that_cannot_begin_are_refused(beads: Path, old: str, new: str, words: str) -> None:
    code = beads.read_text()
    assert old in code
    beads.write_text(code.replace(old, new, 1))
    sizes = ParticleSizes((0.010,), shape=ParticleShape("two_spheres", aspect_ratio=1.5))
    test = OwnScene(sizes, scene=f"{beads}:scene", measure=f"{beads}:measure")

    with pytest.raises(RunFailedError, match=words):
        test.scene(GLASS_BEADS, 1)
