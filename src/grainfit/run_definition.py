"""The definition of a run: all that decides its outcome, and the identity that follows from it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

#: Keys of the parameters in the JSON of a definition: built-in tests have a material. Both are as
#: version 0.1.0 wrote them, so that the identity of a run outlives the program that made it.
_MATERIAL, _PARAMETERS, _SEED, _TEST = "material", "parameters", "seed", "test"


def identity_of(data: Mapping[str, Any]) -> str:
    """Return the identity of JSON data: equal data have equal identities, others do not.

    Parameters
    ----------
    data : mapping
        JSON-serialisable. The order of keys does not count.

    Returns
    -------
    str
        32 hexadecimal digits.
    """
    canonical = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class RunDefinition:
    """All that decides the outcome of a run.

    Runs of one model differ in parameters and seed alone, so a run can be reused for a problem
    when its `model_hash` is that of the problem's solver.

    Parameters
    ----------
    model : mapping
        All that is fixed, as JSON: the solver and its version, the test or the contents of a model
        folder.
    parameters : mapping of str to float
        Values of all parameters that the run depends on, free or not, SI. Those at their default
        are left out: a parameter that a later version adds changes no identity.
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
        # A solver of somebody's own could leave both out in version 0.1.0.
        given, seed = data.get(key, {}), data.get(_SEED, 0)
        if not isinstance(given, Mapping):
            raise TypeError(f"{given!r} does not map names to values")
        try:
            parameters = {str(name): float(value) for name, value in given.items()}
            return cls(model, parameters, int(seed))
        except OverflowError as error:
            raise ValueError(f"a number of a run is too large: {error}") from error
