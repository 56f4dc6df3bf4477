"""Definition of a run: everything that determines its outcome, and its identity."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from grainfit.one_line import OneLine

#: Keys in the JSON of a definition; parameters of built-in tests are under "material". Both are as
#: in version 0.1.0, so that identities of runs stay valid across versions.
_MATERIAL, _PARAMETERS, _SEED, _TEST = "material", "parameters", "seed", "test"


def identity_of(data: Mapping[str, Any]) -> str:
    """Return the identity of JSON data: equal data have equal identities.

    Parameters
    ----------
    data : mapping
        JSON-serialisable data. The order of keys does not matter.

    Returns
    -------
    str
        32 hexadecimal digits.
    """
    canonical = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()[:32]


def without_defaults(
    values: Mapping[str, float], defaults: Mapping[str, float]
) -> dict[str, float]:
    """Return the values without those that are at their default."""
    return {name: value for name, value in values.items() if defaults.get(name) != value}


@dataclass(frozen=True)
class RunDefinition(OneLine):
    """Everything that determines the outcome of a run.

    Runs of one model differ only in parameters and seed, so a run can be reused for a problem if
    its `model_hash` is that of the problem's solver.

    Parameters
    ----------
    model : mapping
        Everything that is fixed, as JSON: the solver and its version, the test or the contents of a
        model folder.
    parameters : mapping of str to float
        Values of all parameters that the run depends on, free or not, SI. Parameters at their
        default are left out, so that a parameter added by a later version changes no identity.
    seed : int
        Insertion seed.

    Examples
    --------
    >>> run = RunDefinition({"solver": "drum"}, {"friction": 0.3}, 7)
    >>> RunDefinition.from_json(run.to_json()) == run
    True
    """

    model: Mapping[str, Any]
    parameters: Mapping[str, float]
    seed: int

    @cached_property
    def identity(self) -> str:
        """Identity of the run, 32 hexadecimal digits."""
        return identity_of(self.to_json())

    @cached_property
    def model_hash(self) -> str:
        """Hash of the model, the same for all runs of a solver."""
        return identity_of(self.model)

    @property
    def test_type(self) -> str:
        """Type of the bulk test; "" of a model of the user."""
        return type_of_test(self.model)

    def to_json(self) -> dict[str, Any]:
        """Return flat plain data that `from_json` reads."""
        key = _MATERIAL if _TEST in self.model else _PARAMETERS
        return {**self.model, key: dict(self.parameters), _SEED: self.seed}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> RunDefinition:
        """Read what `to_json` wrote, in this version or an earlier one.

        Raises
        ------
        TypeError, ValueError
            The data does not define a run.
        """
        key = _MATERIAL if _TEST in data else _PARAMETERS
        model = {name: value for name, value in data.items() if name not in (key, _SEED)}
        # In version 0.1.0 a custom solver could leave both out.
        given, seed = data.get(key, {}), data.get(_SEED, 0)
        if not isinstance(given, Mapping):
            raise TypeError(f"{given!r} does not map names to values")
        try:
            parameters = {str(name): float(value) for name, value in given.items()}
            if not all(map(math.isfinite, parameters.values())):
                raise ValueError("a parameter of a run is not finite")
            return cls(model, parameters, int(seed))
        except OverflowError as error:
            raise ValueError(f"a number of a run is too large: {error}") from error


def type_of_test(model: Mapping[str, Any]) -> str:
    """Return the type of the bulk test of a model; "" of a model of the user."""
    test = model.get(_TEST)
    return str(test.get("type", "")) if isinstance(test, Mapping) else ""
