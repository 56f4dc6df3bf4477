"""Check the atlas beyond the rows of an apparatus: half of a range predicts the other half.

For every dimension that a laboratory chooses (a fill height, an outlet), metamodels are fitted to
the rows in one half of its range, and predict those in the other, up to a whole range beyond, by
`ResponseModel.predict_beyond`. Then the halves change places. Responses follow the trend of smaller
apparatus and of stiffer particles in a compression: there one half predicts the other by
`ResponseModel.predict`.

    python benchmarks/atlas_beyond.py [--strata heap ...]

Prints a table in Markdown: rows predicted, their root mean square error, the one stated, which has
the scatter of a run in it, and the share within the 95 % intervals.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

from grainfit.arrays import Array
from grainfit.atlas.shelf import Atlas
from grainfit.atlas.strata import SIZE, Stratum, strata
from grainfit.atlas.surrogate import FEWEST_ROWS, ResponseModel, points_of, row_values
from grainfit.formatting import number


def table(atlas: Atlas, names: list[str]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield "| stratum | dimension | response | rows | RMSE | stated | inside 95 %, % |"
    yield "|---" * 7 + "|"
    inside: list[bool] = []
    for name in names:
        stratum = strata()[name]
        chosen = [one for one in stratum.varied.factors if one not in stratum.varied.bounded]
        for option in [*chosen, *_followed(stratum)]:
            for response in atlas.require(name).models:
                errors, stated = _errors(atlas, name, option, response)
                if len(errors) == 0:
                    continue
                own = np.abs(errors) <= 1.96 * stated
                inside += [*own]
                yield (
                    f"| {name} | {option} | {response} | {len(errors)} "
                    f"| {number(float(np.sqrt(np.mean(errors**2))), 3)} "
                    f"| {number(float(np.sqrt(np.mean(stated**2))), 3)} | {100 * own.mean():.0f} |"
                )
    yield f"\n{sum(inside)} of {len(inside)} ({100 * np.mean(inside):.1f} %) inside."


def _followed(stratum: Stratum) -> dict[str, bool]:
    """Return inputs whose trend is followed beyond their rows, and whether upwards."""
    stiff = (one for one, span in stratum.ranges.items() if span.reach > 1)
    return {SIZE: False, **dict.fromkeys(stiff, True)}


def _errors(atlas: Atlas, name: str, option: str, response: str) -> tuple[Array, Array]:
    """Return errors of the rows of either half by the other, and their standard deviations."""
    stratum, surrogate = strata()[name], atlas.require(name)
    every = [row for row in surrogate.rows if not row.is_repeat]
    rows = [row for row in every if response in row.responses]
    ranges = stratum.ranges
    points, column = points_of(rows, ranges), list(ranges).index(option)
    values, _ = row_values(stratum, response, rows)
    whole = surrogate.models[response]
    errors, stated = [], []
    followed = _followed(stratum)
    for is_lower in (followed[option],) if option in followed else (True, False):
        # Either half becomes the whole range: the other lies up to one range beyond it.
        at = points.copy()
        at[:, column] = 2 * at[:, column] - (0 if is_lower else 1)
        known = (at[:, column] >= 0) & (at[:, column] <= 1)
        if known.sum() < FEWEST_ROWS or known.all():
            continue
        of_half = [row for row, is_known in zip(rows, known, strict=True) if is_known]
        model = ResponseModel.fit(stratum, response, at[known], of_half, whole.chance)
        others = at[~known]
        mean, variance = (
            model.predict(others) if option in followed else model.predict_beyond(others, [column])
        )
        errors.append(values[~known] - mean)
        stated.append(np.hypot(np.sqrt(variance), whole.scatter(points[~known])))
    return np.concatenate([[], *errors]), np.concatenate([[], *stated])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    atlas = Atlas()
    parser.add_argument("--strata", nargs="+", choices=atlas.strata, default=list(atlas.strata))
    print("\n".join(table(atlas, parser.parse_args().strata)))


if __name__ == "__main__":
    main()
