"""Draw the moving picture of the README from an animated run of the heap test.

grainfit simulate my_material.toml --animate
python tools/moving_picture.py my_material.simulated/runs/RUN

Draws the frames of the run from the side: filling, lifting the cylinder, and the heap with the
flanks that are measured. Writes docs/images/heap.gif.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from grainfit.bulk_tests.heap import Heap
from grainfit.bulk_tests.registry import recreate_test
from grainfit.campaign.work_folder import read_record
from grainfit.measurement.angle_of_repose import AngleOfRepose, Flank, angle_of_repose
from grainfit.measurement.particles import Particles
from grainfit.measurement.sheet import INK, OVERSAMPLING, font
from grainfit.measurement.side_view import Rectangle, SideView
from grainfit.scenes.film import FILM, Film, FilmFrame
from grainfit.scenes.run_output import RunOutput
from grainfit.scenes.wall_travels import wall_travels

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "heap.gif"
#: Largest number of frames, ms that each is shown, and ms of the last one.
_FRAMES, _SHOWN, _LAST = 64, 90, 4000
_WIDTH, _COLOURS = 560, 64
_EXTENT = (-0.175, -0.008, 0.175, 0.185)
_PLATE = (-0.16, -0.004, 0.16, 0.0)
_RADIUS, _WALL = 0.06, 0.0025


@dataclass(frozen=True)
class Picture:
    """A frame of a run, and how high its cylinder is."""

    particles: Particles
    bottom: float
    is_filling: bool

    @property
    def cylinder(self) -> list[Rectangle]:
        """Both walls of the cylinder."""
        right = (_RADIUS, self.bottom, _RADIUS + _WALL, 1.0)
        return [right, (-right[2], self.bottom, -right[0], 1.0)]


def filmed(folder: Path) -> list[Picture]:
    """Read the frames of a run."""
    record = read_record(folder)
    test = None if record is None else recreate_test(record.definition)
    if record is None or not isinstance(test, Heap) or not (folder / FILM).is_file():
        raise SystemExit(f"{folder} is no run of a heap test with frames: simulate --animate")
    scene = test.scene(record.definition.parameters, record.definition.seed)
    film, run = Film(folder / FILM), RunOutput(folder)
    frames = film.read(film.spread(_FRAMES))
    times = np.array([frame.step for frame in frames]) * scene.time_step
    travels = wall_travels(scene, run, times)["cylinder"].travels
    bottoms = (test.setup.cylinder_gap + travels).tolist()
    filling = (times <= run.stages[0].time).tolist()
    return [
        Picture(_particles(frame), bottom, is_filling)
        for frame, bottom, is_filling in zip(frames, bottoms, filling, strict=True)
    ]


def _particles(frame: FilmFrame) -> Particles:
    # Their masses are not drawn.
    return Particles(frame.positions, frame.radii, np.ones(len(frame.radii)))


def pictures(film: list[Picture]) -> Iterator[Image.Image]:
    """Yield the picture of each frame, the last one with its angle of repose."""
    for frame in film:
        words = "fill" if frame.is_filling else "lift the cylinder"
        yield _picture(frame.particles, frame.cylinder, words)
    heap = film[-1].particles
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
    parser.add_argument("run", type=Path, help="run folder of a heap test")
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
