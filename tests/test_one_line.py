"""Every public object is shown in one line of at most 120 characters."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grainfit as gf
from grainfit import scenes
from grainfit.analysis.modulus_study import ModulusRow
from grainfit.result import HoldoutResult
from grainfit.testing.materials import GLASS_BEADS
from grainfit.which_test.next_test import OpenParameters
from grainfit.work_folder.predict import Predictions

BEADS = Path(__file__).parents[1] / "docs" / "recorded" / "beads"
FILE = """\
name = "my sand"
[parameters]
friction = { min = 0.1, max = 0.9 }
[[test]]
type = "python"
function = "model.py:simulate"
targets.angle = { value = 30.0, tolerance = 0.5 }
"""
MODEL = """\
def simulate(parameters, seed):
    return {"angle": 10 + 40 * parameters["friction"] + 0.2 * ((seed % 1009) / 1009 - 0.5)}
"""
ERRORS = (
    *(gf.GrainfitError, gf.NotMeasurableError, gf.RunFailedError, gf.SolverNotFoundError),
    gf.StoreError,
)
MATERIAL = {name: value for name, value in GLASS_BEADS.items() if name != "particle.density"}
SIZES = gf.ParticleSizes((0.01,), (1.0,))


def of_calibration(folder: Path) -> list[Any]:
    """Return what a calibration of a model of one's own leaves."""
    (folder / "model.py").write_text(MODEL)
    (folder / "beads.toml").write_text(FILE)
    setup = gf.load(folder / "beads.toml")
    states: list[gf.Progress] = []
    result = setup.calibrate(folder / "work", on_progress=states.append)
    saved = gf.open(folder / "work")
    search = gf.Sequential().start(setup.problem, seed=1)
    [evaluation, *_] = saved.evaluations
    runs = gf.repeat_runs(setup, repeat=2, workdir=folder / "repeated")
    return [
        *(setup, result, saved, states[-1], search, evaluation, evaluation.proposal, runs),
        *evaluation.responses.values(),
        *setup.solvers.values(),
        saved.analyse(),
        gf.analyse_runs(setup, [str(folder / "work")]),
        gf.Interview.open(folder / "beads.toml"),
        gf.expected_narrowing(setup.problem, setup.solvers),
    ]


def of_tests(folder: Path) -> list[Any]:
    """Return bulk tests, solvers, and what a plan of tests is made of."""
    tests = [getattr(gf.tests, name)(SIZES) for name in dir(gf.tests) if name != "OwnScene"]
    file = folder / "scene.py"
    file.write_text("def scene(sizes):\n    return None\ndef measure(run):\n    return {}\n")
    own = gf.tests.OwnScene(SIZES, scene=f"{file}:scene", measure=f"{file}:measure")
    undamped = {n: 0.0 if n.endswith("rolling_damping") else v for n, v in MATERIAL.items()}
    programs = [gf.solvers.Lammps, gf.solvers.Liggghts, gf.solvers.Yade]
    return [*tests, own, *(program(tests[4], undamped) for program in programs)]


def of_values() -> list[Any]:
    """Return plain values with long names and many entries."""
    names = [f"particle_particle.sliding_friction_{number}" for number in range(14)]
    parameters = [gf.Parameter(name, 0.1, 0.9) for name in names]
    targets = [gf.Target(f"angle_{number}", 30.0, tolerance=0.5) for number in range(14)]
    many = tuple(np.linspace(0.001, 0.01, 50))
    by_name = dict.fromkeys(names, 0.1234567891234)
    return [
        gf.Problem(parameters, targets),
        *(parameters[0], targets[0]),
        gf.Answer(by_name, by_name, by_name, 0.98),
        gf.CurveTarget("stress", many, many, uncertainty=0.01),
        gf.Curve(many, many),
        gf.TestScope("heap", names, names),
        gf.Holdout("drum", of_values, targets),
        Predictions("a" * 200, (HoldoutResult("drum", "pending"),) * 9),
        gf.Relative("heap", 0.25),
        gf.RayleighTimeStep(0.005, by_name),
        gf.ParticleSizes(many, (0.02,) * 50),
        gf.LogNormal(median="4 mm", geometric_standard_deviation=1.7),
        gf.RosinRammler(d63="4 mm", exponent=2.5),
        gf.SieveCurve(many, tuple(np.linspace(0, 1, 50))),
        gf.ModulusStudy((ModulusRow(1.0, 1e7, {}, None, 1.0),) * 9, tuple(targets), by_name, 3),
        gf.Advice(OpenParameters(tuple(parameters), {}, by_name, None, 60.0)),
        gf.MeasurementPlan(0.2, None, ()),
        gf.Estimate((), (), *(by_name,) * 3, (), 1.0, 3, 60.0, (), np.zeros((9, 2)), np.zeros(9)),
        gf.PhotographedDrum(by_name, {"dynamic_angle": by_name}, (), 0.084, {}),
        gf.PhotographedDrawDowns(by_name, {"shear_angle": by_name}, (), {Path("a" * 200): "dark"}),
        gf.PhotographedSlopes(gf.Response(22.0, 0.2), (), by_name, {Path("a" * 200): "dark"}),
        gf.PhotographedHeaps(gf.Response(30.0, 0.5), (), by_name, {Path("a" * 200): "dark"}),
        *(gf.InputError([gf.errors.Fault(name, "is wrong.") for name in names]),),
        *(kind("no\nlicence " * 30) for kind in ERRORS),
        *(gf.Sequential(), gf.Staged(), gf.Proposal(by_name, 123456, "design")),
        gf.solvers.Workspace(Path("a" * 90)),
    ]


