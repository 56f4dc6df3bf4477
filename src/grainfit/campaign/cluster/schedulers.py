"""Schedulers of clusters: the command that submits a job, and the directives of a job script."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Scheduler:
    """A scheduler of jobs.

    Parameters
    ----------
    command : str
        Command that submits a job; empty where there are no jobs.
    example : str
        A directive that users add.
    form : Pattern
        Form of a directive, without what comes before it in a script.
    keys : mapping of str to str
        Directives that are a key of the calibration file, with that key.
    decided : tuple of str
        Directives that grainfit sets itself, to keep contact with its jobs.
    """

    command: str
    example: str = ""
    form: re.Pattern[str] = re.compile(r"-[A-Za-z]\w*(\s+\S.*)?")
    keys: Mapping[str, str] = field(default_factory=dict)
    decided: tuple[str, ...] = ()

    def key_of(self, option: str) -> str:
        """Return the key of the calibration file that a directive is; "" if it is none."""
        return next((key for name, key in self.keys.items() if self._is(option, name)), "")

    def decides(self, option: str) -> bool:
        """Return whether grainfit sets a directive itself."""
        return any(self._is(option, name) for name in self.decided)

    def _is(self, option: str, name: str) -> bool:
        words = " ".join(option.split())
        if name.startswith("--"):
            # sbatch understands the beginning of a name, too.
            return name.startswith(words.partition("=")[0])
        return words == name or re.match(rf"{re.escape(name)}[ =:]", words) is not None


#: By the name in a calibration file.
SCHEDULERS: Mapping[str, Scheduler] = {
    "slurm": Scheduler(
        "sbatch",
        "--mem=4G",
        re.compile(r"--[a-z][a-z0-9-]*(=.+)?"),
        {"--partition": "partition", "--account": "account", "--time": "walltime"},
        (
            *("--array", "--chdir", "--clusters", "--cpus-per-task", "--error", "--help"),
            *("--input", "--job-name", "--nodes", "--ntasks", "--ntasks-per-node", "--output"),
            *("--parsable", "--quiet", "--requeue", "--test-only", "--usage", "--version"),
            *("--wait", "--wrap"),
        ),
    ),
    "pbs": Scheduler(
        "qsub",
        ":mem=4gb",
        # What begins with a colon is added to the chunk of a job.
        re.compile(r"-[A-Za-z](\s+\S.*)?|(:[a-z]\w*=[^:\s]+)+"),
        {"-q": "partition", "-A": "account", "-l walltime": "walltime"},
        ("-N", "-o", "-e", "-S", "-J", "-j", "-r", "-I", "-z", "-l select", "-l nodes", "-l ncpus"),
    ),
    "sge": Scheduler(
        "qsub",
        "-l h_vmem=4G",
        keys={
            **{"-q": "partition", "-P": "account", "-l h_rt": "walltime"},
            "-pe": "parallel_environment",
        },
        decided=(
            *("-N", "-o", "-e", "-S", "-cwd", "-wd", "-t", "-terse", "-sync", "-r", "-j", "-b"),
            "-now",
        ),
    ),
    "lsf": Scheduler(
        "bsub",
        '-R "rusage[mem=4096]"',
        keys={"-q": "partition", "-P": "account", "-W": "walltime"},
        decided=("-J", "-o", "-oo", "-e", "-eo", "-n", "-nnodes", "-I", "-K", "-r", "-rn"),
    ),
    "local": Scheduler(""),
}
