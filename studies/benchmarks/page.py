"""Write the page of the benchmarks, and the evidence table of the readme, from kept records."""

from __future__ import annotations

import re
from pathlib import Path

import jinja2

from benchmarks.kept_runs import read
from grainfit.files import write_atomically
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
from studies.benchmarks.evidence import ROOT, Records, evidence, percent
from studies.benchmarks.gas import Gas
from studies.benchmarks.impacts import SOLVERS, Run
from studies.benchmarks.published import DATA

NAMES = {"lammps": "LAMMPS", "liggghts": "LIGGGHTS", "yade": "YADE"}
_PAGE = ROOT / "docs" / "studies" / "benchmarks.md"
_IMAGES = ROOT / "docs" / "images"
_README = ROOT / "README.md"
#: Where finished runs are kept.
KEPT, KEPT_GASES = DATA / "impacts.jsonl", DATA / "gas.jsonl"
KEPT_PACKINGS, KEPT_SHEAR = DATA / "packings.jsonl", DATA / "shear.jsonl"
KEPT_SILOS, KEPT_DRUMS = DATA / "silo.jsonl", DATA / "drum.jsonl"
KEPT_PILES, KEPT_MIXING = DATA / "sandpile.jsonl", DATA / "mixing.jsonl"
_MARKED = re.compile("(?<=<!-- evidence -->\n).*(?=<!-- end of evidence -->)", re.DOTALL)


def write_page() -> list[Path]:
    """Write page, figures and table; return their paths."""
    # Figures need Pillow, and nothing else does.
    from studies.benchmarks.figures import (
        draw_disagreement,
        draw_impacts,
        draw_mixing,
        draw_shear,
    )

    records = kept_records()
    write_atomically(_PAGE, page(records))
    write_atomically(_README, readme(records))
    return [
        _PAGE,
        _README,
        draw_impacts(records.impacts, _IMAGES / "elementary_impacts.png"),
        draw_disagreement(_IMAGES / "two_calibrations.png"),
        draw_shear(records.sheared, _IMAGES / "sheared_spheres.png"),
        draw_mixing(records.mixed, _IMAGES / "mixing_drum.png"),
    ]


def kept_records() -> Records:
    """Return what is kept."""
    return Records(
        read(KEPT, Run),
        read(KEPT_GASES, Gas),
        read(KEPT_PACKINGS, packings.Packing),
        read(KEPT_SHEAR, shear.Sheared),
        read(KEPT_SILOS, silo.Silo),
        read(KEPT_DRUMS, drum_parts.Part),
        read(KEPT_PILES, sandpile.Pile),
        read(KEPT_MIXING, mixing_drum.Drum),
    )


def page(records: Records) -> str:
    """Return the page as text."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    rows = evidence(records)
    return environment.get_template("benchmarks.md.jinja").render(
        impacts=[_impact(row) for row in comparisons.rows(records.impacts)],
        seconds=comparisons.processor_seconds(records.impacts),
        beds={
            step: [row for row in rows if row.command.endswith(step)]
            for step in ("gas", "packings", "shear", "silo", "mixing", "drum", "sandpile")
        },
        silo=silo,
        silos=records.silos,
        mixing=mixing_drum,
        mixed=records.mixed,
        drum=drum_parts,
        drums=records.drums,
        programs={**NAMES, "constant_torque": "LIGGGHTS"},
        sandpile=sandpile,
        piles=records.piles,
        packings=packings,
        packed={
            solver: len({run.seed for run in records.packings if run.solver == solver})
            for solver in SOLVERS
            if any(run.solver == solver for run in records.packings)
        },
        ordered={run: records.packings[run] for run in packings.ordered(records.packings)},
        random_order=max(
            record["order"]
            for record in records.packings.values()
            if record["order"] <= packings.ORDERED
        ),
        shear=shear,
        overlap=shear.OVERLAP,
        sheared=[s for s in SOLVERS if any(run.solver == s for run in records.sheared)],
        limits=_limits(records.sheared),
        lower=max(
            one.angle - shear.angle_of(one.ratio)
            for of_friction in _limits(records.sheared).values()
            for one in of_friction.values()
        ),
        power=shear.power(records.sheared),
        rise=shear.rise(records.sheared),
        failed={run: record for run, record in records.sheared.items() if "why" in record},
        gas=gas,
        solvers=SOLVERS,
        names=NAMES,
        impulse=comparisons.sliding_impulse(records.impacts),
        published=comparisons.published_against_experiment,
        tolerance=comparisons.TOLERANCE,
        of_curves=comparisons.OF_CURVES,
        answers=disagreement.ANSWERS,
        fitted=disagreement.FITTED,
        photographed=disagreement.photographed(),
        predictions=disagreement.predictions(),
        agreement=disagreement.agreement(),
        agrees=disagreement.AGREES,
        ridge=disagreement.along_the_ridge(),
        search=disagreement.search_of_the_second(),
    )


def readme(records: Records) -> str:
    """Return the readme with its evidence table as the records give it."""
    header = f"| benchmark | reference | {' | '.join(NAMES.values())} | command |"
    lines = [header, "|---" * 6 + "|"]
    for row in evidence(records):
        cells = [str(row.results.get(solver, "")) for solver in SOLVERS]
        if "published look-up" in row.results:
            cells = [f"published look-up: {row.results['published look-up']}", "", ""]
        lines.append(
            f"| {row.benchmark} | {row.reference} | {' | '.join(cells)} | `{row.command}` |"
        )
    text = _README.read_text(encoding="utf-8")
    assert _MARKED.search(text)
    return _MARKED.sub(lambda _: "\n".join(lines) + "\n", text)


def _limits(records: shear.Records) -> dict[float, dict[str, shear.Limit]]:
    """Return the limits of no inertia by friction and solver."""
    return {
        friction: {
            solver: found for solver in SOLVERS if (found := shear.limit(records, solver, friction))
        }
        for friction in shear.FRICTIONS
    }


def _impact(row: comparisons.Row) -> dict[str, object]:
    unit, cells = row.comparison.unit, []
    for solver in SOLVERS:
        if solver not in row.deviations:
            cells.append("not run")
            continue
        worst, share = row.deviations[solver]
        words = percent(share)
        # Times and forces of different bodies have no common scale.
        if row.comparison.test > 2 and share >= 0.001:
            words = f"{worst:.2g}{unit if unit == '°' else f' {unit}'.rstrip()} ({words})"
        cells.append(words if row.is_met(solver) else f"**{words}**")
    return {"comparison": row.comparison, "cells": cells}
