"""Measure the responses of a finished run again, without simulating."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.registry import recreate_test
from grainfit.bulk_tests.response_info import absent_responses
from grainfit.campaign.absent_responses import why_absent
from grainfit.campaign.work_folder import RECORD_NAME, read_record
from grainfit.errors import InputError, NotMeasurableError
from grainfit.evaluation import Measured
from grainfit.measurement.angle_of_repose import angle_of_repose, heap_silhouettes, on_plate
from grainfit.measurement.heap_size import base_radius, heap_height
from grainfit.measurement.particles import Particles, read_dump
from grainfit.photographs.photo import photo
from grainfit.photographs.pictures import is_picture
from grainfit.scenes.run_output import RunOutput
from grainfit.work_folder import messages
from grainfit.work_folder.heap_scan import is_scan, measure_scan

#: Silhouettes of a heap in a dump: the default of the heap test.
_VIEWS = 12


def measure_path(path: Path) -> Mapping[str, Measured]:
    """Measure the responses in a run folder, or the heap in a dump or in a photograph.

    Parameters
    ----------
    path : Path
        A folder that holds a run's ``run.json``, a LAMMPS or LIGGGHTS text dump of a heap that
        stands on the plane z = 0, a photograph of a heap, or a scan of one.

    Raises
    ------
    InputError
        The path is none of these.
    NotMeasurableError
        What is there cannot be measured, with the reason.
    RunFailedError
        The run did not end as its test requires.
    """
    if path.is_dir():
        return _test_of(path).measure(RunOutput(path))
    if not path.is_file():
        raise InputError(messages.NOTHING_TO_MEASURE.fault("", path=str(path)))
    if is_scan(path):
        try:
            return {"angle_of_repose": measure_scan(path)}
        except NotMeasurableError as error:
            raise NotMeasurableError(f"{path}: {error}") from None
    if is_picture(path):
        return {"angle_of_repose": photo(path).angle_of_repose}
    particles = read_dump(path)
    if len(particles) == 0:
        raise NotMeasurableError(messages.NO_PARTICLES(path=path))
    try:
        return _measure_heap(particles)
    except NotMeasurableError as error:
        raise NotMeasurableError(f"{path}: {error}") from None


def absent_from(path: Path, found: Collection[str]) -> list[str]:
    """Return which responses the run in a folder is without, and why.

    Parameters
    ----------
    path : Path
        As of `measure_path`.
    found : collection of str
        Names of the responses that were measured there.
    """
    why = why_absent(absent_responses(_test_of(path)), found) if path.is_dir() else ""
    return [f"There is {why}."] if why else []


def _measure_heap(particles: Particles) -> Mapping[str, Measured]:
    reach = float(np.hypot(particles.positions[:, 0], particles.positions[:, 1]).max())
    diameter = particles.diameter
    silhouettes = heap_silhouettes(on_plate(particles, reach), reach, _VIEWS)
    angle = angle_of_repose(particles, diameter, reach, _VIEWS, silhouettes)
    return {
        "angle_of_repose": angle.response,
        "base_radius": base_radius(silhouettes, diameter, diameter),
        "heap_height": heap_height(silhouettes, diameter),
    }


def _test_of(folder: Path) -> BulkTest:
    """Rebuild the test that a run folder's record defines."""
    record = read_record(folder)
    if record is None:
        raise InputError(messages.NO_RUN_FOLDER.fault("", folder=str(folder), record=RECORD_NAME))
    try:
        test = recreate_test(record.definition)
    except InputError as error:
        record_path = str(folder / RECORD_NAME)
        faults = [replace(f, message=f"{record_path!r} {f.message}") for f in error.faults]
        raise InputError(faults) from error
    if test is None:
        raise InputError(messages.RUN_OF_OWN_MODEL.fault("", folder=str(folder)))
    return test
