"""Read the stages of a run from its log, and check that all of them ended well."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grainfit.errors import RunFailedError
from grainfit.files import log_tail

_LOGS = ("log.lammps", "log.liggghts")
_STAGE = re.compile(r"^STAGE (\w+) (\w+) (\d+) (\d+) (\S+)\s*$", re.MULTILINE)
_REMEDY = "a smaller time_step_fraction or more dissipative contacts may help"


@dataclass(frozen=True)
class Stage:
    """End of one stage.

    Parameters
    ----------
    name : str
        As in the deck, such as ``"fill"``.
    end : str
        ``"at_rest"``, ``"done"``, ``"restless"``, ``"unstable"`` or ``"broken"``.
    step : int
        Time step at its end.
    particles : int
        Particles then in the box.
    kinetic_energy : float
        J.
    """

    name: str
    end: str
    step: int
    particles: int
    kinetic_energy: float


def find_log(folder: Path) -> Path | None:
    """Return the log of the solver that ran in a folder, if there is one."""
    return next((folder / name for name in _LOGS if (folder / name).is_file()), None)


def read_stages(log: Path) -> list[Stage]:
    """Return the stages that a run has ended, in order."""
    text = log.read_text(encoding="utf-8", errors="replace")
    return [
        Stage(name, end, int(step), int(particles), float(energy))
        for name, end, step, particles, energy in _STAGE.findall(text)
    ]


def require_complete(
    log: Path, names: Sequence[str], particle_count: int, time_limit: float, container: str
) -> list[Stage]:
    """Raise `RunFailedError` unless every stage of a run went well; return the stages.

    Parameters
    ----------
    log : Path
        The solver's log.
    names : sequence of str
        The stages of the test, in order.
    particle_count : int
        Particles that were rained in.
    time_limit : float
        Simulated time that a bed had for coming to rest, s.
    container : str
        Container that particles may break out of.
    """
    stages = read_stages(log)
    for stage in stages:
        reason = _what_went_wrong(stage, particle_count, time_limit, container)
        if reason:
            raise RunFailedError(f"{reason}: {_REMEDY}", log_tail(log))
    if not stages or stages[-1].name != names[-1]:
        done = ", ".join(stage.name for stage in stages) or "none"
        raise RunFailedError(f"the simulation ended early (stages done: {done})", log_tail(log))
    return stages


def _what_went_wrong(stage: Stage, particle_count: int, time_limit: float, container: str) -> str:
    if not math.isfinite(stage.kinetic_energy):
        return (
            f"the simulation became unstable in the {stage.name} stage (kinetic energy "
            f"{stage.kinetic_energy:.3g} J)"
        )
    if stage.end == "restless":
        return (
            f"the bed did not come to rest in the {stage.name} stage within {time_limit:.3g} s of "
            f"simulated time (kinetic energy {stage.kinetic_energy:.3g} J)"
        )
    if stage.end == "unstable":
        return (
            f"the simulation became unstable in the {stage.name} stage (kinetic energy "
            f"{stage.kinetic_energy:.3g} J, more than gravity can give)"
        )
    if stage.end == "broken":
        return (
            f"the simulation became unstable in the {stage.name} stage: "
            f"{particle_count - stage.particles} of {particle_count} particles broke out of the "
            f"{container}"
        )
    return ""
