"""Completion of arguments in the shell: run identities, parameters, materials, instruments."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

_SECTIONS = ("particle", "wall", "particle_particle", "particle_wall")
#: Keys of these sections that are no parameters.
_NO_PARAMETERS = ("diameter", "shape", "coarse_graining")
#: Characters of an identity that are completed: as many as the list of runs shows.
_SHOWN = 7


def complete_run(context: typer.Context, incomplete: str) -> list[str]:
    """Return the identities of the runs in the work folder before this argument."""
    from grainfit.campaign.store.source import open_source

    source = context.params.get("source")
    if not source:
        return []
    try:
        with open_source(source, "") as store:
            found = store.identities()
    except Exception:
        # A shell that waits for a completion has no place for a message.
        return []
    return sorted(identity[:_SHOWN] for identity in found if identity.startswith(incomplete))


def complete_setting(incomplete: str) -> list[str]:
    """Return the parameters of the calibration file before this option, as ``NAME=``."""
    # An option that still lacks its value keeps Typer from reading the arguments. Bash has its own
    # variable for the words, the other shells have that of Typer.
    words = os.environ.get("COMP_WORDS") or os.environ.get("_TYPER_COMPLETE_ARGS", "")
    files = map(Path, words.split())
    file = next((path for path in files if path.suffix == ".toml" and path.is_file()), None)
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8-sig")) if file else {}
    except (OSError, ValueError):
        return []
    return [f"{name}=" for name in _parameters(document) if name.startswith(incomplete)]


def complete_material(incomplete: str) -> list[str]:
    """Return the starting materials."""
    from grainfit.materials.starting_materials import starting_material_names

    return [name for name in starting_material_names() if name.startswith(incomplete)]


def complete_instrument(incomplete: str) -> list[str]:
    """Return the instruments that a test can name."""
    from grainfit.bulk_tests.instrument import instrument_names

    return [name for name in instrument_names() if name.startswith(incomplete)]


#: Keys of a table that is the value of a parameter.
_VALUE = {"min", "max", "measured_angle", "photos"}


def _parameters(document: dict[str, Any]) -> Iterator[str]:
    for section in _SECTIONS:
        table = document.get(section)
        if not isinstance(table, dict):
            continue
        for key, value in table.items():
            if isinstance(value, dict) and not value.keys() & _VALUE:
                # A wall with a name.
                yield from (f"{section}.{key}.{own}" for own in value)
            elif section != "particle" or key not in _NO_PARAMETERS:
                yield f"{section}.{key}"
    if isinstance(own := document.get("parameters"), dict):
        yield from own
