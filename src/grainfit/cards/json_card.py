"""The card as JSON, for programs; docs/export.md has its keys."""

from __future__ import annotations

import json
from typing import Any

from grainfit.contact_models.registry import contact_law, with_defaults
from grainfit.materials.card import CardParameter, CardResponse, MaterialCard
from grainfit.materials.sizes import ParticleSizes
from grainfit.materials.time_step import RAYLEIGH_EQUATIONS
from grainfit.solvers.dem.card_parts import simulated_card

#: Raised when a key gets another meaning or is removed; keys may be added.
FORMAT_VERSION = 3
#: Keys that are not the names of the fields.
_KEYS = {"interval": "interval_95"}


def render_json(card: MaterialCard) -> str:
    """Return the card as a JSON object."""
    simulated = simulated_card(card).values
    data = {
        "format": "grainfit material card",
        "format_version": FORMAT_VERSION,
        "name": card.name,
        "calibrated": card.calibrated,
        "status": card.status,
        "verdict": card.verdict,
        "parameters": [
            _fields(p) | {"simulated_value": simulated[p.name]} for p in card.parameters
        ],
        "responses": [_fields(response) for response in card.responses],
        "time_step": {
            "rayleigh": card.rayleigh_time_step,
            "recommended": card.recommended_time_step,
            "fraction": card.time_step_fraction,
            "equations": [vars(equation) for equation in RAYLEIGH_EQUATIONS],
        },
        "contact_models": card.contact_models,
        "contact_law": _contact_law(card),
        "particle_sizes": _sizes(card.sizes),
        "particle_shape": _shape(card),
        "gravity": card.gravity,
        "provenance": {
            "calibration_file": card.calibration_file,
            "identity": card.identity,
            "programs": [vars(program) for program in card.programs],
            "runs": card.runs,
            "earlier_runs": card.earlier_runs,
            "failed_runs": card.failed_runs,
            "date": card.date,
            "grainfit_version": card.version,
        },
        "apparatus": card.apparatus,
        "notices": card.notices,
    }
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    # Half a character, as in a file name that is not valid Unicode, becomes JSON's \udcff.
    return text.encode("utf-8", "backslashreplace").decode()


def _contact_law(card: MaterialCard) -> dict[str, Any] | None:
    """Return the equations and conventions of the contact models; None of the user's own model."""
    if not card.contact_models:
        return None
    law = contact_law(with_defaults(card.values), card.contact_models)
    found = [*((None, equation) for equation in law.equations()), *law.differing_terms]
    return {
        "equations": [{"solver": solver, **vars(equation)} for solver, equation in found],
        "conventions": [
            {"parameter": one.key, "symbol": one.symbol, "meaning": one.meaning}
            for one in law.conventions
        ],
    }


def _sizes(sizes: ParticleSizes | None) -> dict[str, Any] | None:
    if sizes is None:
        return None
    return {
        **sizes.definition(),
        "coarse_graining": sizes.coarse_graining,
        "real_diameters": sizes.real.without_noise.diameters,
    }


def _shape(card: MaterialCard) -> dict[str, Any] | None:
    """Return the clump at the volume of a sphere of diameter 1; None for spheres."""
    clump = None if card.sizes is None else card.sizes.clump
    if clump is None:
        return None
    spheres = zip(clump.positions.tolist(), clump.radii.tolist(), strict=True)
    return {
        "spheres": [{"position": place, "radius": radius} for place, radius in spheres],
        "moments_of_inertia": clump.moments,
    }


def _fields(part: CardParameter | CardResponse) -> dict[str, Any]:
    return {_KEYS.get(key, key): value for key, value in vars(part).items()}
