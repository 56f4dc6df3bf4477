"""Rows of the evidence table: each benchmark, its reference, what came out, and the command.

Every figure is from records that a command keeps, or from the page where the output of a command
stands that keeps none.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np

from grainfit.evaluation import Response
from studies.benchmarks import (
    comparisons,
    disagreement,
    drum_parts,
    gas,
    mixing_drum,
    packings,
    sandpile,
    shear,
    silo,
)
from studies.benchmarks.impacts import SOLVERS

ROOT = Path(__file__).parents[2]
_IMPACTS = "python -m studies.benchmarks impacts"


@dataclass(frozen=True)
class Records:
    """What the benchmarks of this study keep.

    Parameters
    ----------
    impacts, gases, packings, sheared, silos, drums, piles, mixed : mapping
        Records by run.
    """

    impacts: comparisons.Records
    gases: Mapping[gas.Gas, Mapping[str, Any]]
    packings: Mapping[packings.Packing, Mapping[str, Any]]
    sheared: shear.Records
    silos: Mapping[silo.Silo, Mapping[str, Any]]
    drums: Mapping[drum_parts.Part, Mapping[str, Any]]
    piles: Mapping[sandpile.Pile, Mapping[str, Any]]
    mixed: Mapping[mixing_drum.Drum, Mapping[str, Any]]


@dataclass(frozen=True)
class Result:
    """What a benchmark gave on a solver.

    Parameters
    ----------
    words : str
        Value or deviation, with its unit.
    is_met : bool
        Whether it agrees with the reference.
    """

    words: str
    is_met: bool

    def __str__(self) -> str:
        return self.words if self.is_met else f"**{self.words}**"


@dataclass(frozen=True)
class Evidence:
    """A row of the table.

    Parameters
    ----------
    benchmark, reference : str
        What is compared, and with what.
    results : mapping of str to Result
        By solver; a solver that has not been run is left out.
    command : str
        That gave the figures.
    """

    benchmark: str
    reference: str
    results: Mapping[str, Result]
    command: str


def evidence(records: Records) -> list[Evidence]:
    """Return all rows."""
    return [
        *_impacts(records.impacts),
        *_gas(records.gases),
        *_packings(records.packings),
        *_shear(records.sheared),
        *_silo(records.silos),
        _mixing(records.mixed),
        *_drum(records.drums),
        *_piles(records.piles),
        *_janssen(),
        _compressed(),
        _critical(),
        *_pages(),
        _disagreement(),
    ]


# --- elementary impacts ---------------------------------------------------------------------------

#: Impacts, kind of reference, and the words of both.
_SUMMARY = (
    ((1, 2), comparisons.CLOSED, "elastic impacts (tests 1, 2)", "time, force, rebound of Hertz"),
    ((3,), comparisons.CLOSED, "normal restitution (test 3)", "that of the material"),
    ((4,), comparisons.SLIDING, "oblique impact (test 4), sliding", "closed form"),
    ((4,), comparisons.PUBLISHED, "oblique impact (test 4)", "published DEM"),
    ((4,), comparisons.EXPERIMENT, "oblique impact (test 4)", "experiment"),
    ((5,), comparisons.SLIDING, "recoil (test 5), sliding", "closed form"),
    ((5,), comparisons.PUBLISHED, "recoil (test 5)", "published DEM"),
    ((6, 8), comparisons.SLIDING, "spinning spheres (tests 6, 8), sliding", "rigid bodies"),
    ((6, 8), comparisons.PUBLISHED, "spinning spheres (tests 6, 8)", "published DEM"),
    ((7,), comparisons.CLOSED, "opposite spins (test 7)", "unchanged"),
)


def _impacts(records: comparisons.Records) -> Iterator[Evidence]:
    found = list(comparisons.rows(records))
    for tests, kind, benchmark, reference in _SUMMARY:
        chosen = [r for r in found if r.comparison.test in tests and r.comparison.reference == kind]
        results = {}
        for solver in SOLVERS:
            known = [row for row in chosen if solver in row.deviations]
            if known:
                worst = max(row.deviations[solver][1] for row in known)
                is_met = all(row.is_met(solver) for row in known)
                results[solver] = Result(percent(worst), is_met)
        if kind == comparisons.EXPERIMENT:
            allowed = max(row.comparison.tolerance for row in chosen)
            reference += f" (the paper's own DEM: {100 * allowed:.2g} %)"
        yield Evidence(benchmark, reference, results, _IMPACTS)


def percent(share: float) -> str:
    """Return a share in percent, in words."""
    if share < 0.001:
        return "< 0.1 %"
    return f"{100 * share:.1f} %" if share < 0.1 else f"{100 * share:.0f} %"


# --- bulk -----------------------------------------------------------------------------------------


def _gas(records: Mapping[gas.Gas, Mapping[str, Any]]) -> Iterator[Evidence]:
    solvers = [solver for solver in SOLVERS if any(run.solver == solver for run in records)]
    command = "python -m studies.benchmarks gas"
    grown = {solver: gas.growth(records, solver) for solver in solvers}
    results = {s: Result(percent(max(share, 0.0)), share <= 0.001) for s, share in grown.items()}
    yield Evidence("energy that an elastic gas gains", "none", results, command)
    cooled = {solver: gas.cooling(records, solver) for solver in solvers}
    results = {
        s: Result(f"{100 * (mean - 1):+.1f} % ± {100 * half:.1f} %", abs(mean - 1) <= 0.05)
        for s, (mean, half) in cooled.items()
    }
    yield Evidence("cooling of a gas, restitution 0.9", "Haff, Enskog", results, command)


def _packings(records: Mapping[packings.Packing, Mapping[str, Any]]) -> Iterator[Evidence]:
    command = "python -m studies.benchmarks packings"
    for friction, isostatic in packings.ISOSTATIC.items():
        solids, contacts = {}, {}
        for solver in SOLVERS:
            if not any((run.solver, run.friction) == (solver, friction) for run in records):
                continue
            solid, found = packings.without_overlap(records, solver, friction)
            is_met = abs(solid.value / packings.CLOSE - 1) <= 0.02
            solids[solver] = Result(_with_error(solid, 3), is_met)
            is_met = abs(found.value / isostatic - 1) <= 0.05
            contacts[solver] = Result(_with_error(found, 2), is_met)
        words = "smooth spheres" if friction == 0 else f"spheres with a friction of {friction:g}"
        yield Evidence(f"contacts in a bed of {words}", f"{isostatic:g}", contacts, command)
        if friction == 0:
            reference = f"{packings.CLOSE} (random close)"
            yield Evidence(f"solid fraction of {words}", reference, solids, command)


def _with_error(found: Response, digits: int) -> str:
    words = f"{found.value:.{digits}f}"
    error = found.standard_error
    return f"{words} ± {error:.{digits}f}" if error else words


def _shear(records: shear.Records) -> Iterator[Evidence]:
    """Compare the limit of no inertia at all frictions with what is published."""
    command = "python -m studies.benchmarks shear"
    frictions = ", ".join(f"{friction:g}" for friction in shear.PUBLISHED)
    limits = {
        solver: [found for of in shear.PUBLISHED if (found := shear.limit(records, solver, of))]
        for solver in SOLVERS
    }
    known = {s: found for s, found in limits.items() if len(found) == len(shear.PUBLISHED)}
    expected = [shear.angle_of(ratio) for ratio, _ in shear.PUBLISHED.values()]
    solid = [fraction for _, fraction in shear.PUBLISHED.values()]
    angles = {s: [found.angle for found in one] for s, one in known.items()}
    solids = {s: [found.solid_fraction for found in one] for s, one in known.items()}
    for of, digits, values, published, tolerance in (
        ("angle", ".1f", angles, expected, 1.0),
        ("solid fraction", ".3f", solids, solid, 0.02 * min(solid)),
    ):
        unit = "°" if of == "angle" else ""

        def words(numbers: Sequence[float], digits: str = digits, unit: str = unit) -> str:
            return ", ".join(f"{number:{digits}}{unit}" for number in numbers)

        yield Evidence(
            f"{of} of slow shear, friction {frictions}",
            f"{words(published)} (published DEM)",
            {
                s: Result(words(one), np.abs(np.subtract(one, published)).max() <= tolerance)
                for s, one in values.items()
            },
            command,
        )


def _silo(records: Mapping[silo.Silo, Mapping[str, Any]]) -> Iterator[Evidence]:
    """Compare the flow out of either orifice with published ones, of eight programs."""
    command = "python -m studies.benchmarks silo"
    rates, ratios = {}, {}
    for solver in SOLVERS:
        small, large = (silo.part_of(records, solver, orifice) for orifice in (40, 60))
        if large is None or small is None:
            continue
        rate, other = silo.flow(large).rate, silo.flow(small).rate
        off = rate / silo.RATE - 1
        rates[solver] = Result(
            f"{rate / 1000:.1f}e3 ({100 * off:+.1f} %)", abs(off) <= silo.RATE_WITHIN
        )
        error = silo.ratio_error(small, large)
        is_met = abs(rate / other - silo.RATIO) <= silo.RATIO_WITHIN + 2 * error
        ratios[solver] = Result(f"{rate / other:.2f} ± {error:.2f}", is_met)
    yield Evidence(
        "flow out of a silo, 60 mm, particles a second",
        f"{silo.RATE / 1000:.1f}e3 ± {100 * silo.RATE_WITHIN:.0f} % (eight programs)",
        rates,
        command,
    )
    reference = f"{silo.RATIO:.2f} ± {silo.RATIO_WITHIN} (eight programs)"
    yield Evidence("its ratio to that out of 40 mm", reference, ratios, command)


def _mixing(records: Mapping[mixing_drum.Drum, Mapping[str, Any]]) -> Evidence:
    """Compare where the spheres of a mixing drum are with published counts, of two programs."""
    results = {}
    for solver, record in mixing_drum.drums_of(records).items():
        worst = float(mixing_drum.deviations(record).max())
        results[solver] = Result(f"{100 * worst:.1f} %", worst <= mixing_drum.AGREES)
    own = float(mixing_drum.published_deviations(mixing_drum.TIME).max())
    names = " and ".join(mixing_drum.PROGRAMS.values())
    return Evidence(
        "mixing drum, two materials: spheres in a quarter, mean difference",
        f"{names}, {100 * own:.1f} % apart",
        results,
        "python -m studies.benchmarks mixing",
    )


def _drum(records: Mapping[drum_parts.Part, Mapping[str, Any]]) -> Iterator[Evidence]:
    """Compare drums like published simulated ones with their particles."""
    for speed, (published, _) in drum_parts.published().items():
        results = {}
        for solver, part in drum_parts.like_the_published(speed).items():
            if part in records:
                off = records[part]["angle"] - published
                words = f"{records[part]['angle']:.1f}° ({off:+.1f}°)"
                results[solver] = Result(words, abs(off) <= drum_parts.AGREES)
        if not results:
            continue
        yield Evidence(
            f"drum of 84 mm, cellulose, {speed} rpm",
            f"{published:.1f}° ± {drum_parts.AGREES:g}° (published DEM)",
            results,
            "python -m studies.benchmarks drum",
        )


def _piles(records: Mapping[sandpile.Pile, Mapping[str, Any]]) -> Iterator[Evidence]:
    """Compare the heights of sandpiles by rolling model."""
    for model, name in sandpile.NAMES.items():
        published = {source: of[model][0] for source, of in sandpile.PUBLISHED.items()}
        results = {}
        for solver in SOLVERS:
            record = records.get(sandpile.Pile(solver, model))
            if record is not None:
                off = [sandpile.formed(record) / height - 1 for height in published.values()]
                shares = ", ".join(f"{100 * share:+.0f} %" for share in off)
                is_met = max(map(abs, off)) <= sandpile.AGREES
                results[solver] = Result(f"{sandpile.formed(record):.3f} m ({shares})", is_met)
        yield Evidence(
            f"height of a sandpile, {name}",
            ", ".join(f"{height:.3f} m ({source})" for source, height in published.items()),
            results,
            "python -m studies.benchmarks sandpile",
        )


def _janssen() -> Iterator[Evidence]:
    """Compare the floor's share of the weight with Janssen's formula for the same bed."""
    records = _kept("janssen")
    new = ", law of `new`"
    for key, law, tolerance, benchmark, reference in (
        ("after_sum", "", 0.005, "weight of a bed on floor and walls", "its weight"),
        ("hold_floor", "own", 0.1, "load on the floor, after a fill", "Janssen"),
        ("hold_floor", "new", 0.1, f"load on the floor, after a fill{new}", "Janssen"),
        ("after_floor", "own", 0.1, "load on the floor, lowered by 0.5 d", "Janssen"),
        ("after_floor", "new", 0.1, f"load on the floor, lowered by 0.5 d{new}", "Janssen"),
    ):
        worst: dict[str, float] = defaultdict(float)
        for record in records:
            if law not in ("", record["law"]):
                continue
            found = record["responses"]
            expected = 1.0 if key == "after_sum" else found["after_janssen"]
            off = abs(found[key] / expected - 1)
            worst[record["solver"]] = max(worst[record["solver"]], off)
        results = {s: Result(percent(off), off <= tolerance) for s, off in worst.items()}
        command = "python benchmarks/janssen.py --kept benchmarks/data/janssen.jsonl --table"
        if results:
            yield Evidence(benchmark, reference, results, command)


def _compressed() -> Evidence:
    """Compare loose with dense beds of the triaxial test after isotropic compression.

    Solid fractions of 0.593 with a friction of 0.3, and 0.639 without: Agnolin & Roux,
    arXiv:0705.3194, abstract. Overlaps and walls change both by nearly the same factor.
    """
    records = _kept("triaxial")

    def density(friction: float) -> float:
        # Runs of one seed have the same bed at first, whatever follows.
        of_seeds = {
            record["seed"]: record["responses"]["initial_density"]
            for record in records
            if (record["solver"], record["initial_friction"]) == ("lammps", friction)
        }
        return fmean(of_seeds.values())

    published, found = 0.593 / 0.639, density(0.3) / density(0.0)
    return Evidence(
        "density of a pressed bed with a friction of 0.3 over that without",
        f"{published:.3f} (published DEM)",
        {"lammps": Result(f"{found:.3f}", abs(found / published - 1) <= 0.02)},
        "python benchmarks/triaxial.py --kept benchmarks/data/triaxial.jsonl --table",
    )


def _critical() -> Evidence:
    """Compare critical angles of the triaxial test at two frictions.

    From 0.3 on they no longer rise: Gong, Zou, Zhao, Li & Nie (2019), Computers and Geotechnics,
    abstract, of ellipsoids.
    """
    records = [r for r in _kept("triaxial") if r["solver"] == "lammps" and r["axial_strain"] == 0.5]
    low, high = (
        fmean(
            r["responses"]["critical_friction_angle"] for r in records if r["friction"] == friction
        )
        for friction in (0.3, 0.5)
    )
    return Evidence(
        "critical angle at a friction of 0.5 less that at 0.3",
        "0° (published DEM, ellipsoids)",
        {"lammps": Result(f"{high - low:+.1f}°", abs(high - low) <= 1)},
        "python benchmarks/triaxial.py --kept benchmarks/data/triaxial.jsonl --table",
    )


def _pages() -> Iterator[Evidence]:
    """Read the figures of commands whose output stands on a page."""
    hopper, page = "docs/developers/evidence.md", "docs/developers/benchmarks.md"
    new = ", law of `new`"
    for law, outlet, c, k in (
        ("", "round", 0.58, 1.4),
        ("", "slot", 1.04, 1.4),
        (new, "round", 0.58, 1.4),
        (new, "slot", 1.04, 1.4),
    ):
        *_, found_k, found_c = _row(hopper, f"lammps{law} | {outlet}")
        is_met = abs(float(found_c) / c - 1) <= 0.1 and abs(float(found_k) - k) <= 0.2
        yield Evidence(
            f"flow out of a {outlet} outlet, C and k{law}",
            f"{c} and {k} (Beverloo)",
            {"lammps": Result(f"{found_c} and {found_k}", is_met)},
            "python benchmarks/hopper.py --kept benchmarks/data/hopper.jsonl --table",
        )
    wheat = {"lammps": _row(page, "0.4 | 1")[2]}
    command = "wheat_drum.py --kept wheat.jsonl --slidings 0.4"
    yield _angle("wheat in a drum", 36.17, 3.1, wheat, command)
    lined = {"lammps": _row(page, "lined | 0.4")[3]}
    command = "lethe_drum.py --kept drum.jsonl --seeds 2 --walls lined smooth"
    yield _angle("drum of 6,000 spheres", 26.0, 1.0, lined, command)
    piles = {
        solver.lower(): _row(page, f"{solver} | periodic | 0.1 | 0.2")[5]
        for solver in ("LAMMPS", "LIGGGHTS")
    }
    yield _angle("pile in a plate box", 19.7, 1.0, piles, "plate_discharge.py --kept plate.jsonl")
    braked = {"liggghts": _row(page, "LIGGGHTS, constant torque | end walls | 0.1 | 0.2")[5]}
    command = (
        "plate_discharge.py --kept plate.jsonl --solver constant_torque --end-walls --depth 0.1"
    )
    yield _angle("the same, published rolling model, end walls", 19.7, 1.0, braked, command)


def _kept(benchmark: str) -> list[dict[str, Any]]:
    """Read what a benchmark keeps."""
    path = ROOT / "benchmarks" / "data" / f"{benchmark}.jsonl"
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def _row(page: str, start: str) -> list[str]:
    """Return the cells of the row of a table on a page that begins with these."""
    text = (ROOT / page).read_text(encoding="utf-8")
    rows = re.findall(rf"^\| {re.escape(start)} \|.*$", text, re.MULTILINE)
    assert len(rows) == 1, (page, start, len(rows))
    return [cell.strip() for cell in rows[0].strip("|").split("|")]


def _angle(
    benchmark: str, published: float, tolerance: float, found: Mapping[str, str], command: str
) -> Evidence:
    """Return angles in degrees beside a published one."""
    results = {}
    for solver, cell in found.items():
        angle = float(cell.split("°")[0])
        off = angle - published
        results[solver] = Result(f"{angle:g}° ({off:+.1f}°)", abs(off) <= tolerance)
    reference = f"{published:g}° ± {tolerance:g}°"
    return Evidence(benchmark, reference, results, f"python benchmarks/{command}")


def _disagreement() -> Evidence:
    """Return how far the second published calibration is from photographs it was not fitted to."""
    off = {
        speed: predicted["second"] - angle
        for calibration, speed, angle, predicted in disagreement.predictions()
        if calibration == "second" and speed not in disagreement.FITTED["second"]
    }
    words = ", ".join(f"{value:+.1f}° at {speed} rpm" for speed, value in off.items())
    is_met = max(map(abs, off.values())) <= disagreement.AGREES
    return Evidence(
        "published calibration of cellulose, speeds held out",
        "photographs",
        {"published look-up": Result(words, is_met)},
        "python -m studies.benchmarks page",
    )
