"""``python -m studies.benchmarks``: make the benchmarks that are missing, and write their page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.kept_runs import measure
from grainfit.errors import GrainfitError
from studies.benchmarks import (
    drum_parts,
    gas,
    impacts,
    mixing_drum,
    packings,
    sandpile,
    shear,
    silo,
)
from studies.benchmarks.drum_pictures import measure_pictures
from studies.benchmarks.page import (
    KEPT,
    KEPT_DRUMS,
    KEPT_GASES,
    KEPT_MIXING,
    KEPT_PACKINGS,
    KEPT_PILES,
    KEPT_SHEAR,
    KEPT_SILOS,
    write_page,
)
from studies.names import one_of

#: Steps that simulate: runs of some solvers, where they are kept, what makes one.
SIMULATED: Mapping[str, tuple[Callable[..., Any], Path, Callable[..., Any]]] = {
    "impacts": (impacts.all_runs, KEPT, impacts.simulate),
    "gas": (gas.all_gases, KEPT_GASES, gas.simulate),
    "packings": (packings.all_packings, KEPT_PACKINGS, packings.simulate),
    "shear": (shear.all_sheared, KEPT_SHEAR, shear.simulate),
    "silo": (silo.all_silos, KEPT_SILOS, silo.simulate),
    "mixing": (mixing_drum.all_drums, KEPT_MIXING, mixing_drum.simulate),
    "drum": (drum_parts.all_parts, KEPT_DRUMS, drum_parts.simulate),
    "sandpile": (sandpile.all_piles, KEPT_PILES, sandpile.simulate),
}
#: Runs as they were published, for a cluster.
FULL_SIZE: Mapping[str, Callable[..., Any]] = {
    "silo": silo.full_silos,
    "mixing": mixing_drum.full_drums,
}
STEPS = (*SIMULATED, "pictures", "page")
app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Published figures that come out, or do not: killed and started again, it goes on.",
)


@app.command()
def main(
    steps: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[STEP]...",
            help=f"Of {', '.join(STEPS)}. By default, all but pictures.",
            parser=one_of("step", STEPS),
        ),
    ] = None,
    solvers: Annotated[
        list[str] | None,
        typer.Option("--solver", metavar="NAME", help="Of lammps, liggghts, yade. All by default."),
    ] = None,
    clones: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Clones of the repositories with pictures.")
    ] = None,
    full: Annotated[
        bool,
        typer.Option(
            "--full-size",
            help="Also silo and mixing drum as they were published: a day on one processor each.",
        ),
    ] = False,
) -> None:
    """Make the benchmarks, or some steps of them."""
    wanted = steps or [step for step in STEPS if step != "pictures"]
    try:
        for step, (runs_of, kept, simulate) in SIMULATED.items():
            chosen = solvers or impacts.SOLVERS
            if step in wanted and (runs := runs_of(chosen)):
                measure(runs, kept, simulate)
            if full and step in wanted and step in FULL_SIZE:
                measure(FULL_SIZE[step](chosen), kept, simulate)
    except GrainfitError as error:
        typer.echo(error, err=True)
        raise typer.Exit(1) from None
    if "pictures" in wanted:
        if clones is None:
            raise typer.BadParameter("Give the folder with the pictures: --clones DIR.")
        for path in measure_pictures(clones):
            typer.echo(path)
    if "page" in wanted:
        for path in write_page():
            typer.echo(path)


if __name__ == "__main__":
    app()
