"""Check the parameters and the responses that are exchanged with custom models."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from math import isfinite
from numbers import Real
from typing import Any

from grainfit.errors import InputError, RunFailedError
from grainfit.evaluation import messages
from grainfit.evaluation.response import Curve, Measured, Response
from grainfit.validation import as_number

_RESPONSE_FORMS = (
    "A response is a number, a pair of value and standard error, "
    '{"value": ..., "standard_error": ...}, or a curve: {"coordinates": [...], "values": [...]}.'
)
#: Keys of a response that is a number, and of one that is a curve.
_NUMBER_KEYS = ("value", "standard_error")
_CURVE_KEYS = ("coordinates", "values", "stays")


def finite_parameters(parameters: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters as plain floats.

    Raises
    ------
    InputError
        A value is not a finite number; all of them are named.
    """
    InputError.raise_for(
        messages.PARAMETER_NOT_FINITE.fault(str(name), given=value)
        for name, value in parameters.items()
        if not isfinite(as_number(value))
    )
    return {name: float(value) for name, value in parameters.items()}


def read_responses(
    found: Any, expected: Sequence[str] | None = None, origin: str = "the model"
) -> dict[str, Measured]:
    """Check and convert the responses of a custom model.

    Parameters
    ----------
    found : object
        Expected is a mapping of response name to a number, a pair of value and standard error, a
        mapping with ``value`` and optionally ``standard_error``, or a `Response`; for a curve a
        mapping with ``coordinates`` and ``values``, or a `Curve`.
    expected : sequence of str, optional
        Responses that must be present; others are kept if they are valid. None: all must be valid.
    origin : str
        Source of the responses, for the message.

    Raises
    ------
    RunFailedError
        The responses are not usable; of kind ``"evaluation"``.
    """
    if not isinstance(found, Mapping):
        raise _unusable(f"{origin} gave {_short(found)}, not responses by name")
    if not found:
        raise _unusable(f"{origin} gave no responses")
    if missing := about_missing(found, expected, origin):
        raise _unusable(missing)
    names = list(found) if expected is None else list(expected)
    responses = {_response_name(n, origin): _response(n, found[n], origin) for n in names}
    return responses | _others(found, responses)


def about_missing(found: Iterable[Any], expected: Sequence[str] | None, origin: str) -> str:
    """Say which expected responses are missing, and which are there; empty if none is missing."""
    there = list(found)
    missing = [name for name in expected or () if name not in there]
    if not missing:
        return ""
    listed = ", ".join(map(str, there))
    return f"{origin} gave no response {', '.join(missing)}; there are: {listed}"


def _others(found: Mapping[Any, Any], expected: Mapping[str, Measured]) -> dict[str, Measured]:
    """Return other valid responses of the model: they may become targets later."""
    others: dict[str, Measured] = {}
    for name in found:
        if isinstance(name, str) and name and name not in expected:
            with suppress(RunFailedError):
                others[name] = _response(name, found[name], "the model")
    return others


def _response_name(name: Any, origin: str) -> str:
    if not isinstance(name, str) or not name:
        raise _unusable(f"{origin} gave a response named {_short(name)}; a name is a text")
    return name


def _response(name: str, found: Any, origin: str) -> Measured:
    if isinstance(found, Curve):
        return found
    if isinstance(found, Mapping) and "coordinates" in found:
        _require_known(name, found, _CURVE_KEYS, origin)
        return _curve(name, found, origin)
    value, standard_error = _value_and_error(name, found, origin)
    for number, words in ((value, ""), (standard_error, "standard error of ")):
        if not isfinite(as_number(number)):
            raise _unusable(f"{words}response {name} from {origin} is {_short(number)}")
    if standard_error < 0:
        raise _unusable(f"standard error of response {name} from {origin} is {standard_error}")
    return Response(float(value), float(standard_error))


def _curve(name: str, found: Mapping[str, Any], origin: str) -> Curve:
    try:
        stays = bool(found.get("stays", False))
        return Curve(found["coordinates"], found.get("values", ()), stays)
    except InputError as error:
        raise _unusable(f"curve {name} from {origin}: {error}") from error


def _value_and_error(name: str, found: Any, origin: str) -> tuple[Any, Any]:
    if isinstance(found, Response):
        return found.value, found.standard_error
    if isinstance(found, Mapping) and "value" in found:
        _require_known(name, found, _NUMBER_KEYS, origin)
        return found["value"], found.get("standard_error", 0.0)
    if isinstance(found, (tuple, list)) and len(found) == 2:
        return found[0], found[1]
    if isinstance(found, Real):
        return found, 0.0
    raise _unusable(f"response {name} from {origin} is {_short(found)}. {_RESPONSE_FORMS}")


def _require_known(name: str, found: Mapping[Any, Any], known: Sequence[str], origin: str) -> None:
    """Raise `RunFailedError` for a key that would be left out, such as ``"std"``."""
    for key in found:
        if key not in known:
            named = {"name": name, "origin": origin, "key": _short(key), "known": ", ".join(known)}
            raise _unusable(messages.UNKNOWN_KEY(**named))


def _short(found: Any) -> str:
    # The representation of NumPy numbers shows their type, which does not help here.
    text = str(found) if isinstance(found, Real) else " ".join(repr(found).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def _unusable(reason: str) -> RunFailedError:
    return RunFailedError(reason, kind="evaluation")
