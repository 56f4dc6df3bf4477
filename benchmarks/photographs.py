"""Measure rendered photographs of heaps whose angle is known.

Cones of beads from 10 to 45 degrees, pale, dark, coloured and glossy, with and without a plate,
from the height of the plate up to the angle less 8 degrees, rolled by up to 5 degrees, with
perspective, uneven light, dark corners, shadows, texture, blur, noise and JPEG from 40 to 95 %; and
pictures that no one can measure. Finished pictures are kept in the file ``--kept`` and not
repeated, so that the command can be stopped and started again.

    python -m benchmarks.photographs --kept benchmarks/data/photographs.jsonl [--pictures 300]
        [--unusable 60] [--first 0] [--table]

Prints the error against the angle that the same fit finds on the true silhouettes of the flanks in
view, the bias, how often the stated uncertainty covers it, and what was refused.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from grainfit.errors import NotMeasurableError
from grainfit.photographs.photo import photo
from tests.photographs.drawn_pictures import UNUSABLE, unusable, usable
from tests.photographs.rendered_pictures import Shot, save, true_angle, whole_angle

#: Half of a normal interval of 95 %.
_COVER = 1.96


def record_of(number: int, good: bool) -> dict[str, Any]:
    """Render and measure once."""
    shot = usable(number) if good else unusable(number)
    record: dict[str, Any] = {"number": number, "good": good}
    if good:
        record |= {"true": true_angle(shot), "whole": whole_angle(shot.particles)}
        record |= {"elevation": shot.elevation, "plate": shot.plate_radius > 0}
    else:
        record |= {"kind": UNUSABLE[number % len(UNUSABLE)], "true": _truth(shot)}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"heap_{number}.jpg"
        save(shot, path, exif=True)
        try:
            found = photo(path)
        except NotMeasurableError as error:
            return record | {"refused": str(error).partition(".jpg: ")[2]}
    one = found.heaps[0][0]
    whole = found.angle_of_repose
    record |= {"angle": one.angle, "uncertainty": one.uncertainty, "parts": one.parts}
    return record | {"whole uncertainty": whole.standard_error, "by": one.seen_by}


def _truth(shot: Shot) -> float | None:
    try:
        return true_angle(shot)
    except NotMeasurableError:
        return None


def table(records: list[dict[str, Any]]) -> Iterator[str]:
    """Yield lines in Markdown."""
    good = [r for r in records if r["good"]]
    measured = [r for r in good if "angle" in r]
    yield "| pictures | measured | 95 % of the errors below | bias | covered | heap covered |"
    yield "|---|---|---|---|---|---|"
    kinds = {
        "all": measured,
        "plate seen": [r for r in measured if "plate" in r["by"]],
        "no plate seen": [r for r in measured if "foot" in r["by"]],
        "10 to 20°": [r for r in measured if r["true"] < 20],
        "20 to 32°": [r for r in measured if 20 <= r["true"] < 32],
        "32 to 45°": [r for r in measured if r["true"] >= 32],
    }
    for name, some in kinds.items():
        errors = np.array([r["angle"] - r["true"] for r in some])
        stated = np.array([r["uncertainty"] for r in some])
        whole = np.array([r["angle"] - r["whole"] for r in some])
        spread = np.array([r["whole uncertainty"] for r in some])
        yield (
            f"| {name} | {len(some)} | {np.quantile(np.abs(errors), 0.95):.2f}° | "
            f"{errors.mean():+.3f}° | {100 * np.mean(np.abs(errors) < _COVER * stated):.0f} % | "
            f"{100 * np.mean(np.abs(whole) < _COVER * spread):.0f} % |"
        )
    errors = np.array([abs(r["angle"] - r["true"]) for r in measured])
    covered = [abs(r["angle"] - r["true"]) < _COVER * r["uncertainty"] for r in measured]
    yield f"\nwithin 0.5 degrees: {_share(int((errors <= 0.5).sum()), len(errors))}"
    yield f"stated 95 % interval covers: {_share(sum(covered), len(covered))}"
    drawn = np.random.default_rng(1).choice(errors, (2000, len(errors)))
    for share in (0.5, 0.9, 0.95):
        low, high = np.quantile(np.quantile(drawn, share, axis=1), (0.025, 0.975))
        found = np.quantile(errors, share)
        yield f"{100 * share:.0f} % of the errors below {found:.2f}° ({low:.2f} to {high:.2f})"
    yield f"refused usable pictures: {_share(len(good) - len(measured), len(good))}"
    reasons = Counter(r["refused"][:48] for r in good if "refused" in r)
    yield from (f"  {count} x {reason}..." for reason, count in reasons.most_common())
    bad = [r for r in records if not r["good"]]
    if bad:
        yield f"refused unusable pictures: {_share(sum('refused' in r for r in bad), len(bad))}"
    for kind in UNUSABLE:
        some = [r for r in bad if r["kind"] == kind]
        yield f"{kind}: {sum('refused' in r for r in some)} of {len(some)} refused"
    wrong = [r for r in records if "angle" in r and not abs(r["angle"] - (r["true"] or 1e3)) <= 2.0]
    yield f"wrong by more than 2 degrees without a word: {len(wrong)} of {len(records)}"
    for r in wrong:
        kind = r.get("kind", "usable")
        yield f"  {kind} {r['number']}: {r['angle']:.1f} instead of {r['true'] or float('nan'):.1f}"


def _share(count: int, of: int) -> str:
    """Return a share with its 95 % interval (Clopper and Pearson)."""
    low, high = binomtest(count, of).proportion_ci()
    return f"{count} of {of} ({100 * low:.0f} to {100 * high:.0f} %)"


def main() -> None:
    """Measure the pictures that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, required=True)
    parser.add_argument("--pictures", type=int, default=300)
    parser.add_argument("--unusable", type=int, default=60)
    parser.add_argument("--first", type=int, default=0, help="number of the first picture")
    parser.add_argument("--table", action="store_true", help="print what is kept only")
    given = parser.parse_args()
    records = []
    if given.kept.exists():
        records = [json.loads(line) for line in given.kept.read_text().splitlines()]
    done = {(r["number"], r["good"]) for r in records}
    first = given.first
    wanted = [(n, True) for n in range(first, first + given.pictures)]
    wanted += [(n, False) for n in range(first, first + given.unusable)]
    # Some of both kinds, wherever the command is stopped.
    wanted.sort(key=lambda one: one[0] if one[1] else first + (one[0] - first) * 5)
    for number, good in [] if given.table else wanted:
        if (number, good) in done:
            continue
        records.append(record_of(number, good))
        with given.kept.open("a") as file:
            file.write(json.dumps(records[-1]) + "\n")
    print("\n".join(table(records)))


if __name__ == "__main__":
    main()
