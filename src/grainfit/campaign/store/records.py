"""Records of the store: runs, calibrations, and the parameter sets they requested."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal, cast, get_args

from grainfit.campaign.store.address import safe_address
from grainfit.errors import InputError
from grainfit.evaluation import Curve, Measured, Proposal, Response, Stage, names_of_tests
from grainfit.run_definition import RunDefinition

RunStatus = Literal["running", "finished", "failed"]


@dataclass(frozen=True)
class RunRecord:
    """One run in the store.

    Parameters
    ----------
    identity, test : str
        Identity of the run and name of its test.
    status : {"running", "finished", "failed"}
        Status; a run without a record was never started, or it was interrupted.
    definition : RunDefinition
        Everything that determines the outcome, from `Solver.definition`.
    responses : mapping of str to Response or Curve
        Responses by name; empty unless finished.
    reason, kind, log_tail : str
        Reason of the failure, its kind, and the last lines of the log.
    seconds : float
        Wall time, s.
    ended : float
        Time of its end, seconds since the epoch; for display only, because clocks can jump.
    origin : str
        Source of a run that was not executed here: another store, without its password, or an
        imported table.
    """

    identity: str
    test: str
    status: RunStatus
    definition: RunDefinition
    responses: Mapping[str, Measured] = field(default_factory=dict)
    reason: str = ""
    kind: str = ""
    log_tail: str = ""
    seconds: float = 0.0
    ended: float = 0.0
    origin: str = ""

    @property
    def may_succeed_next_time(self) -> bool:
        """Whether it failed for a reason that does not lie in the run itself."""
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
            The data is not a run.
        """
        if data["status"] not in get_args(RunStatus):
            raise ValueError(f"{data['status']!r} is not the status of a run")
        responses = {
            str(name): _measured(_mapping(found))
            for name, found in _mapping(data["responses"]).items()
        }
        read = {
            "definition": RunDefinition.from_json(_mapping(data["definition"])),
            "responses": responses,
            "seconds": float(data["seconds"]),
            "ended": float(data["ended"]),
            # Earlier versions stored addresses with their options.
            "origin": _source(data.get("origin", "")),
        }
        return cls(**{**data, **read})


@dataclass(frozen=True)
class CalibrationRecord:
    """A calibration that used this store.

    Parameters
    ----------
    identity, name : str
        Identity and display name.
    definition : mapping
        Everything that determines the runs it requests.
    status : str
        ``running``, or how it ended.
    started : float
        Time of its latest start, seconds since the epoch.
    known : sequence of str
        Identities of the earlier runs of its warm start.
    about : mapping
        Further information for reports, see `grainfit.calibration.provenance`.
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
    """One parameter set that a calibration requested, in every test or in some of them."""

    position: int
    stage: Stage
    parameters: Mapping[str, float]
    seed: int
    runs: Mapping[str, str]

    def proposal(self, tests: int) -> Proposal:
        """Return the proposal of a calibration with this number of tests."""
        asked = names_of_tests(self.runs)
        some = None if len(asked) == tests else asked
        return Proposal(self.parameters, self.seed, self.stage, some)

    @classmethod
    def from_row(cls, row: Mapping[str, Any]) -> RequestRecord:
        """Read a row of the store.

        Raises
        ------
        KeyError, TypeError, ValueError
            The row is not a request.
        """
        return cls(
            position=row["position"],
            stage=_stage(row["stage"]),
            parameters=_mapping(row["parameters"]),
            seed=row["seed"],
            runs={str(test): str(run) for test, run in _mapping(row["runs"]).items()},
        )


def _source(origin: Any) -> Any:
    return safe_address(origin) if "://" in str(origin) else origin


def _stage(value: Any) -> Stage:
    for stage in get_args(Stage):
        if value == stage:
            return cast(Stage, stage)
    raise ValueError(f"{value!r} is no stage of a calibration")


def _measured(found: Mapping[str, Any]) -> Measured:
    if "coordinates" not in found:
        return Response(float(found["value"]), float(found["standard_error"]))
    try:
        return Curve(found["coordinates"], found["values"], bool(found["stays"]))
    except InputError as error:
        raise ValueError(str(error)) from error


def _mapping(value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise TypeError(f"{value!r} does not map names to values")
    return value
