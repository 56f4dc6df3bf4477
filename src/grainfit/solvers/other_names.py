"""Tests and programs that users ask for and grainfit does not have: which door is open."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping

from grainfit.options import messages

_SCENE = 'type = "scene" simulates an experiment of your own'
_POURED = 'type = "funnel" is a poured heap.'
_VESSEL = f'type = "hopper" has cones, wedges and flat floors. {_SCENE}, from STL files.'
_SHEAR = (
    'type = "shear_cell" is a shear tester: preshear, then shear to failure; type = "shear" has '
    "steady flow alone, and costs less."
)
_TRIAXIAL = 'type = "triaxial" is drained compression under one confining stress.'
_INCLINED = (
    "No simulation is needed: write the angle at which the bulk solid begins to slide on the wall "
    'below [particle_wall], as sliding_friction = { measured_angle = "22 deg" }. '
    f"{_SCENE}."
)
_DROP = f'type = "command" or "python" takes your own model; {_SCENE}.'

#: Sentences by names of tests, lower case with underscores.
OTHER_TESTS: Mapping[str, str] = {
    **dict.fromkeys(("poured_heap", "poured_angle", "pouring", "pile"), _POURED),
    **dict.fromkeys(("silo", "bin", "bucket", "cone", "wedge"), _VESSEL),
    **dict.fromkeys(
        ("granudrum", "granuheap", "granuflow", "granupack", "hall_flowmeter", "carney"),
        "It is an instrument: 'grainfit apparatus' lists those that are known, each with the type "
        f"of its test. {_SCENE}.",
    ),
    **dict.fromkeys(
        ("shear_tester", "ring_shear", "jenike", "direct_shear", "shear_box", "schulze"), _SHEAR
    ),
    **dict.fromkeys(("biaxial", "true_triaxial", "triaxial_compression"), _TRIAXIAL),
    **dict.fromkeys(("drop", "bounce", "rebound", "restitution", "impact"), _DROP),
    **dict.fromkeys(
        ("angle_of_repose", "lifted_cylinder", "cylinder", "slump"),
        'type = "heap" is a cylinder that is lifted, "drum" and "draw_down" have angles, too.',
    ),
    **dict.fromkeys(("rotating_drum", "tumbler", "mixer"), 'type = "drum" is a rotating drum.'),
    **dict.fromkeys(("ledge", "sliding_door", "box"), 'The nearest is type = "draw_down".'),
    **dict.fromkeys(
        ("oedometer", "uniaxial", "uniaxial_compression"),
        'type = "compression" is uniaxial compression in a cylinder.',
    ),
    **dict.fromkeys(
        ("bulk_density", "pycnometer"),
        'type = "packing" has the bulk density of a poured bed.',
    ),
    **dict.fromkeys(
        ("tapped_density", "tap_density", "hausner_ratio", "tap"),
        'type = "tapped" is a poured container that is tapped.',
    ),
    **dict.fromkeys(("inclined_plane", "tilting_table", "wall_friction"), _INCLINED),
}
_PROGRAM = (
    'grainfit starts {known}. Another program with a command line: type = "command", with a folder '
    'of its input; runs made elsewhere: type = "table".'
)


def instead_of_test(name: object) -> str:
    """Return a sentence on what to use for a test of this name; empty for an unknown one."""
    return OTHER_TESTS.get(_key(name), "")


def instead_of_program(name: object, known: Iterable[str]) -> str:
    """Return a sentence on how to use another DEM program, or on the one that is meant."""
    key = _key(name)
    possible = list(known)
    if close := difflib.get_close_matches(key, possible, n=1, cutoff=0.75):
        return messages.MEANT(name=close[0])
    return _PROGRAM.format(known=", ".join(possible))


def _key(name: object) -> str:
    return "_".join(str(name)[:64].lower().replace("-", " ").replace("_", " ").split())
