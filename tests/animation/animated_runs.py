"""Calibration files with small tests, and what a page of an animation holds."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typer.testing import CliRunner, Result

from grainfit.animation.animation import AnimatedRun, animation_page
from grainfit.animation.drawn_film import draw_film
from grainfit.cli.app import app
from grainfit.scenes.conditions import Elapsed
from grainfit.scenes.film import FILM, Film
from grainfit.scenes.run_output import STAGES, STAGES_HEADER, RunOutput
from grainfit.scenes.scene import Rotation, Scene, Stage, Velocity, Wall
from grainfit.scenes.shapes import Block, Plane
from grainfit.testing.materials import GLASS_BEADS
from grainfit.testing.simulated_scenes import scene_of, spheres

BEADS = """\
name = "few beads"

[particle]
diameter = "10 mm"
youngs_modulus = "1 MPa"
poissons_ratio = 0.22
density = "2100 kg/m^3"

[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.3
density = "7700 kg/m^3"

[particle_particle]
sliding_friction = 0.5
rolling_friction = { min = 0.1, max = 0.9 }
restitution = 0.5
rolling_damping = 0.0

[particle_wall]
sliding_friction = 0.4
rolling_friction = 0.1
restitution = 0.5
rolling_damping = 0.0
"""
#: A third of the usual particles.
HEAP = """
[[test]]
type = "heap"
solver = "{solver}"
cylinder_radius = "40 mm"
strike_off_height = "80 mm"
bulk_density_top = "70 mm"
plate_radius = "120 mm"
plate_sliding_friction = 0.5
plate_rolling_friction = "particle_particle"
{more}
targets.angle_of_repose = {{ value = "22 deg" }}
"""
COMPRESSION = """
[[test]]
type = "compression"
solver = "{solver}"
targets.bulk_density = {{ value = "1200 kg/m^3" }}
"""
MODEL = """
[[test]]
name = "own"
type = "python"
function = "model.py:simulate"
targets.a = {{ value = 1.0 }}
"""


def calibration(folder: Path, *tests: str, solver: str = "lammps", more: str = "") -> Path:
    """Write a calibration file with some tests, and more options of a heap."""
    (folder / "model.py").write_text("def simulate(parameters, seed): return {'a': 1.0}")
    path = folder / "beads.toml"
    path.write_text(BEADS + "".join(tests).format(solver=solver, more=more))
    return path


def simulate(file: Path, *arguments: str, code: int = 0) -> Result:
    """Run ``grainfit simulate`` with runs beside the file."""
    workdir = str(file.with_suffix(".simulated"))
    done = CliRunner().invoke(app, ["simulate", str(file), "--workdir", workdir, *arguments])
    assert done.exit_code == code, done.output
    return done


def run_folders(file: Path) -> list[Path]:
    """Return the folders of the runs."""
    return sorted(file.with_suffix(".simulated").glob("runs/*"))


def film_of(page: Path) -> dict[str, Any]:
    """Return the data of a page."""
    found = re.search(r'id="data-film">(.*?)</script>', page.read_text(), re.DOTALL)
    assert found is not None
    film: dict[str, Any] = json.loads(found[1])
    return film


def moving() -> Scene:
    """Return two beads, a lid that comes down, waits and is taken away, and a block that moves."""
    block = Wall(Block((0.04, -0.05, 0.0), (0.06, 0.05, 0.02)))
    close = Stage(
        "close",
        Elapsed(0.1),
        put={"lid": Wall(Plane("z", 0.08, upwards=False))},
        motions={"lid": Velocity("z", -0.2)},
    )
    push = Stage("push", Elapsed(0.05), take_away=("lid",), motions={"block": Velocity("x", 0.1)})
    return scene_of(
        spheres([(0, 0, 0.0301), (0.02, 0.03, 0.05)]),
        {"floor": Wall(Plane("z", 0.0)), "block": block},
        [Stage("fall", Elapsed(0.03)), close, Stage("wait", Elapsed(0.02)), push],
        {**GLASS_BEADS, "particle_particle.rolling_damping": 0, "particle_wall.rolling_damping": 0},
        time_step=1e-4,
    )


def turning(angle: float, block: Block) -> Scene:
    """Return a floor, on which a block turns about the z axis by an angle within 0.2 s."""
    turn = Rotation("z", angle / 0.2)
    return scene_of(
        spheres([(0, 0, 0.0301), (0.02, 0.03, 0.05)]),
        {"floor": Wall(Plane("z", 0.0)), "block": Wall(block)},
        [Stage("turn", Elapsed(0.2), motions={"block": turn})],
        time_step=1e-4,
    )


def made_up(folder: Path, scene: Scene, frames: int = 41) -> RunOutput:
    """Write what a run of 0.2 s with two beads leaves, without a solver: both beads sink."""
    rows, end = [], 0.0
    for stage in scene.stages:
        assert isinstance(stage.until, Elapsed)
        end += stage.until.time
        rows.append(f"{stage.name},done,{round(1e4 * end)},{end:.10g},2,0.0")
    folder.mkdir(exist_ok=True)
    (folder / STAGES).write_text("\n".join([STAGES_HEADER, *rows]) + "\n")
    text = ""
    for step in np.linspace(0, 2000, frames).round().astype(int):
        text += f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n"
        text += "-0.1 0.1\n" * 2 + "-0.1 0.2\nITEM: ATOMS id type x y z radius mass\n"
        text += f"1 1 0 0 {0.0301 - 1e-5 * step} 0.005 0.001\n"
        text += f"2 1 0.02 0.03 {0.05 - 1e-5 * step} 0.005 0.001\n"
    (folder / FILM).write_text(text)
    return RunOutput(folder)


def page_of(run: RunOutput, scene: Scene, frames: int = 1000, failure: str = "") -> Path:
    """Write the page of a run of a scene."""
    drawn = draw_film(scene, run, Film(run.folder / FILM), frames)
    path = run.folder / "animation.html"
    path.write_text(
        animation_page(
            AnimatedRun("beads", "lid", "lammps", 7, {"x": 1.5}, {"x": "mm"}, failure), drawn
        )
    )
    return path


def numbers(text: str) -> NDArray[np.int64]:
    """Return packed numbers, three or four for each place."""
    return np.frombuffer(base64.b64decode(text), "<i2").astype(np.int64)


def metres(film: dict[str, Any]) -> float:
    """Return the length of a step, from the radius of a bead of 10 mm."""
    return 0.005 / float(numbers(film["particles"])[3])


def places(film: dict[str, Any]) -> NDArray[np.float64]:
    """Return the places of particles, shape (frames, n, 3), in m; nan where one is not there."""
    found = np.array([numbers(frame) for frame in film["frames"]], dtype=float)
    found[found == -32768] = np.nan
    return metres(film) * found.reshape(len(found), -1, 3)


def travels(film: dict[str, Any], wall: int) -> NDArray[np.float64]:
    """Return the travels of a wall, m; nan where it is not there."""
    return metres(film) * np.array(film["walls"][wall]["places"], dtype=float)
