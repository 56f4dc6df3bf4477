"""The page of the atlas: one file that works offline, with sliders for all inputs."""

from __future__ import annotations

from typing import Any

from grainfit.atlas.shelf import Atlas
from grainfit.atlas.strata import Stratum, strata
from grainfit.atlas.surrogate import ResponseModel, Surrogate
from grainfit.bulk_tests.heap import Heap
from grainfit.formatting import unit_for_people
from grainfit.report.package_page import package_page
from grainfit.report.page import element_text, page_part
from grainfit.report.rendering import script_json
from grainfit.units import powers

#: Inputs in words, where the name alone does not tell.
_WORDS = {
    "stiffness": "Young's modulus over the pressing stress",
    "size": "size of the apparatus over the usual one",
    "normal_stress": "normal stress over ρ g d",
}


def atlas_page(atlas: Atlas) -> str:
    """Return the page of an atlas.

    Parameters
    ----------
    atlas : Atlas
        Its rows and metamodels are in the page.
    """
    # Most users have a heap.
    known = {name: one for name in atlas.strata if (one := atlas.of_stratum(name)) is not None}
    names = sorted(known, key=lambda name: (strata()[name].kind is not Heap, name))
    tests = [_test(strata()[name], known[name]) for name in names]
    return package_page(
        "grainfit.atlas_page",
        tests=tests,
        kriging=element_text(page_part("scripts/kriging.js")),
        data=script_json({"tests": tests}),
    )


def _test(stratum: Stratum, surrogate: Surrogate) -> dict[str, Any]:
    return {
        "name": stratum.name,
        "title": stratum.title,
        "rows": len(surrogate.rows),
        "inputs": [
            {
                "name": name,
                "words": _words(stratum, name),
                "low": span.low,
                "high": span.high,
                "power": span.power,
            }
            for name, span in stratum.ranges.items()
        ],
        "responses": [_response(stratum, name, model) for name, model in surrogate.models.items()],
    }


def _words(stratum: Stratum, name: str) -> str:
    if name in _WORDS:
        return _WORDS[name]
    words = name.replace("particle_wall.", "on walls: ").rpartition("particle.")[2]
    usual = ", usual = 1" if name in stratum.varied.factors else ""
    natural = " over ρ g d²" if name.endswith("surface_energy") else ""
    return f"{words.replace('_', ' ')}{natural}{usual}"


def _response(stratum: Stratum, name: str, model: ResponseModel) -> dict[str, Any]:
    info = stratum.kind.responses[name]
    unit = info.unit
    return {
        "name": name.replace("_", " "),
        "unit": unit_for_people(unit),
        "powers": powers(unit),
        "limits": info.limits,
        "powers_of_inputs": stratum.powers(name),
        "is_logarithm": model.is_logarithm,
        "inflation": model.inflation,
        "model": model.kriging.to_plain(factors=False),
        "chance": model.chance.to_plain(factors=False),
    }
