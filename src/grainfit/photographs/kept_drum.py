"""Drums that are measured once: what was found is kept with the hashes of videos and stills."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grainfit.photographs.drum import DrumSize
from grainfit.photographs.drum_photo import (
    draw_overlays,
    mean_of_series,
    measure_series,
    speed_of,
)
from grainfit.photographs.kept import KeptPicture, version_of_code
from grainfit.photographs.kept_folder import kept_once
from grainfit.photographs.kept_frame import keep_frame


@dataclass(frozen=True)
class KeptSeries:
    """What is kept of a video, or of stills.

    Parameters
    ----------
    sha256 : str
        Hash of the video, or of the first still.
    frames : int
        Frames, or stills.
    seconds : float or None
        From the first frame to the last; None for stills.
    rises_right : bool
        Whether the bed rises to the right.
    fill_level : float
        Share of the drum that the bed takes.
    picture : KeptPicture or None
        Its first frame; None where an earlier version has measured it.
    """

    sha256: str
    frames: int
    seconds: float | None
    rises_right: bool
    fill_level: float
    picture: KeptPicture | None = None


@dataclass(frozen=True)
class KeptDrum:
    """What is kept of the videos and stills of a drum.

    Parameters
    ----------
    name : str
        Of its folder.
    version : str
        Of the code that measured it.
    responses : dict
        Angles with their standard uncertainties, degrees; empty if nothing could be measured.
    parts : dict
        Standard uncertainties of each angle by their source, degrees.
    series : tuple of KeptSeries
        What was measured.
    refused : dict
        Why others were not, by the hash of the file.
    speed : tuple of float or None
        Rotational speed and its standard error, rad/s; None where no mark is seen.
    """

    name: str
    version: str
    responses: Mapping[str, tuple[float, float]]
    parts: Mapping[str, Mapping[str, float]]
    series: tuple[KeptSeries, ...]
    refused: Mapping[str, str]
    speed: tuple[float, float] | None


def measure_drum_once(
    groups: Sequence[Sequence[Path]],
    hashes: Mapping[Path, str],
    folder: Path,
    *,
    size: DrumSize,
    level: float | None = None,
    marker: bool = False,
    keep_version: bool = False,
) -> KeptDrum:
    """Return what is on videos and stills: as it was kept, or else measured now, and kept.

    Parameters
    ----------
    groups : sequence of sequence of Path
        Videos, and stills; all single stills, and those of a folder, are of one series.
    hashes : mapping of Path to str
        SHA-256 of each.
    folder : Path
        Where what was found is kept, with the overlays.
    size : DrumSize
        Of the drum.
    level : float, optional
        Standard uncertainty of the camera's being level, degrees.
    marker : bool
        Whether the marker sheet must be seen.
    keep_version : bool
        Take what another version of the code has measured, too: a calibration rests on it.

    Raises
    ------
    InputError
        A file cannot be read.
    OSError
        What was found cannot be written.
    """
    what = [[[hashes[path] for path in group] for group in groups], size, level, marker]

    def measured(name: str) -> KeptDrum:
        series, refused = measure_series(groups, size, marker=marker)
        (folder / name).mkdir(parents=True, exist_ok=True)
        draw_overlays(folder / name, series, refused)
        responses, parts = mean_of_series(series, level) if series else ({}, {})
        angles = {angle: (one.value, one.standard_error) for angle, one in responses.items()}
        speed = speed_of(series)
        return KeptDrum(
            name,
            version_of_code(),
            angles,
            parts,
            tuple(
                KeptSeries(
                    hashes[one.path],
                    len(one.angles.bed.heights),
                    one.interval and (len(one.angles.bed.heights) - 1) * one.interval,
                    one.rises_right,
                    one.fill_level,
                    keep_frame(
                        KeptPicture(f"{name}/frame_{number}", hashes[one.path], version_of_code()),
                        one,
                        mean_of_series([one], level)[1]["dynamic_angle"],
                        angles,
                        folder,
                    ),
                )
                for number, one in enumerate(series, 1)
            ),
            {hashes[path]: why for path, why in refused.items()},
            None if speed is None else (speed.value, speed.standard_error),
        )

    stem = groups[0][0].stem
    return kept_once(folder, stem, what, KeptDrum, measured, keep_version=keep_version)
