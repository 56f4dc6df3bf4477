"""Results of version 0.1.0 in the names of today."""

from __future__ import annotations

from typing import Any

#: Names of version 0.1.0 that have changed.
_RENAMED = {
    "agreement": "probability_all_met",
    "std_error": "standard_error",
    "verified_std_error": "verified_standard_error",
    "learnt_from": "warm_start_runs",
}


def in_current_names(data: Any) -> Any:
    """Return the data of a result, of any version, with the names of this one."""
    if not isinstance(data, dict) or "agreement" not in data:
        return data
    renamed = _with_current_keys(data)
    if isinstance(counts := data.get("runs"), dict):
        renamed["runs"] = _with_current_keys(counts)
    if isinstance(responses := data.get("responses"), dict):
        renamed["responses"] = {
            name: _with_verdict(_with_current_keys(found)) if isinstance(found, dict) else found
            for name, found in responses.items()
        }
    return renamed


def _with_verdict(response: dict[str, Any]) -> dict[str, Any]:
    """Return a response of version 0.1.0 with the verdict that its flag stands for.

    It was also false for what was not verified, and for what the verification runs alone met.
    """
    within = response.pop("within_tolerance", None)
    if not isinstance(within, bool):
        return response
    missed = abs(_deviation(response)) > 1.0
    return {"verdict": "met" if within else "missed" if missed else "in doubt", **response}


def _deviation(response: dict[str, Any]) -> float:
    """Return the deviation of the verification runs in tolerances; 0 where it is not known."""
    try:
        return float((response["verified_mean"] - response["target"]) / response["tolerance"])
    except (KeyError, TypeError, ZeroDivisionError):
        return 0.0


def _with_current_keys(data: dict[str, Any]) -> dict[str, Any]:
    return {_RENAMED.get(key, key): value for key, value in data.items()}
