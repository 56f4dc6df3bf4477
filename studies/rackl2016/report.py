"""Writes the page of the study: everything on it comes from the records."""

from __future__ import annotations

import os
import statistics
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean
from typing import Any

import jinja2

from grainfit.files import write_atomically
from studies.rackl2016 import peer, recovery, setting
from studies.rackl2016.findings import (
    Deviation,
    Findings,
    Row,
    deviation,
    names_upper_density_bound,
    parameter_errors,
    proposed_density,
)
from studies.rackl2016.plan import METHODS, task_name
from studies.rackl2016.setting import (
    ANGLE,
    BULK_DENSITY,
    DENSITY,
    PUBLISHED,
    RESPONSES,
    ROLLING_FRICTION,
    SEEDS,
)
from studies.rackl2016.tasks import Results

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "studies" / "rackl2016.md"
FIGURE = ROOT / "docs" / "images" / "rackl2016.png"
TEMPLATE = "rackl2016.md.jinja"
NOT_RUN = "not run yet"


def write_report(
    results: Results, workers: int, page: Path = PAGE, figure: Path = FIGURE
) -> list[Path]:
    """Write the page and its figure; return their paths."""
    findings = Findings(results)
    written = [page]
    page.parent.mkdir(parents=True, exist_ok=True)
    link = None
    if any(findings.rows(method) for method in METHODS) and _draw(findings, figure):
        written.append(figure)
        link = os.path.relpath(figure, page.parent)
    write_atomically(page, render(findings, workers, link))
    return written


def render(findings: Findings, workers: int, figure: str | None = None) -> str:
    """Return the page as text."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.filters |= {
        "signed": _signed,
        "percent": lambda value: f"{100 * value:.0f} %",
        "off": _off,
        "plain": lambda value: f"{value:.4g}",
        "seconds": _duration,
    }
    return environment.get_template(TEMPLATE).render(
        findings=findings,
        figure=figure,
        workers=workers,
        methods=METHODS,
        summaries={m: s for m in METHODS if (s := _summary(findings.whole(m)))},
        goals=findings.goals(),
        agreement=_agreement(findings),
        wide=_answers_of_wide_intervals(findings),
        narrow=_narrow(findings),
        unfavourable=_unfavourable(findings),
        modulus=findings.record("modulus"),
        modulus_truth=_truth_of_modulus(findings),
        recovered=_recovered(findings),
        disturbed=_disturbed(findings),
        octave=_octave(findings),
        setting=setting,
        recovery=recovery,
        peer=peer,
        not_run=NOT_RUN,
    )


def _draw(findings: Findings, path: Path) -> bool:
    """Draw the figure; without Plotly and what it needs for a PNG, say so and go on."""
    try:
        from studies.rackl2016.figures import draw

        draw(findings, path)
    except (ImportError, OSError, RuntimeError, ValueError) as reason:
        print(f"No figure: {' '.join(str(reason).split())}", file=sys.stderr)
        return False
    return True


def _signed(value: float | None) -> str:
    return "–" if value is None else f"{value:+.2f}"


def _off(deviation: Deviation | None) -> str:
    if deviation is None:
        return NOT_RUN
    return f"{deviation.percent:+.2f} ± {deviation.half_width:.2f}"


def _duration(seconds: float) -> str:
    return f"{seconds:.0f}"


def _summary(rows: Sequence[Row]) -> dict[str, Any] | None:
    """Means and extremes over the six calibrations, as the paper's text has them."""
    if not rows:
        return None
    return {
        "last": {name: _spread([row.at_last_run(name) for row in rows]) for name in RESPONSES},
        "expected": {
            name: _spread([off.percent if (off := row.expected(name)) else None for row in rows])
            for name in RESPONSES
        },
        "optimisation_runs": _spread([float(row.record["optimisation_runs"]) for row in rows], 0),
        "runs": fmean(row.runs for row in rows),
        "wall": fmean(row.cost.wall_seconds for row in rows),
        "processor": fmean(row.cost.processor_seconds for row in rows),
    }


def _spread(values: Sequence[float | None], digits: int = 2) -> str:
    known = [abs(value) for value in values if value is not None]
    if len(known) < len(values):
        return NOT_RUN
    low, high = min(known), max(known)
    return f"{low:.{digits}f} to {high:.{digits}f}, mean {fmean(known):.{max(1, digits)}f}"


