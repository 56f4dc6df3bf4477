"""Measure several pictures one by one; those that cannot be measured are named with the reason."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from grainfit.errors import NotMeasurableError
from grainfit.evaluation import Response
from grainfit.photographs import messages
from grainfit.photographs.pictures import Picture, read_picture

Found = TypeVar("Found")


def measure_each(
    paths: Sequence[Path],
    measure: Callable[[Picture], Found],
    draw: Callable[[Path, Picture, Found | str], object],
    overlays: Path | None,
) -> tuple[list[Found], dict[Path, str]]:
    """Return what was found on each picture, and why others were not measured.

    Parameters
    ----------
    paths : sequence of Path
        The pictures.
    measure : callable
        Measures one; raises `NotMeasurableError`.
    draw : callable
        Draws in a folder what was found on one, or writes why it was refused.
    overlays : Path, optional
        That folder; None to draw nothing.

    Raises
    ------
    InputError
        A picture cannot be read.
    NotMeasurableError
        None can be measured, and why.
    """
    measured: list[Found] = []
    refused: dict[Path, str] = {}
    for path in paths:
        picture = read_picture(path)
        found: Found | str
        try:
            found = measure(picture)
            measured.append(found)
        except NotMeasurableError as error:
            found = refused[path] = str(error)
        if overlays is not None:
            draw(overlays, picture, found)
    if not measured:
        reasons = "\n".join(messages.REFUSED(path=p, reason=why) for p, why in refused.items())
        raise NotMeasurableError(
            messages.ALL_REFUSED(reasons=reasons) if len(refused) > 1 else reasons
        )
    return measured, refused


def mean_of_repeats(
    angles: Sequence[float], parts: Sequence[Mapping[str, float]], own: str
) -> tuple[Response, dict[str, float]]:
    """Return the mean of repeats with its standard uncertainty, and its parts by their source.

    Parameters
    ----------
    angles : sequence of float
        Of each picture, degrees.
    parts : sequence of mapping of str to float
        Standard uncertainties of each by their source, degrees.
    own : str
        The source that is another one in every picture; the others are those of one camera.
    """
    found = {name: math.sqrt(float(np.mean([p[name] ** 2 for p in parts]))) for name in parts[0]}
    if len(angles) > 1:
        found[own] /= math.sqrt(len(angles))
        scatter = float(np.std(angles, ddof=1)) / math.sqrt(len(angles))
        found = {"from picture to picture": scatter, **found}
    error = math.sqrt(sum(part**2 for part in found.values()))
    return Response(float(np.mean(angles)), error), found


def with_sources(found: Response, parts: Mapping[str, float]) -> str:
    """Return an angle in words, with the parts of its standard uncertainty by their source."""
    sources = ", ".join(f"{name} {part:.2f}°" for name, part in parts.items())
    return f"{found.value:.2f} ± {found.standard_error:.2f} deg ({sources})"
