"""Photograph, film and weigh simulated pellets: the laboratory of the tutorial "From a phone".

The pellets of `examples/phone` with frictions that the tutorial does not know are simulated by

    grainfit simulate examples/phone/calibration.toml --repeat 3 --workdir DIR
        --set particle_particle.sliding_friction=0.45 --set particle_particle.rolling_friction=0.2

and this command renders five pictures of a heap with the marker sheet before it and the video of
the drum, and writes the records of the balance:

    python -m benchmarks.phone DIR OUTPUT
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from grainfit.bulk_tests.drum import Drum
from grainfit.bulk_tests.registry import recreate_test
from grainfit.photographs import marker
from grainfit.run_definition import RunDefinition
from grainfit.scenes.run_output import RunOutput
from tests.photographs.drawn_drums import Simulated, every
from tests.photographs.rendered_drums import DrumShot, save_video, seen_from_the_front
from tests.photographs.rendered_pictures import Shot, save
from tests.photographs.test_marker import _printed

#: Elevation, roll, side, and change of the light across each picture.
PICTURES = (
    (8.0, 1.0, 0.0, 0.1),
    (11.0, -1.5, 36.0, -0.1),
    (9.0, 0.5, 72.0, 0.2),
    (6.0, 2.0, 108.0, 0.0),
    (10.0, -0.5, 144.0, -0.2),
)
#: Black pellets on the sheet, on a table before a wall; pixels of a picture.
_BLACK, _TABLE, _WALL = (0.1, 0.1, 0.11), (0.45, 0.4, 0.34), (0.62, 0.64, 0.66)
_SIZE = (1600, 1200)
#: Quality of the JPEG files.
_QUALITY = 75
#: Frames of the video, about; lines of the balance a second, and its resolution, g.
_FRAMES, _RATE, _RESOLUTION = 40, 50, 0.01


def runs_of(folder: Path, kind: str) -> Iterator[RunOutput]:
    """Iterate over the runs of a bulk test."""
    for path in sorted((folder / "runs").glob("*/run.json")):
        if json.loads(path.read_text())["definition"]["test"]["type"] == kind:
            yield RunOutput(path.parent)


def photograph(run: RunOutput, folder: Path) -> None:
    """Render the pictures of a heap."""
    sheet = _printed()
    corner = (sheet.corner[0], -marker.HEIGHT / 2, 0.0005)
    folder.mkdir(parents=True, exist_ok=True)
    for number, (elevation, roll, azimuth, uneven) in enumerate(PICTURES, 1):
        shot = Shot(
            run.snapshot("heap"),
            elevation=elevation,
            roll=roll,
            azimuth=azimuth,
            distance=0.43,
            focal=1.05,
            size=_SIZE,
            aim=(0.0, -0.03),
            colour=_BLACK,
            gloss=0.2,
            table=_TABLE,
            backdrop=_WALL,
            uneven=uneven,
            vignette=0.15,
            blur=1.0,
            sheet=type(sheet)(sheet.image, sheet.width, corner, sheet.along, sheet.up),
            seed=number,
        )
        path = folder / f"side_{number}.jpg"
        save(shot, path, exif=True)
        with Image.open(path) as image:
            image.load()
            image.save(path, quality=_QUALITY, exif=image.getexif())


def film(run: RunOutput, path: Path) -> None:
    """Render the video of a drum."""
    definition = json.loads((run.folder / "run.json").read_text())["definition"]
    drum = recreate_test(RunDefinition({"test": definition["test"]}, {}, 1))
    assert isinstance(drum, Drum)
    bed = drum.view(run).angles.bed
    along = np.array([frame.particles.positions[:, 0] for frame in run.frames("turning")])
    turning = every(
        Simulated(bed, along, 2 * math.pi / 120), max(1, round(len(bed.times) / _FRAMES))
    )
    setup = drum.setup
    radius = setup.clear_radius
    places, radii = seen_from_the_front(
        turning.along, turning.bed.across, turning.bed.heights, bed.last.radii, radius
    )
    shot = DrumShot(
        places,
        radii,
        length=setup.drum_length / radius,
        step=turning.step,
        interval=float(np.diff(turning.bed.times).mean()),
        yaw=3.0,
        pitch=2.0,
        roll=0.1,
        size=(640, 480),
        colour=_BLACK,
        back=(0.75, 0.75, 0.72),
        glare=0.1,
    )
    save_video(shot, path)


def weigh(run: RunOutput, path: Path, seed: int) -> None:
    """Write the record of a balance below the outlet."""
    series = run.series("flow")
    begin, end = series["time"][0], series["time"][-1]
    left = series["inside"][0] - series["inside"]
    time = np.arange(0.0, 1.0 + (end - begin) + 1.0, 1 / _RATE)
    noise = np.random.default_rng(seed).normal(0.0, _RESOLUTION, len(time))
    mass = 1000 * np.interp(time - 1.0, series["time"] - begin, left) + noise
    rows = [
        f"{t:.2f};{_RESOLUTION * round(m / _RESOLUTION):.2f}"
        for t, m in zip(time, mass, strict=True)
    ]
    path.write_text("\n".join(["time [s];mass [g]", *rows, ""]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=Path)
    parser.add_argument("output", type=Path)
    given = parser.parse_args()
    photograph(next(runs_of(given.runs, "heap")), given.output / "heap")
    film(next(runs_of(given.runs, "drum")), given.output / "drum.mp4")
    for number, run in enumerate(runs_of(given.runs, "discharge"), 1):
        weigh(run, given.output / f"weighing_{number}.csv", number)


if __name__ == "__main__":
    main()
