"""The container of the Dockerfile, where something can build it."""

from __future__ import annotations

import shutil
import subprocess
import uuid
from pathlib import Path

import pytest

import grainfit

ROOT = Path(__file__).parents[2]


def _can_build(program: str) -> bool:
    """Return whether a builder is installed, and whatever it needs is running."""
    found = shutil.which(program)
    return (
        found is not None and subprocess.run([found, "info"], capture_output=True).returncode == 0
    )


BUILDER = next((program for program in ("docker", "podman") if _can_build(program)), None)


@pytest.mark.slow
@pytest.mark.skipif(BUILDER is None, reason="no container builder runs here: docker, podman")
def test_the_container_has_grainfit_and_all_solvers() -> None:
    tag = f"grainfit-test-{uuid.uuid4().hex[:8]}"

    def execute(*arguments: str) -> str:
        done = subprocess.run(
            [str(BUILDER), *arguments], cwd=ROOT, capture_output=True, text=True, timeout=1800
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    execute("build", "--tag", tag, ".")
    try:
        assert grainfit.__version__ in execute("run", "--rm", tag, "--version")
        for solver in ("lmp", "liggghts", "yade"):
            execute("run", "--rm", "--entrypoint", "which", tag, solver)
    finally:
        execute("rmi", "--force", tag)
