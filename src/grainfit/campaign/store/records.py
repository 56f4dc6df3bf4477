"""What a store keeps: runs, calibrations, and what calibrations asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal, cast, get_args

from grainfit.evaluation import Response, Stage
from grainfit.run_definition import RunDefinition

RunStatus = Literal["running", "finished", "failed"]


@dataclass(frozen=True)
class RunRecord:
    """One run as the store knows it.

    Parameters
    ----------
    identity, test : str
        Identity of the run and name of the test that it is a run of.
    status : {"running", "finished", "failed"}
        A run that is not there was never started or did not end.
    definition : RunDefinition
        All that decides the outcome, as `Solver.definition` gave it.
    responses : mapping of str to Response
        Empty unless finished.
    reason, kind, log_tail : str
        Why it failed, whose fault it was, and the last lines of the log.
    seconds : float
        Wall time, s.
    ended : float
        When it ended, seconds since the epoch; for people only, clocks jump.
    origin : str
        Where it came from, when it was not made here: another store, or an imported table.
    """

    identity: str
    test: str
    status: RunStatus
    definition: RunDefinition
    responses: Mapping[str, Response] = field(default_factory=dict)
    reason: str = ""
    kind: str = ""
    log_tail: str = ""
    seconds: float = 0.0
    ended: float = 0.0
    origin: str = ""

    @property
    def may_succeed_next_time(self) -> bool:
        """Whether it failed for a reason that says nothing of the run itself."""
        return self.status == "failed" and self.kind in ("machine", "timeout")

    def to_json(self) -> dict[str, Any]:
        """Return plain data that `from_json` reads."""
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        responses = {name: asdict(found) for name, found in self.responses.items()}
        return {**own, "definition": self.definition.to_json(), "responses": responses}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> RunRecord:
        """Read what `to_json` wrote.

        Raises
        ------
        KeyError, TypeError, ValueError
            The data is not of a run.
        """
        if data["status"] not in get_args(RunStatus):
            raise ValueError(f"{data['status']!r} is not the status of a run")
        responses = {
            str(name): Response(float(found["value"]), float(found["standard_error"]))
            for name, found in _mapping(data["responses"]).items()
        }
        read = {
            "definition": RunDefinition.from_json(_mapping(data["definition"])),
            "responses": responses,
            "seconds": float(data["seconds"]),
            "ended": float(data["ended"]),
        }
        return cls(**{**data, **read})


@dataclass(frozen=True)
class CalibrationRecord:
    """A calibration that used this store.

    Parameters
    ----------
    identity, name : str
        What it is, and what it is called.
    definition : mapping
        All that decides what it asks for.
    status : str
        ``running``, or how it ended.
    started : float
        When it was started last, seconds since the epoch.
    known : sequence of str
        Identities of the runs that were there before its first start and that it learnt from.
    about : mapping
        What a report says of it besides, see `grainfit.calibration.provenance`; decides nothing.
    """

    identity: str
    name: str
    definition: Mapping[str, Any]
    status: str
    started: float
    known: Sequence[str] = ()
    about: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class RequestRecord:
    """One parameter set that a calibration asked for."""

    position: int
    stage: Stage
    parameters: Mapping[str, float]
    seed: int
    runs: Mapping[str, str]

    @classmethod
    def from_row(cls, row: Mapping[str, Any]) -> RequestRecord:
        """Read a row of the store.

        Raises
        ------
        KeyError, TypeError, ValueError
            The row is not of a request.
        """
        return cls(
            position=row["position"],
            stage=_stage(row["stage"]),
            parameters=_mapping(row["parameters"]),
            seed=row["seed"],
            runs={str(test): str(run) for test, run in _mapping(row["runs"]).items()},
        )


def _stage(value: Any) -> Stage:
    for stage in get_args(Stage):
        if value == stage:
            return cast(Stage, stage)
    raise ValueError(f"{value!r} is no stage of a calibration")


def _mapping(value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise TypeError(f"{value!r} does not map names to values")
    return value