def _agreement(findings: Findings) -> list[dict[str, Any]]:
    """What the paper says of its six calibrations, and what is found here, by method."""
    found = []
    for method in METHODS:
        rows = findings.whole(method)
        if rows:
            found.append(
                {
                    "method": METHODS[method],
                    "last": sum(_is_within(row) for row in rows),
                    "expected": sum(row.meets_targets() for row in rows),
                    "whole": all(row.truth for row in rows),
                    "ranges": {name: _against(rows, name) for name in PUBLISHED},
                    "by_width": [_mean_runs(rows, width) for width in setting.WIDTHS],
                    "by_seed": [_mean_expected_angle(rows, seed) for seed in SEEDS],
                }
            )
    return found


def _is_within(row: Row) -> bool:
    """Whether its last run meets the targets within the tolerances."""
    offs = [
        (row.at_last_run(n), 100 * setting.TOLERANCES[n] / setting.MEASURED[n]) for n in RESPONSES
    ]
    return all(off is not None and abs(off) <= accepted for off, accepted in offs)


def _against(rows: Sequence[Row], name: str) -> str:
    """Whether the mean lies within the range that was published."""
    if name == "optimisation_runs":
        values: list[float | None] = [float(row.record[name]) for row in rows]
    else:
        values = [row.at_last_run(name) for row in rows]
    known = [abs(value) for value in values if value is not None]
    if not known:
        return "no run"
    mean, published = fmean(known), PUBLISHED[name]
    if mean < published.smallest:
        return f"{mean:.2g}, below"
    return f"{mean:.2g}, {'above' if mean > published.largest else 'inside'}"


def _mean_runs(rows: Sequence[Row], width: float) -> str:
    return f"{fmean(r.record['optimisation_runs'] for r in rows if r.case.width == width):.1f}"


def _mean_expected_angle(rows: Sequence[Row], seed: int) -> str:
    offs = [row.expected(ANGLE) for row in rows if row.case.seed == seed]
    known = [off.percent for off in offs if off is not None]
    return f"{fmean(known):+.2f}" if len(known) == len(offs) else NOT_RUN


def _answers_of_wide_intervals(findings: Findings) -> tuple[float, float] | None:
    """Smallest and largest density that grainfit finds where the interval is wide."""
    rows = [row for m in ("staged", "sequential") for row in findings.whole(m)]
    found = [r.record["parameters"][DENSITY] for r in rows if r.case.width > setting.WIDTHS[0]]
    return (min(found), max(found)) if found else None


def _narrow(findings: Findings) -> list[dict[str, Any]]:
    """What grainfit says of the +-10 % interval, which ends near the answer."""
    rows = [row for m in ("staged", "sequential") for row in findings.rows(m)]
    return [
        {
            "method": METHODS[row.method],
            "seed": row.case.seed,
            "density": row.record["parameters"].get(DENSITY),
            "says_so": names_upper_density_bound(row.record),
            "notices": row.record["notices"],
        }
        for row in rows
        if row.case.width == setting.WIDTHS[0]
    ]


def _unfavourable(findings: Findings) -> list[dict[str, Any]]:
    found = []
    for seed in SEEDS:
        record = findings.record(f"unfavourable-{seed}")
        if record is not None:
            runs = record["design_runs"] + record["optimisation_runs"]
            proposal = proposed_density(record)
            found.append(record | {"seed": seed, "runs": runs, "proposal": proposal})
    return found


def _truth_of_modulus(findings: Findings) -> dict[str, Deviation] | None:
    truth = findings.record("modulus-truth")
    if truth is None:
        return None
    return {name: deviation(truth, name) for name in RESPONSES}


def _recovered(findings: Findings) -> dict[str, Any] | None:
    cases = findings.recovered()
    if not cases:
        return None
    errors = parameter_errors(cases)
    off = {name: sorted(abs(case.response_error(name)) for case in cases) for name in RESPONSES}
    return {
        "cases": cases,
        "parameters": {
            name: {"median": statistics.median(errors[name]), "largest": errors[name][-1]}
            for name in (DENSITY, ROLLING_FRICTION)
        },
        "responses": {
            name: {"median": statistics.median(off[name]), "largest": off[name][-1]}
            for name in (BULK_DENSITY, ANGLE)
        },
        "calibrated": sum(case.record["status"] == "calibrated" for case in cases),
        "coverage": {
            name: [findings.coverage(name, verified) for verified in (False, True)]
            for name in RESPONSES
        },
    }


def _disturbed(findings: Findings) -> list[str]:
    """Calibrations whose wall time says little, as something else used the machine."""
    return [
        task_name(method, row.case)
        for method in METHODS
        for row in findings.rows(method)
        if row.cost.was_disturbed
    ]


def _octave(findings: Findings) -> dict[str, str] | None:
    rows = [row for method in METHODS for row in findings.rows(method) if "octave" in row.record]
    return rows[0].record["octave"]["versions"] if rows else None
