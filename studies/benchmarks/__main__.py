"""``python -m studies.benchmarks``: make the benchmarks that are missing, and write their page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from benchmarks.kept_runs import measure
from grainfit.errors import GrainfitError
from studies.benchmarks import impacts
from studies.benchmarks.drum_pictures import measure_pictures
from studies.benchmarks.page import write_page
from studies.benchmarks.published import DATA

STEPS = ("impacts", "pictures", "page")
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
            metavar="[STEP]...", help=f"Of {', '.join(STEPS)}. By default, impacts and page."
        ),
    ] = None,
    solvers: Annotated[
        list[str] | None,
        typer.Option("--solver", metavar="NAME", help="Of lammps, liggghts, yade. All by default."),
    ] = None,
    kept: Annotated[
        Path, typer.Option(metavar="FILE", help="Where finished impacts are kept.")
    ] = DATA / "impacts.jsonl",
    clones: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Clones of the repositories with pictures.")
    ] = None,
) -> None:
    """Make the benchmarks, or some steps of them."""
    wanted = steps or ["impacts", "page"]
    if unknown := [step for step in wanted if step not in STEPS]:
        raise typer.BadParameter(f"There is no step {unknown[0]!r}.")
    try:
        if "impacts" in wanted:
            measure(impacts.all_runs(solvers or impacts.SOLVERS), kept, impacts.simulate)
    except GrainfitError as error:
        typer.echo(error, err=True)
        raise typer.Exit(1) from None
    if "pictures" in wanted:
        if clones is None:
            raise typer.BadParameter("Give the folder with the pictures: --clones DIR.")
        for path in measure_pictures(clones):
            typer.echo(path)
    if "page" in wanted:
        for path in write_page(kept):
            typer.echo(path)


if __name__ == "__main__":
    app()
