"""Tests and programs that users ask for and grainfit does not have: which door is open."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

_SCENE = 'type = "scene" simulates an experiment of your own'
_POURED = (
    'The nearest is type = "heap", a cylinder that is lifted: a poured heap has another angle. '
    f"{_SCENE}, funnel included."
)
_VESSEL = f'The nearest is type = "discharge", a flat-bottomed container. {_SCENE}, from STL files.'
_SHEAR = 'The nearest is type = "shear": plane shear under a normal stress, in steady flow.'
_TRIAXIAL = (
    'The nearest are type = "compression" and "shear". type = "command" takes your own deck of '
    f"it; {_SCENE}."
)
_DROP = f'type = "command" or "python" takes your own model; {_SCENE}.'

#: Sentences by names of tests, lower case with underscores.
OTHER_TESTS: Mapping[str, str] = {
    **dict.fromkeys(("funnel", "poured_heap", "poured_angle", "pouring", "pile"), _POURED),
    **dict.fromkeys(("hopper", "silo", "bin", "bucket", "wedge", "hall_flowmeter"), _VESSEL),
    **dict.fromkeys(("shear_cell", "ring_shear", "jenike", "direct_shear", "shear_box"), _SHEAR),
    **dict.fromkeys(("triaxial", "biaxial", "true_triaxial"), _TRIAXIAL),
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
        ("bulk_density", "tapped_density", "pycnometer"),
        'type = "packing" has the bulk density of a poured bed; there is no test with taps.',
    ),
}
_PROGRAM = (
    'grainfit starts {known}. Another program with a command line: type = "command", with a folder '
    'of its input; runs made elsewhere: type = "table".'
)
#: Other DEM programs, lower case with underscores.
OTHER_PROGRAMS = (
    "aspherix", "edem", "esys_particle", "itasca", "kratos", "mercurydpm", "mfix", "musen", "pfc",
    "pfc3d", "pfc2d", "rocky", "rocky_dem", "star_ccm+", "woo", "xdem",
)  # fmt: skip


def instead_of_test(name: object) -> str:
    """Return a sentence on what to use for a test of this name; empty for an unknown one."""
    return OTHER_TESTS.get(_key(name), "")


def instead_of_program(name: object, known: Iterable[str]) -> str:
    """Return a sentence on how to use another DEM program; empty for an unknown one."""
    key = _key(name)
    # With a version behind it, too: "EDEM 2023".
    if key in OTHER_PROGRAMS or key.partition("_")[0] in OTHER_PROGRAMS:
        return _PROGRAM.format(known=", ".join(known))
    return ""


def _key(name: object) -> str:
    return "_".join(str(name)[:64].lower().replace("-", " ").replace("_", " ").split())
