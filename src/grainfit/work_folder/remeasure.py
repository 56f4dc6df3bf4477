"""Measure again what a run left behind, without simulating."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from grainfit.bulk_tests.heap import HeapTest
from grainfit.campaign.work_folder import RECORD_NAME, read_record
from grainfit.errors import Fault, InputError, NotMeasurableError
from grainfit.evaluation import Response
from grainfit.materials.sizes import ParticleSizes
from grainfit.measurement.angle_of_repose import angle_of_repose
from grainfit.measurement.particles import read_dump


def measure_path(path: Path) -> dict[str, Response]:
    """Measure the responses in a run folder, or the angle of repose on a dump of particles.

    Parameters
    ----------
    path : Path
        A folder that holds a run's ``run.json``, or a LAMMPS or LIGGGHTS text dump of a heap that
        stands on the plane z = 0.

    Raises
    ------
    InputError
        The path is neither.
    NotMeasurableError
        What is there cannot be measured, with the reason.
    RunFailedError
        The run did not go as its test must.
    """
    if path.is_dir():
        return _test_of(path).measure(path)
    if not path.is_file():
        raise InputError(
            Fault("", f"{str(path)!r} does not exist.", "Name a run folder or a dump.")
        )
    heap = read_dump(path)
    if len(heap) == 0:
        raise NotMeasurableError(f"{path}: its last frame has no particles.")
    reach = float(np.hypot(heap.positions[:, 0], heap.positions[:, 1]).max())
    angle = angle_of_repose(heap, ground=heap.diameter, plate_radius=reach)
    return {"angle_of_repose": angle.response}


def _test_of(folder: Path) -> HeapTest:
    """Make the test anew that a run folder's record tells of."""
    record = read_record(folder)
    if record is None:
        raise InputError(
            Fault(
                "",
                f"{str(folder)!r} is not a run folder: it has no {RECORD_NAME} that can be read.",
                "Name a folder below 'runs' of a work folder, or a dump.",
            )
        )
    test = record.definition.model.get("test")
    if not isinstance(test, Mapping) or test.get("type") != HeapTest.type:
        raise InputError(
            Fault(
                "",
                f"{str(folder)!r} is a run of your own model.",
                "Only built-in tests can be measured again.",
            )
        )
    try:
        return heap_test(test)
    except KeyError as error:
        reason = f"{error} is missing"
    except (TypeError, ValueError, AttributeError) as error:
        reason = str(error)
    raise InputError(
        Fault(
            "",
            f"{str(folder / RECORD_NAME)!r} does not define a heap test: {reason}.",
            "It was edited, or written by another version of grainfit.",
        )
    )


def heap_test(definition: Mapping[str, Any]) -> HeapTest:
    """Make a test anew from its definition.

    Raises
    ------
    KeyError, TypeError, ValueError, AttributeError
        The definition is not one, or not whole.
    """
    known = {**definition["setup"], **definition}
    options = {
        option.name: known[option.name]
        for option in fields(HeapTest)
        if option.init and option.name != "sizes"
    }
    sizes = ParticleSizes(tuple(definition["diameters"]), tuple(definition["mass_fractions"]))
    return HeapTest(sizes, **options)
