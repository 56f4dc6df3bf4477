"""Photographs as an answer of the interview: named as one types them, measured as by a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.calibration_file.photographed import PHOTOS, PhotographedTarget
from grainfit.calibration_file.photos import PHOTOGRAPHED, photo_table
from grainfit.calibration_file.targets import TargetTable
from grainfit.campaign.work_folder import default_workdir
from grainfit.errors import InputError
from grainfit.options.places import Findings, KeyPath, Place
from grainfit.photographs.pictures import SUFFIXES

#: Keys of a target that are of its pictures alone.
OF_PICTURES = ("marker", "plate", "diameter", "elevation")


def takes_pictures(test: str, response: str) -> bool:
    """Return whether a response of a type of test is measured on photographs."""
    return response in PHOTOGRAPHED.get(test, ()) and response in BUILT_IN[test].responses


def named_pictures(given: str) -> list[str]:
    """Return the pictures that an answer names; none if it is anything else.

    Examples
    --------
    >>> named_pictures("heap 1.jpg; more/heap_*.png"), named_pictures("31; 32 deg")
    (['heap 1.jpg', 'more/heap_*.png'], [])
    """
    names = [name for part in given.split(";") if (name := part.strip())]
    return names if all(name.lower().endswith(SUFFIXES) for name in names) else []


def on_pictures(
    file: Path, place: KeyPath, test: str, target: Mapping[str, Any]
) -> PhotographedTarget | None:
    """Return what was measured on the pictures of a target; None if nothing was.

    Parameters
    ----------
    file : Path
        The calibration file, beside which pictures and work folder are.
    place : tuple
        Of the target in the file; its last key is the response.
    test : str
        Type of the test.
    target : mapping
        The target, with `PHOTOS`.
    """
    # Nothing is measured again here: the answer was measured when it was given.
    findings = Findings(file.parent.absolute(), work_folder=lambda: default_workdir(file))
    info = BUILT_IN[test].responses[str(place[-1])]
    try:
        photo_table(TargetTable(info.possible)).read(target, Place(findings, place))
    except InputError:
        return None
    return next(iter(findings.photographs), None)


def overlays(found: PhotographedTarget) -> tuple[Path, ...]:
    """Return the pictures on which is drawn what was measured, in the order of the originals."""
    drawn = (
        found.folder / f"{one.name}_{state}.png"
        for one in found.originals
        for state in ("measured", "refused")
    )
    return tuple(path for path in drawn if path.exists())


def is_of_pictures(target: Any) -> bool:
    """Return whether a target of a file names pictures."""
    return isinstance(target, dict) and isinstance(target.get(PHOTOS), list)
