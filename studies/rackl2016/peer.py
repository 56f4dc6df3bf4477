"""The method's original tools as a peer: an Octave script with STK and optim, on the same heap.

The script in ``octave/`` was written from the paper's description. It asks for DEM runs, and they
are made here with the same decks and the same evaluation: those of the design and of one set of
finite differences in parallel, all others one after the other, as ``nonlin_residmin`` asks for
them. Octave is started again after an interruption; as it asks for the same runs, they come from
the store.
"""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from grainfit.errors import RunFailedError, SolverNotFoundError
from grainfit.problem import Problem
from grainfit.testing.materials import GLASS_BEADS
from studies.rackl2016.runs import Responses, Runs
from studies.rackl2016.setting import (
    DIAMETER,
    MEASURED,
    MODULUS,
    RESPONSES,
    TOLERANCES,
)

PROGRAM = "octave-cli"
INSTALL = "Install it with: apt-get install octave octave-stk octave-optim"
SCRIPTS = Path(__file__).parent / "octave"
#: The paper has no figures for these. Those are of the example of the program that its authors
#: published later, where they fit: end of a fit by the relative change of the sum of squares, most
#: iterations on the DEM. The share by which finite differences move is the default of optim.
TOLERANCE_OF_MISFIT, MOST_ITERATIONS, DIFFERENCE = 0.002, 4, 0.001


def settings_of(problem: Problem, seed: int, weight: float, design_runs: int) -> dict[str, Any]:
    """Settings for the script."""
    return {
        "lower": [p.minimum for p in problem.parameters],
        "upper": [p.maximum for p in problem.parameters],
        "seed": seed,
        "design_runs": design_runs,
        "rayleigh_weight": weight,
        "measured": [MEASURED[name] for name in RESPONSES],
        "tolerances": [TOLERANCES[name] / MEASURED[name] for name in RESPONSES],
        "radius": DIAMETER / 2,
        "youngs_modulus": GLASS_BEADS[MODULUS],
        "poissons_ratio": GLASS_BEADS["particle.poissons_ratio"],
        "tolerance_of_misfit": TOLERANCE_OF_MISFIT,
        "most_iterations": MOST_ITERATIONS,
        "difference": DIFFERENCE,
    }


def calibrate_with_octave(
    problem: Problem,
    settings: dict[str, Any],
    runs: Runs,
    folder: Path,
    on_end: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Let the script calibrate; return its result and the runs that it asked for, in order."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "settings.json"
    path.write_text(json.dumps(settings, indent=2), encoding="utf-8")
    names = [parameter.name for parameter in problem.parameters]
    history: list[dict[str, Any]] = []
    with _octave(path, folder / "octave.log") as octave:
        assert octave.stdout is not None
        assert octave.stdin is not None
        for line in octave.stdout:
            word, _, rest = line.partition(" ")
            if word == "RESULT":
                found: dict[str, Any] = json.loads(rest)
                return found | {"history": history}
            if word != "RUNS":
                continue
            purpose, points = _read_request(rest)
            orders = [(dict(zip(names, point, strict=True)), settings["seed"]) for point in points]
            made = runs.make(orders, on_end)
            history += [
                {"purpose": purpose, "parameters": order[0], "responses": responses}
                for order, responses in zip(orders, made, strict=True)
            ]
            octave.stdin.write(_reply(made))
            octave.stdin.flush()
    log = (folder / "octave.log").read_text(encoding="utf-8", errors="replace")
    raise RunFailedError(f"Octave gave no result. {INSTALL}", log[-800:])


@contextmanager
def _octave(settings: Path, log: Path) -> Iterator[subprocess.Popen[str]]:
    program = shutil.which(PROGRAM)
    if program is None:
        raise SolverNotFoundError(f"{PROGRAM} is not found. {INSTALL}")
    command = [program, "--norc", "--quiet", str(SCRIPTS / "calibrate.m"), str(settings.absolute())]
    with (
        log.open("w", encoding="utf-8") as stderr,
        subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=stderr,
            # When it is ended, it leaves its variables behind where it is.
            cwd=log.parent,
            text=True,
            encoding="utf-8",
        ) as octave,
    ):
        try:
            yield octave
        finally:
            octave.kill()


def _read_request(text: str) -> tuple[str, list[list[float]]]:
    purpose, rows, columns, *values = text.split()
    numbers, width = [float(value) for value in values], int(columns)
    if len(numbers) != int(rows) * width:
        raise RunFailedError(f"Octave asks for {rows} runs and gives {len(numbers)} numbers.")
    return purpose, [numbers[start : start + width] for start in range(0, len(numbers), width)]


def _reply(made: list[Responses]) -> str:
    rows = [[math.nan if run is None else run[name] for name in RESPONSES] for run in made]
    return " ".join(f"{value:.17g}" for row in rows for value in row) + "\n\n"
