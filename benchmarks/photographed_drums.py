"""Measure rendered videos of simulated drums whose angles are known.

Beds of rough and smooth spheres in drums of 8 to 16 particle diameters in radius, with and without
end caps, seen up to 8 degrees beside the axis, with perspective, uneven light, reflections in the
glass, blur, noise, and the compression of the video; the same drums turning
the other way before the same camera; and videos that no one can measure. The drums are simulated
once, with LAMMPS, and kept in the folder ``--drums``; finished videos are kept in the file
``--kept``. The command can be stopped and started again.

    python -m benchmarks.photographed_drums --drums DIR --kept FILE [--videos 60] [--unusable 24]
        [--first 1000] [--table]

Prints the error against the angles of the same frames by the simulation's own measure, the bias,
how often the stated uncertainty covers it, and what was refused.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from grainfit.bulk_tests.drum import Drum
from grainfit.bulk_tests.drum.angles import DrumAngles
from grainfit.bulk_tests.drum.bed import TurningBed
from grainfit.errors import NotMeasurableError
from grainfit.measurement.particles import Particles
from grainfit.photographs.photo import photo
from grainfit.solvers.base import Workspace
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.testing.materials import ROUGH_SPHERES
from tests.photographs.drawn_drums import UNUSABLE, Simulated, every, unusable_drum, usable_drum
from tests.photographs.rendered_drums import DrumShot, save_video

DIAMETER = 0.010
#: Radius in diameters, fill level, sliding and rolling friction, Froude number, and end caps.
DRUMS = (
    (8, 0.4, 0.5, 0.2, 0.01, True),
    (12, 0.35, 0.3, 0.05, 0.02, True),
    (12, 0.45, 0.2, 0.02, 0.01, True),
    (16, 0.3, 0.5, 0.3, 0.01, True),
    (8, 0.4, 0.5, 0.2, 0.01, False),
)
ANGLES = ("dynamic_angle", "surface_angle", "upper_angle", "lower_angle")
#: Half of a normal interval of 95 %.
_COVER = 1.96
#: Frames of a video, about.
_FRAMES = 24
#: Its size, pixels.
_SIZE = (360, 270)


def drum_of(number: int) -> Drum:
    """Return a drum."""
    radius, fill, _, _, froude, caps = DRUMS[number]
    return Drum(
        diameter=DIAMETER,
        drum_radius=radius * DIAMETER,
        drum_length=5 * DIAMETER,
        fill_level=fill,
        froude_number=froude,
        end_caps=caps,
        averaged_turns=1.2,
    )


def simulated(number: int, folder: Path) -> Simulated:
    """Simulate a drum, or read it from the folder."""
    drum, path = drum_of(number), folder / f"drum_{number}.npz"
    if not path.exists():
        sliding, rolling = DRUMS[number][2:4]
        material = {
            **ROUGH_SPHERES,
            "particle_particle.sliding_friction": sliding,
            "particle_particle.rolling_friction": rolling,
        }
        program = DEM_PROGRAMS["lammps"](drum, material)
        with tempfile.TemporaryDirectory() as work:
            run = program.simulate(drum.scene(material, 1), Workspace(Path(work), 7200))
            bed = drum.view(run).angles.bed
            along = [frame.particles.positions[:, 0] for frame in run.frames("turning")]
        folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(
            path,
            x=np.array(along, np.float32),
            across=bed.across.astype(np.float32),
            heights=bed.heights.astype(np.float32),
            times=bed.times,
            radii=bed.last.radii,
        )
    kept = np.load(path)
    radii = kept["radii"]
    places = np.zeros((len(radii), 3))
    bed = TurningBed(
        drum.setup,
        Particles(places, radii, radii**3),
        kept["times"],
        kept["across"].astype(float),
        kept["heights"].astype(float),
    )
    whole = Simulated(bed, kept["x"].astype(float), 2 * math.pi / 120)
    return every(whole, max(1, len(bed.times) // _FRAMES))


def record_of(number: int, good: bool, drums: Path) -> dict[str, Any]:
    """Render and measure once; usable drums once more, turning the other way before the camera."""
    drum = number % len(DRUMS)
    turning = simulated(drum, drums)
    record: dict[str, Any] = {"number": number, "good": good, "drum": drum}
    if not good:
        record["kind"] = UNUSABLE[number % len(UNUSABLE)]
        return record | _measured(unusable_drum(turning, number, _SIZE), None)
    shot, level = usable_drum(turning, number, _SIZE)
    flanks = DrumAngles(turning.bed).flanks()
    record["true"] = {name: flank.angle for name, flank in flanks.items()}
    record["speed"] = shot.step / shot.interval if shot.mark is not None else None
    record["by roll"] = shot.roll if shot.mirrored else -shot.roll
    back = replace(shot, mirrored=not shot.mirrored)
    return record | _measured(shot, level) | {"back": _measured(back, level)}


def _measured(shot: DrumShot, level: float | None) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drum.mp4"
        save_video(shot, path)
        try:
            found = photo(path, "drum", level=level, **_known(shot))
        except NotMeasurableError as error:
            return {"refused": str(error).partition(".mp4: ")[2]}
    # The same frames are compared: that there are others does not matter.
    unsure = {
        name: math.sqrt(sum(part**2 for source, part in parts.items() if source != "over time"))
        for name, parts in found.parts.items()
    }
    speed = found.rotational_speed
    return {
        "angles": {name: value.value for name, value in found.responses.items()},
        "uncertainties": unsure,
        "parts": found.parts,
        "found speed": None if speed is None else speed.value,
    }


def _known(shot: DrumShot) -> dict[str, float]:
    """Return the lengths of the drum, the distance of the camera as a tape measure tells it."""
    rng = np.random.default_rng([46, shot.seed])
    return {"drum": 2.0, "length": shot.length, "distance": shot.distance * rng.normal(1, 0.03)}


def table(records: list[dict[str, Any]]) -> Iterator[str]:
    """Yield lines in Markdown."""
    good = [r for r in records if r["good"]]
    measured = [r for r in good if "angles" in r]
    yield "| angle | videos | within 0.5° | 95 % of the errors below | bias | covered |"
    yield "|---|---|---|---|---|---|"
    for name in ANGLES if measured else ():
        errors = np.array([r["angles"][name] - r["true"][name] for r in measured])
        stated = np.array([r["uncertainties"][name] for r in measured])
        yield (
            f"| {name.replace('_', ' ')} | {len(errors)} | "
            f"{100 * np.mean(np.abs(errors) <= 0.5):.0f} % | "
            f"{np.quantile(np.abs(errors), 0.95):.2f}° | {errors.mean():+.2f}° | "
            f"{100 * np.mean(np.abs(errors) < _COVER * stated):.0f} % |"
        )
    yield from _within("one way", [_error(r, r) for r in measured])
    yield from _within("level known", [_error(r, r) - r["by roll"] for r in measured])
    both = [r for r in measured if "angles" in r.get("back", {})]
    yield from _within("both ways", [(_error(r, r) + _error(r, r["back"])) / 2 for r in both])
    yield f"\nrefused: {len(good) - len(measured)} of {len(good)} usable videos"
    reasons = Counter(r["refused"][:60] for r in good if "refused" in r)
    yield from (f"  {count} x {reason}..." for reason, count in reasons.most_common())
    marked = [r for r in measured if r["speed"]]
    ratios = [r["found speed"] / r["speed"] - 1 for r in marked if r["found speed"]]
    if ratios:
        yield (
            f"speed: found in {len(ratios)} of {len(marked)} videos with a mark, within "
            f"{100 * max(map(abs, ratios)):.2f} %"
        )
    bare = [r for r in measured if not r["speed"]]
    yield f"speed without a mark: {sum(bool(r['found speed']) for r in bare)} of {len(bare)}"
    for kind in UNUSABLE:
        some = [r for r in records if r.get("kind") == kind]
        yield f"{kind}: {sum('refused' in r for r in some)} of {len(some)} refused"


def _error(record: dict[str, Any], measured: dict[str, Any]) -> float:
    """Error of the dynamic angle, degrees."""
    return float(measured["angles"]["dynamic_angle"] - record["true"]["dynamic_angle"])


def _within(name: str, errors: list[float]) -> Iterator[str]:
    """Yield a line on errors of the dynamic angle."""
    sizes = np.abs(errors)
    if len(sizes):
        yield (
            f"{name}: {(sizes <= 0.5).sum()} of {len(sizes)} within 0.5°, root mean square "
            f"{np.sqrt((sizes**2).mean()):.2f}°, largest {sizes.max():.2f}°"
        )


def main() -> None:
    """Measure the videos that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drums", type=Path, required=True)
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--videos", type=int, default=60)
    parser.add_argument("--unusable", type=int, default=24)
    parser.add_argument("--first", type=int, default=0, help="number of the first video")
    parser.add_argument("--table", action="store_true", help="print what is kept only")
    given = parser.parse_args()
    records = []
    if given.kept.exists():
        records = [json.loads(line) for line in given.kept.read_text().splitlines()]
    done = {(r["number"], r["good"]) for r in records}
    wanted = [(given.first + n, True) for n in range(given.videos)]
    wanted += [(given.first + n, False) for n in range(given.unusable)]
    # Some of both kinds from the beginning.
    wanted.sort(key=lambda one: one[0] if one[1] else 2 * one[0] - given.first)
    for number, good in [] if given.table else wanted:
        if (number, good) in done:
            continue
        records.append(record_of(number, good, given.drums))
        with given.kept.open("a") as file:
            file.write(json.dumps(records[-1]) + "\n")
    print("\n".join(table(records)))


if __name__ == "__main__":
    main()
