"""The ``[cluster]`` table of the calibration file: jobs for the runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grainfit.calibration_file import messages
from grainfit.campaign.cluster.options import LONGEST_WALLTIME, SHORTEST_WALLTIME, ClusterOptions
from grainfit.campaign.cluster.schedulers import SCHEDULERS
from grainfit.errors import InputError
from grainfit.files import is_file
from grainfit.options.kinds import Choice, Kind, ListOf, Quantity, Schema, Text, Whole
from grainfit.options.paths import note_not_there
from grainfit.options.places import Place, show
from grainfit.options.python_file import PythonFile
from grainfit.options.tables import Key, Values


@dataclass(frozen=True)
class ParslConfiguration(Kind):
    """A Parsl configuration, ``"file.py:name"``, which is checked but not executed."""

    def read(self, value: Any, place: Place) -> str | None:
        """Read a reference to it; in the result, the path of its file is absolute."""
        text = Text().read(value, place)
        if text is None:
            return None
        folder = place.findings.folder
        remedy = 'Write the file and the name of the parsl.Config in it: "my_parsl.py:config".'
        try:
            file = PythonFile(text, folder)
        except InputError:
            place.fault(messages.NO_PARSL_CONFIG, given=show(text), remedy=remedy)
            return None
        if not is_file(file.path):
            note_not_there(text, folder, place)
            return None
        try:
            file.check()
        except InputError as error:
            for fault in error.faults:
                message = fault.message.replace("has no function", "has no")
                place.fault(
                    messages.BAD_PARSL_CONFIG, given=show(text), reason=message, remedy=remedy
                )
            return None
        return f"{file.path}:{file.function}"

    def schema(self) -> Schema:
        """Return the JSON Schema of a reference."""
        return {"type": "string", "pattern": r"\.py:\w+$"}


_COUNT = Whole(1, 4096)

CLUSTER = (
    Key("scheduler", Choice(tuple(SCHEDULERS)), "Scheduler of the cluster; slurm by default."),
    Key("partition", Text(), "Partition (queue) of the jobs; the scheduler's own by default."),
    Key("account", Text(), "Account (project) to charge; the scheduler's own by default."),
    Key(
        "walltime",
        Quantity("s", lowest=SHORTEST_WALLTIME, highest=LONGEST_WALLTIME),
        "Longest wall time of a job.",
        example='"2 h"',
    ),
    Key("jobs", _COUNT, "Largest number of jobs at a time; 1 by default.", example="4"),
    Key("runs_per_job", _COUNT, "Runs at a time in one job; 1 by default.", example="16"),
    Key("cores_per_run", _COUNT, "Cores that a run takes; the ranks of the tests by default."),
    Key(
        "setup",
        ListOf(Text()),
        "Shell lines that a job executes first.",
        example='["module load liggghts"]',
    ),
    Key(
        "options",
        ListOf(Text()),
        "Further directives for the scheduler.",
        example='["--mem=4G", "--constraint=skylake"]',
    ),
    Key(
        "parallel_environment",
        Text(),
        "Parallel environment of Grid Engine for several cores of one node; smp by default.",
    ),
    Key(
        "parsl",
        ParslConfiguration(),
        "Custom Parsl configuration instead: a file and the name in it.",
    ),
)


def cluster_options(values: Values, place: Place) -> ClusterOptions | None:
    """Build the options from the values read; None after noting their faults."""
    if None in values.values():
        return None
    try:
        return ClusterOptions(**values)
    except InputError as error:
        for fault in error.faults:
            place.at(fault.key).refuse(fault)
    return None
