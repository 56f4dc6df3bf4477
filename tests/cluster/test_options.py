"""Options of a cluster, without one."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from grainfit.campaign import messages
from grainfit.campaign.cluster.executor import cluster_executor, describe_cluster, is_available
from grainfit.campaign.cluster.options import ClusterOptions
from grainfit.errors import GrainfitError, InputError

HOUR = ClusterOptions(walltime=3600.0)


def test_every_fault_of_the_options_is_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        ClusterOptions(
            partition="a\n#SBATCH --uid=0", walltime=30.0, jobs=0, options=("--nodes=9",)
        )
    assert [fault.key for fault in caught.value.faults] == [
        "jobs",
        "partition",
        "walltime",
        "options",
    ]


def test_a_walltime_that_no_job_has_is_told_in_words() -> None:
    with pytest.raises(InputError) as caught:
        ClusterOptions(walltime=30.0)
    assert messages.WALLTIME.is_in(str(caught.value), given="30 s")


def test_what_would_be_submitted_has_no_plural_of_one() -> None:
    line = describe_cluster(HOUR)[0]
    assert re.findall(r"\b1 (\w+)", line) == ["run", "job", "run", "core"]


@pytest.mark.parametrize(
    ("scheduler", "option", "words"),
    [
        ("slurm", "-l mem=4gb", "'--mem=4G'"),
        ("slurm", "--part=long", "partition"),
        ("pbs", "--mem=4G", "':mem=4gb'"),
        ("pbs", "-q long", "partition"),
        ("pbs", "-l walltime=2:00:00", "walltime"),
        ("pbs", "-l select=2:ncpus=4", "Remove it"),
        ("sge", "--mem=4G", "'-l h_vmem=4G'"),
        ("sge", "-pe mpi 8", "parallel_environment"),
        ("sge", "-o log", "Remove it"),
        ("lsf", "-W 120", "walltime"),
        ("lsf", "-n 16", "Remove it"),
    ],
)
def test_directives_are_those_of_the_scheduler(scheduler: str, option: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        ClusterOptions(scheduler, walltime=3600.0, options=(option,))
    [fault] = caught.value.faults
    assert fault.key == "options"
    assert words in str(fault)


def test_directives_that_are_a_users_are_passed_on() -> None:
    for scheduler, option in {
        "slurm": "--mem=4G",
        "pbs": "-l place=excl",
        "sge": "-l h_vmem=4G",
        "lsf": '-R "rusage[mem=4096]"',
    }.items():
        assert ClusterOptions(scheduler, walltime=3600.0, options=(option,)).options == (option,)


def test_a_scheduler_that_is_not_known_names_those_that_are() -> None:
    with pytest.raises(InputError, match="slurm, pbs, sge, lsf, local"):
        ClusterOptions("condor", walltime=3600.0)


def test_local_runs_here_and_needs_no_job(monkeypatch: pytest.MonkeyPatch) -> None:
    local = ClusterOptions("local", partition="short", options=("--mem=4G",))
    assert not is_available(local)
    [line] = describe_cluster(local)
    assert "on this machine" in line


@pytest.mark.parametrize(
    ("options", "key", "words"),
    [
        ({"scheduler": "pbs"}, "nodes_per_run", "Slurm"),
        ({"runs_per_job": 4}, "runs_per_job", "jobs"),
        ({"cores_per_run": 1}, "cores_per_run", "nodes_per_run"),
        ({"walltime": None, "parsl": "mine.py:config"}, "nodes_per_run", "Parsl"),
    ],
)
def test_a_run_over_several_nodes_is_the_only_one_of_its_job(
    options: dict[str, object], key: str, words: str
) -> None:
    with pytest.raises(InputError) as caught:
        ClusterOptions(**{"walltime": 3600.0, "nodes_per_run": 2} | options)
    [fault] = caught.value.faults
    assert fault.key == key
    assert words in str(fault)


@pytest.mark.parametrize("setup", ["", "a\nb", "a\rb", "a\u2028b"])
def test_a_line_of_the_setup_is_one_line(setup: str) -> None:
    with pytest.raises(InputError, match="setup"):
        ClusterOptions(walltime=3600.0, setup=(setup,))


def test_a_cluster_is_there_where_its_scheduler_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert not is_available(HOUR)
    sbatch = tmp_path / "sbatch"
    sbatch.touch(mode=0o755)
    assert is_available(HOUR)


def test_a_work_folder_that_scripts_of_jobs_cannot_have_is_refused(tmp_path: Path) -> None:
    with (
        pytest.raises(GrainfitError, match=r"my \$\(beads\)") as caught,
        cluster_executor(HOUR, tmp_path / "my $(beads)"),
    ):
        raise AssertionError("never here")
    assert messages.PATH_FOR_SCRIPTS.is_in(str(caught.value))


def test_without_parsl_it_is_said_how_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "parsl", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    with pytest.raises(GrainfitError, match=messages.NO_PARSL.pattern):
        cluster_executor(HOUR, tmp_path).__enter__()


def test_parsl_is_not_imported_unless_it_is_used() -> None:
    code = "import grainfit.cli.app, sys; sys.exit('parsl' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
