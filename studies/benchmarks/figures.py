"""Figures of the benchmarks: impacts and drums beside what was published and measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.measurement.line_panel import PlottedLine, line_panel
from grainfit.measurement.sheet import OVERSAMPLING, sheet
from studies.benchmarks import disagreement, mixing_drum, shear
from studies.benchmarks.comparisons import Records
from studies.benchmarks.impacts import abscissae
from studies.benchmarks.published import curve

#: Colours of Okabe & Ito, which the colour-blind can tell apart.
_COLOURS = {"lammps": "#0072b2", "liggghts": "#e69f00", "yade": "#009e73"}
_NAMES = {"lammps": "LAMMPS", "liggghts": "LIGGGHTS", "yade": "YADE"}
_MEASURED, _PUBLISHED = "#d55e00", "#616e7c"
_SIZE = (700 * OVERSAMPLING, 420 * OVERSAMPLING)


def draw_impacts(records: Records, path: Path) -> Path:
    """Draw the fourth and the fifth impact to a PNG file."""
    angle = "angle of incidence, degrees"
    panels = []
    for key, label in (
        ("tangential_restitution", "tangential restitution"),
        ("angular_velocity", "spin after the impact, 1/s"),
        ("rebound_angle", "rebound angle of the contact patch, degrees"),
    ):
        lines = [
            *_dots(curve(f"test4_{key}", "oxide"), 0.5, _PUBLISHED, "published DEM"),
            *_dots(curve(f"test4_{key}", "experiment"), 0.5, _MEASURED, "experiment"),
            *_lines(records, 4, "oxide", key),
        ]
        panels.append(line_panel(lines, angle, label, _SIZE, from_zero=False))
    recoil = [
        *_dots(curve("test5_recoil", "steel"), 0.08, _PUBLISHED, "published DEM"),
        *_lines(records, 5, "steel", "recoil"),
    ]
    panels.append(
        line_panel(
            recoil,
            "tangential over friction times normal velocity, before",
            "the same, after",
            _SIZE,
            from_zero=False,
        )
    )
    title = "Chung & Ooi's fourth and fifth impact"
    words = "Aluminium oxide, friction 0.092, restitution 0.98; last: steel, friction 0.3."
    sheet(title, words, panels, _SIZE[0]).save(path)
    return path


def draw_disagreement(path: Path) -> Path:
    """Draw the angles of a drum over its speed to a PNG file."""
    speeds = np.arange(10, 51)
    look_up = disagreement.LookUp()
    colours = {"first": "#e69f00", "second": "#0072b2"}
    lines: list[PlottedLine] = []
    for name, answer in disagreement.ANSWERS.items():
        angles = np.array([float(look_up.angle(*answer, int(speed))) for speed in speeds])
        label = f"{name} answer, by the look-up"
        lines.append(PlottedLine(speeds, angles, label, colours[name]))
        points = [
            (speed, angle)
            for (calibration, speed), (angle, _) in disagreement.photographed().items()
            if calibration == name
        ]
        lines += _dots(np.array(points, dtype=float), 0.5, colours[name], f"{name} photographs")
    size = (1000 * OVERSAMPLING, 520 * OVERSAMPLING)
    panel = line_panel(
        lines,
        "speed of the drum, rpm",
        "dynamic angle, degrees",
        size,
        from_zero=False,
        across_from_zero=False,
    )
    title = "Two published calibrations of one powder"
    words = "Lines are what either answer predicts; marks are what its photographs show."
    sheet(title, words, [panel], size[0]).save(path)
    return path


def draw_shear(records: shear.Records, path: Path) -> Path:
    """Draw steady shear over sliding friction and inertial number to a PNG file."""
    published = {
        friction: (shear.angle_of(ratio), solid)
        for friction, (ratio, solid) in shear.PUBLISHED.items()
    }
    panels = []
    for number, label in enumerate(
        ("angle of shear stress over pressure, degrees", "solid fraction")
    ):
        dots = np.array([(friction, values[number]) for friction, values in published.items()])
        lines = [*_dots(dots, 0.02, _PUBLISHED, "published DEM")]
        for solver in _COLOURS:
            found = {f: shear.limit(records, solver, f) for f in shear.FRICTIONS}
            known = {f: (one.angle, one.solid_fraction) for f, one in found.items() if one}
            if known:
                y = [values[number] for values in known.values()]
                lines.append(PlottedLine(list(known), y, _NAMES[solver], _COLOURS[solver]))
        panels.append(line_panel(lines, "sliding friction", label, _SIZE, from_zero=number == 0))
    numbers = np.linspace(1e-4, 0.11, 100)
    curves: dict[float, Sequence[PlottedLine]] = {
        0.5: [
            PlottedLine(numbers, shear.glass_beads(numbers), "glass beads", _MEASURED),
            PlottedLine(numbers, shear.chialvo(numbers, 0.382), "published DEM", _PUBLISHED),
        ],
        0.0: _dots(np.array([(0.0, shear.PUBLISHED[0.0][0])]), 0.002, _PUBLISHED, "published DEM"),
    }
    for friction, published_lines in curves.items():
        points = shear.over_inertia(records, "lammps", friction)
        panels.append(
            line_panel(
                [*published_lines, *_dots(points, 0.001, _COLOURS["lammps"], "LAMMPS")],
                "inertial number",
                f"shear stress over pressure, friction {friction:g}",
                _SIZE,
            )
        )
    title = "Steady shear of spheres without rolling friction"
    words = "Above in the limit of no inertia, below over the inertial number."
    sheet(title, words, panels, _SIZE[0]).save(path)
    return path


def draw_mixing(records: Mapping[mixing_drum.Drum, Mapping[str, Any]], path: Path) -> Path:
    """Draw the counts of a mixing drum over time to a PNG file, as shares of all spheres."""
    published = {"musen": _PUBLISHED, "liggghts": "#1f2933"}
    panels = []
    for number, (zone, count) in enumerate(zip(mixing_drum.ZONES, mixing_drum.ALL, strict=True)):
        lines = []
        for program, name in mixing_drum.PROGRAMS.items():
            times, counts = mixing_drum.published(program)
            shown = times <= mixing_drum.TIME
            shares = 100 * counts[shown, number] / count
            label = f"paper: {name}"
            lines.append(PlottedLine(times[shown], shares, label, published[program]))
        for solver, record in mixing_drum.drums_of(records).items():
            shares = 100 * np.array(record["counts"])[:, number] / count
            lines.append(PlottedLine(record["times"], shares, _NAMES[solver], _COLOURS[solver]))
        quarter, size = zone.split("_")
        label = f"{size} spheres in the {quarter} quarter, %"
        panels.append(line_panel(lines, "time, s", label, _SIZE))
    title = "Mixing drum of two materials"
    words = (
        "30,000 spheres of 2 mm begin above 8,000 of 4 mm; the drum carries them up to the right."
    )
    sheet(title, words, panels, _SIZE[0]).save(path)
    return path


def _lines(records: Records, test: int, body: str, key: str) -> list[PlottedLine]:
    """Return a line for each solver."""
    found = []
    for run, record in records.items():
        if (run.test, run.body) == (test, body):
            x, y = abscissae(test, body), record["found"][key]
            found.append(PlottedLine(x, y, _NAMES[run.solver], _COLOURS[run.solver]))
    return found


def _dots(
    points: NDArray[np.float64], half: float, colour: str, label: str
) -> Sequence[PlottedLine]:
    """Return a short thick line for each point; the first one has the label."""
    return [
        PlottedLine([x - half, x + half], [y, y], "" if number else label, colour, 7)
        for number, (x, y) in enumerate(points.tolist())
    ]
