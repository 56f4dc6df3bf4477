"""Programs whose rows the atlas admits: the first one, and releases that agree with it.

Rows belong to a revision of the physics (`grainfit.atlas.shelf`), not to a version of the program.
`grainfit.atlas.sentinels` compares a release with the rows that there are.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grainfit.files import write_atomically

#: Outcomes of the releases that were compared.
OUTCOMES = Path(__file__).parent / "admitted.json"


def admitted_programs(path: Path = OUTCOMES) -> frozenset[str]:
    """Return the programs, solver and version, whose rows are admitted."""
    found = _read(path)
    agreeing = (one["program"] for one in found["compared"] if one["agrees"])
    return frozenset({found["first"], *agreeing})


def record(outcome: Mapping[str, Any], path: Path = OUTCOMES) -> None:
    """Keep the outcome of a comparison, instead of an earlier one of the same program.

    Parameters
    ----------
    outcome : mapping
        Has the ``program``, and whether it ``agrees``.
    path : Path
        File of the outcomes.
    """
    found = _read(path)
    others = [one for one in found["compared"] if one["program"] != outcome["program"]]
    found["compared"] = [*others, dict(outcome)]
    write_atomically(path, json.dumps(found, indent=1) + "\n")


def _read(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found
