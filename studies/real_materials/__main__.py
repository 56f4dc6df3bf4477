"""``python -m studies.real_materials``: calibrate the materials, and write the table."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer

from studies.names import one_of
from studies.real_materials.page import KEPT, MATERIALS, ROOT, write_page

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Published materials, predicted: killed and started again, it goes on.",
)


@app.command()
def main(
    materials: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[MATERIAL]...",
            help=f"Of {', '.join(MATERIALS)}; all by default.",
            parser=one_of("material", MATERIALS),
        ),
    ] = None,
    workdir: Annotated[Path, typer.Option(metavar="DIR", help="Where runs are kept.")] = Path(
        "real_materials.study"
    ),
) -> None:
    """Run the calibrations that have no kept result, and write the table."""
    wanted = materials or list(MATERIALS)
    for name in wanted:
        kept = KEPT / name / "result.json"
        if not kept.exists():
            _calibrate(name, workdir / name, kept)
    print(write_page())


def _calibrate(name: str, folder: Path, kept: Path) -> None:
    file = ROOT / "examples" / name / "calibration.toml"
    command = [sys.executable, "-m", "grainfit", "run", str(file), "--workdir", str(folder)]
    # A calibration that does not end as calibrated is a result, too, and has an exit code.
    code = subprocess.run(command, check=False).returncode
    made = folder / "result.json"
    if not made.exists() or '"status": "interrupted"' in made.read_text(encoding="utf-8"):
        raise typer.Exit(code or 1)
    kept.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(made, kept)


if __name__ == "__main__":
    app()