def of_scenes() -> list[Any]:
    """Return a scene with its parts."""
    column = scenes.Column(np.zeros((500, 3)), np.zeros(500, dtype=int), 1.0)
    walls, lids = (
        {f"{name}_{n}": scenes.Wall(scenes.Plane("z", 0.0)) for n in range(30)}
        for name in ("wall", "lid")
    )
    stage = scenes.Stage("filling", scenes.AtRest(10.0), put=lids, series=scenes.Series({}, 0.1))
    box = scenes.Box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    scene = scenes.Scene(
        "a heap", GLASS_BEADS, SIZES, column, box, walls, (stage,), 9.81, 1e-5, 1e-3, 0.1
    )
    shapes = [
        *(scenes.Block((0.0,) * 3, (1.0,) * 3), scenes.Prism((0.0,) * 3, (1.0,) * 3, 0.5)),
        scenes.Cylinder(0.1, 0.0, 1.0),
        *(scenes.Cone(0.1, 0.2, 0.0, 1.0), scenes.Disc(0.1, 0.0), scenes.Annulus(0.1, 0.2, 0.0)),
        *(scenes.Mesh(Path("a" * 200)), scenes.Glued(np.zeros((500, 3)), np.zeros(500, dtype=int))),
        *(
            scenes.Plane("z", 0.0),
            scenes.Round(0.1),
            scenes.Rectangle(0.1, 0.2),
            scenes.PeriodicRectangle(0.1, 0.2),
            scenes.Square(0.1),
        ),
    ]
    others = [
        *(scenes.Clear("lid", 1.0), scenes.Loaded("lid", 0.1, 1.0), scenes.Elapsed(1.0)),
        scenes.Drained(0.0, 0.5, 1.0),
        *(scenes.Force("lid", "z"), scenes.Frames("film", 0.1), scenes.KineticEnergy()),
        *(scenes.MassAbove(0.1), scenes.RadialForce("lid"), scenes.Travel("lid")),
        *(scenes.Load("z", 1.0, 0.1, 1.0), scenes.Rotation("z", 1.0), scenes.Velocity("z", 0.1)),
        scenes.RunOutput(Path("a" * 200)),
    ]
    return [scene, *shapes, *others, column, box, stage, stage.until, stage.series, *walls.values()]


def is_short(shown: str) -> bool:
    return (
        len(shown) <= 120 and "\n" not in shown and " object at 0x" not in shown.partition("(")[0]
    )


def reached(one: Any, known: set[int], depth: int = 3) -> Iterator[Any]:
    """Yield the objects of the package that attributes of an object lead to."""
    if isinstance(one, dict | list | tuple):
        parts = list(one.values() if isinstance(one, dict) else one)[:2]
        for part in parts:
            yield from reached(part, known, depth)
    if id(one) in known or not depth or isinstance(one, type) or inspect.isroutine(one):
        return
    known.add(id(one))
    if not (type(one).__module__ or "").startswith("grainfit"):
        return
    yield one
    for name in dir(one):
        if name[0] != "_":
            with suppress(Exception):
                yield from reached(getattr(one, name), known, depth - 1)


def test_every_public_object_is_shown_in_one_line(tmp_path: Path) -> None:
    table = tmp_path / "runs.csv"
    table.write_text("friction,angle\n0.1,20\n0.9,40\n")
    own = [
        gf.solvers.PythonCallable(lambda parameters, seed: {"angle": 1.0}),
        gf.solvers.RecordedTable(table, ["friction"], ["angle"]),
        gf.solvers.SourceRecord("line 17", {f"parameter_{n}": 0.1 for n in range(14)}, True),
        gf.solvers.Command(tmp_path, ["sh", "-c", "{{ friction }}" + "x" * 200]),
    ]
    objects = [*of_calibration(tmp_path), *of_tests(tmp_path), *of_values(), *of_scenes(), *own]
    for one in objects:
        shown = repr(one)
        assert is_short(shown), shown
        assert type(one).__name__ in shown
    beads, known = gf.open(BEADS), set[int]()
    parts = [part for one in [*objects, beads, beads.card()] for part in reached(one, known)]
    long = {
        f"{type(part).__module__}.{type(part).__name__}"
        for part in parts
        if not is_short(repr(part))
    }
    assert long == set()
    rooms = (gf, gf.tests, gf.solvers, gf.scenes)
    public = [getattr(room, name) for room in rooms for name in dir(room)]
    for kind in filter(inspect.isclass, public):
        assert any(isinstance(one, kind) for one in objects), kind


@pytest.mark.parametrize(
    ("shown", "expected"),
    [
        (gf.Sequential(), "Sequential()"),
        (gf.Sequential(prefer="accuracy"), "Sequential(prefer='accuracy')"),
        (gf.StoreError("no\nserver"), "StoreError('no\\nserver')"),
    ],
)
def test_what_differs_from_the_default_is_shown(shown: object, expected: str) -> None:
    assert repr(shown) == expected
