"""Records of the store: runs, calibrations, and the parameter sets they requested."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal, get_args

from grainfit.campaign.store.address import safe_address
from grainfit.campaign.store.cells import (
    choice,
    finite,
    mapping,
    moment,
    numbers_by_name,
    text,
    texts,
    texts_by_name,
    whole,
)
from grainfit.errors import InputError
from grainfit.evaluation import (
    Curve,
    Measured,
    Proposal,
    Response,
    Stage,
    names_of_tests,
    tests_asked,
)
from grainfit.one_line import OneLine
from grainfit.run_definition import RunDefinition

RunStatus = Literal["running", "finished", "failed"]


@dataclass(frozen=True)
class RunRecord(OneLine):
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
        Reason of the failure, its kind, and the last lines of the log. The reason of a finished run
        says why it is without some responses.
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
        responses = {
            name: _measured(name, mapping(found, f"responses.{name}"))
            for name, found in mapping(data["responses"], "responses").items()
        }
        return cls(
            identity=text(data["identity"], "identity"),
            test=text(data["test"], "test"),
            status=choice(data["status"], "status", get_args(RunStatus)),
            definition=_definition(data["definition"]),
            responses=responses,
            reason=text(data.get("reason", ""), "reason"),
            kind=text(data.get("kind", ""), "kind"),
            log_tail=text(data.get("log_tail", ""), "log_tail"),
            seconds=finite(data["seconds"], "seconds"),
            ended=moment(data["ended"], "ended"),
            # Earlier versions stored addresses with their options.
            origin=_source(text(data.get("origin", ""), "origin")),
        )


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

    @property
    def first_search(self) -> str:
        """Identity of the first of the searches that belong together, see `Twins`; its own else."""
        return str(self.about.get("first_search", self.identity))

    @classmethod
    def from_row(cls, row: Mapping[str, Any]) -> CalibrationRecord:
        """Read a row; raise KeyError, TypeError or ValueError if it is no calibration."""
        return cls(
            identity=text(row["identity"], "identity"),
            name=text(row["name"], "name"),
            definition=mapping(row["definition"], "definition"),
            status=text(row["status"], "status"),
            started=moment(row["started"], "started"),
            known=texts(row["known"], "known"),
            about=mapping(row["about"], "about"),
        )


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
        return Proposal(self.parameters, self.seed, self.stage, tests_asked(self.runs, tests))

    @classmethod
    def from_row(cls, row: Mapping[str, Any]) -> RequestRecord:
        """Read a row; raise KeyError, TypeError or ValueError if it is no request."""
        return cls(
            position=whole(row["position"], "position"),
            stage=choice(row["stage"], "stage", get_args(Stage)),
            parameters=numbers_by_name(row["parameters"], "parameters"),
            seed=whole(row["seed"], "seed"),
            runs=texts_by_name(row["runs"], "runs"),
        )

    def require_part_of(self, parameters: Collection[str], tests: Collection[str]) -> None:
        """Refuse a request that is not one of a calibration.

        Parameters
        ----------
        parameters, tests : collection of str
            Names of the free parameters, and of the tests of the calibration.

        Raises
        ------
        ValueError
            It has other parameters, or runs of other tests.
        """
        if self.parameters.keys() != set(parameters):
            raise ValueError("its parameters are not those of the calibration")
        if not self.runs or not set(names_of_tests(self.runs)) <= set(tests):
            raise ValueError("its runs are not those of the tests of the calibration")


def _source(origin: str) -> str:
    return safe_address(origin) if "://" in origin else origin


def _definition(data: Any) -> RunDefinition:
    try:
        return RunDefinition.from_json(mapping(data, "definition"))
    except (TypeError, ValueError) as error:
        raise ValueError(f"definition: {error}") from error


def _measured(name: str, found: Mapping[str, Any]) -> Measured:
    key = f"responses.{name}"
    if "coordinates" not in found:
        error = finite(found["standard_error"], f"{key}.standard_error")
        return Response(finite(found["value"], f"{key}.value"), error)
    try:
        return Curve(found["coordinates"], found["values"], bool(found["stays"]))
    except InputError as error:
        raise ValueError(f"{key}: {error}") from error
