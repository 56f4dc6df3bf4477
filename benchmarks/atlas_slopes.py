"""Slopes of the atlas beside those that trials measured at two materials.

The trials: 2^(6-2) designs of 16 runs with five in the centre, and single parameters, 291 runs on
LAMMPS about sliding and rolling friction 0.5 and 0.2, and 0.2 and 0.5. None of them is a row of the
atlas. Its slopes are those of the straight line over the same box. Nothing is simulated.

    python benchmarks/atlas_slopes.py

Prints a table in Markdown, and how well they agree.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.abilities import options_for
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.problem import Parameter
from grainfit.solvers.dem.lammps.program import Lammps
from grainfit.which_test.candidate import CandidateResponse
from grainfit.which_test.slopes import Cloud
from grainfit.which_test.told_by_atlas import told_responses
from size_series import DIAMETER, material_of
from slopes import FACTORS, MATERIALS

TRIALS = Path(__file__).parent / "data" / "trial_slopes.json"
TRIED = ("at_low_rolling", "at_high_rolling")
#: A slope that trials did not see is smaller than this.
UNSEEN = 0.05
COLUMNS = {
    "particle.density": "density",
    "particle.youngs_modulus": "Young's modulus",
    "particle_particle.sliding_friction": "sliding",
    "particle_particle.rolling_friction": "rolling",
    "particle_particle.restitution": "restitution",
    "particle_wall.sliding_friction": "wall",
}


def told(test: str, frictions: tuple[float, float]) -> tuple[CandidateResponse, ...]:
    """Return the responses of a test with the slopes of the atlas about a material."""
    sliding, rolling = frictions
    base = {
        **material_of(test),
        "particle_particle.sliding_friction": sliding,
        "particle_particle.rolling_friction": rolling,
    }
    parameters = [
        Parameter(name, base[name] / factor, min(base[name] * factor, _largest(name)), "log")
        for name, (factor, _) in FACTORS.items()
    ]
    kind = BUILT_IN[test]
    solver = Lammps(
        kind(diameter=DIAMETER, **options_for(kind, base)),
        {name: value for name, value in base.items() if name not in FACTORS},
    )
    return told_responses(test, solver, Cloud.even(parameters), lambda *_: Accuracy(0.0))


def _largest(name: str) -> float:
    return 0.95 if name.endswith("restitution") else np.inf


def rows(trials: Mapping[str, Mapping[str, Mapping[str, Mapping[str, float]]]]) -> Iterator[str]:
    """Yield the table, then how well slopes agree."""
    yield f"| test | response | {' | '.join(COLUMNS.values())} |"
    yield "|---" * (2 + len(COLUMNS)) + "|"
    pairs = []
    for test, responses in trials.items():
        found = [{one.short_name: one for one in told(test, at)} for at in MATERIALS]
        for name, measured in responses.items():
            if not all(name in one for one in found):
                continue
            cells = []
            for parameter in COLUMNS:
                slopes = [one[name].slopes[parameter] for one in found]
                known = [
                    measured[key].get(parameter) for key in ("at_low_rolling", "at_high_rolling")
                ]
                cells.append(_cell(slopes, known))
                pairs += [(s, 0.0 if k is None else k) for s, k in zip(slopes, known, strict=True)]
            yield f"| `{test}` | `{name}` | {' | '.join(cells)} |"
    atlas, trial = np.array(pairs).T
    seen = np.abs(trial) >= UNSEEN
    yield ""
    yield (
        f"{seen.sum()} slopes of at least {UNSEEN} in the trials: correlation "
        f"{np.corrcoef(atlas[seen], trial[seen])[0, 1]:.3f}, root mean square of the difference "
        f"{np.sqrt(np.mean((atlas - trial)[seen] ** 2)):.3f}, ratio of sizes "
        f"{np.sum(atlas[seen] * trial[seen]) / np.sum(trial[seen] ** 2):.2f}; of the other "
        f"{(~seen).sum()}, {100 * np.mean(np.abs(atlas[~seen]) < UNSEEN):.0f} % are below it."
    )


def _cell(slopes: list[float], known: list[float | None]) -> str:
    pairs = zip(slopes, known, strict=True)
    shown = [f"{s:+.2f} ({'–' if k is None else f'{k:+.2f}'})" for s, k in pairs]
    return (
        "; ".join(shown).replace("-", "−") if any(known) or max(map(abs, slopes)) > UNSEEN else ""
    )


def main() -> None:
    """Print the table."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    print("\n".join(rows(json.loads(TRIALS.read_text(encoding="utf-8")))))


if __name__ == "__main__":
    main()
