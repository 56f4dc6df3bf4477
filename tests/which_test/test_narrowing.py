"""Notes before any run: which free parameters the chosen tests will leave open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import hypot, log, sqrt
from pathlib import Path

import numpy as np
import pytest

import grainfit as gf
from grainfit.atlas import expectation
from grainfit.atlas.shelf import Atlas
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.bulk_tests.registry import BUILT_IN
from grainfit.materials.particle_shape import ParticleShape
from grainfit.materials.sizes import ParticleSizes
from grainfit.testing.materials import GLASS_BEADS, ROUGH_PLATE
from grainfit.which_test import determining_tests as further
from grainfit.which_test import messages
from grainfit.which_test.candidate import CandidateResponse
from grainfit.which_test.narrowing import ExpectedNarrowing
from grainfit.which_test.slopes import Cloud
from grainfit.which_test.told_by_atlas import told_responses

DENSITY = gf.Parameter("particle.density", 1400, 2800, unit="kg/m^3")
SLIDING = gf.Parameter("particle_particle.sliding_friction", 0.1, 0.8)
ROLLING = gf.Parameter("particle_particle.rolling_friction", 0.05, 0.6)
RESTITUTION = gf.Parameter("particle_particle.restitution", 0.3, 0.9)
WALL = gf.Parameter("particle_wall.sliding_friction", 0.1, 0.8)
MODULUS = gf.Parameter("particle.youngs_modulus", 1e5, 1e7, "log")
BULK_DENSITY = gf.Target("bulk_density", 1300.0, uncertainty="1 %")
ANGLE = gf.Target("angle_of_repose", 25.0, uncertainty="1 deg")
ENERGY = gf.Parameter("particle_particle.surface_energy", 0, 0.3, unit="J/m^2")
RATIO = gf.Parameter("particle.aspect_ratio", 1, 2)
HEAP = gf.tests.Heap(diameter="10 mm", **ROUGH_PLATE)
CLUMPS, PELLETS = (
    gf.tests.Heap(
        ParticleSizes((0.01,), shape=ParticleShape(family, aspect_ratio=1.5)), **ROUGH_PLATE
    )
    for family in ("two_spheres", "cylinder")
)


def expected(
    *parameters: gf.Parameter,
    targets: tuple[gf.Target, ...] = (BULK_DENSITY, ANGLE),
    correlations: Sequence[tuple[str, str, float]] = (),
    test: gf.tests.Heap = HEAP,
    **given: float,
) -> ExpectedNarrowing:
    free = {parameter.name for parameter in parameters}
    material = {name: value for name, value in GLASS_BEADS.items() if name not in free}
    solver = gf.solvers.Lammps(test, {**material, **given})
    return gf.expected_narrowing(
        gf.Problem(parameters, targets, correlations=correlations), {"heap": solver}
    )


def test_a_heap_cannot_tell_two_frictions_apart_while_the_density_is_free() -> None:
    [note] = expected(DENSITY, SLIDING, ROLLING).notes
    assert note.startswith(
        f"{SLIDING.name} and {ROLLING.name} can hardly be told apart by heap alone while "
        f"{DENSITY.name} is free: on average about "
    )
    for help_ in ("particle density (pycnometer)", "draw-down", "uniaxial compression"):
        assert help_ in note
    assert expected(SLIDING, ROLLING).notes == ()
    assert expected(DENSITY, ROLLING).notes == ()


def test_two_frictions_and_an_angle_only_cannot_be_told_apart() -> None:
    found = expected(SLIDING, ROLLING, targets=(ANGLE,))
    assert messages.HARDLY_TOLD_APART.is_in(found.notes[0], tests="heap", while_free="")
    assert "at a particle density that a pycnometer has determined" in found.notes[0]


@pytest.mark.parametrize(
    ("parameter", "remedy"),
    [(RESTITUTION, "drop test"), (WALL, "atan(sliding friction)")],
)
def test_a_heap_says_nothing_of_restitution_and_wall_friction(
    parameter: gf.Parameter, remedy: str
) -> None:
    found = expected(ROLLING, parameter)
    [note] = found.notes
    assert note.startswith(f"{parameter.name} will not be determined by heap. To determine it: ")
    assert remedy in note
    assert found.narrowing[parameter.name] > 0.95


def test_a_modulus_needs_compression() -> None:
    [note] = expected(DENSITY, MODULUS).notes
    assert messages.HARDLY_DETERMINED.is_in(note, name=MODULUS.name, tests="heap")
    assert f"while {DENSITY.name} is free" in note
    assert "uniaxial compression" in note
    assert "grainfit stiffness" in note


def test_a_parameter_that_hardly_changes_any_test_is_better_fixed() -> None:
    [note] = expected(DENSITY, gf.Parameter("wall.poissons_ratio", 0.1, 0.4)).notes
    assert note.startswith("wall.poissons_ratio hardly changes any common bulk test")


def told(parameter: gf.Parameter) -> dict[str, CandidateResponse]:
    """Return the responses of the heap with their slopes over an interval, measured exactly."""
    material = {name: value for name, value in GLASS_BEADS.items() if name != parameter.name}
    solver = gf.solvers.Lammps(HEAP, material)
    cloud = Cloud.even([parameter])
    found = told_responses("heap", solver, cloud, lambda *_: Accuracy(0.0))
    return {one.short_name: one for one in found}


def test_one_parameter_is_narrowed_as_its_slope_and_the_uncertainty_say() -> None:
    density = replace(DENSITY, scale="log")
    known = told(density)["bulk_density"]
    slope = known.slopes[density.name]
    assert slope == pytest.approx(1.05, abs=0.05)
    for share in (0.01, 0.1):
        target = replace(BULK_DENSITY, uncertainty=1300 * share, tolerance=1300 * share)
        # The expected response is known as well as the mean of five runs.
        change = slope * log(2.0) / hypot(share, sqrt(known.variance()))
        found = expected(density, targets=(target,))
        assert found.narrowing[density.name] == pytest.approx(1 / sqrt(1 + change**2 / 12))


def test_a_length_of_a_heap_narrows_rolling_friction_as_slope_and_ruler_say() -> None:
    rolling = replace(ROLLING, scale="log")
    known = told(rolling)
    angle, radius, height = (
        abs(known[name].slopes[rolling.name]) / hypot(share, sqrt(known[name].variance()))
        for name, share in (
            ("angle_of_repose", 1 / 25),
            ("base_radius", 0.01),
            ("heap_height", 0.02),
        )
    )
    best = max(radius, height)
    before, after = (196 / sqrt(12 / log(12) ** 2 + angle**2 + also**2) for also in (0.0, best))
    found = expected(rolling, targets=(ANGLE,)).further
    assert found == messages.MEASURE_AS_WELL(
        response="heap_height" if height > radius else "base_radius",
        test="heap",
        accuracy="2 %" if height > radius else "1 %",
        tool=" (with a ruler)",
        name=rolling.name,
        after=f"{after:.2g}",
        before=f"{before:.2g}",
    )


def test_no_further_response_where_it_tells_little_or_is_measured() -> None:
    radius = gf.Target("base_radius", 0.13, uncertainty="1 %")
    assert "with a ruler" in expected(ROLLING, targets=(ANGLE, BULK_DENSITY)).further
    assert expected(ROLLING, targets=(radius, BULK_DENSITY)).further == ""
    assert expected(DENSITY).further == ""
    assert expected(ROLLING, targets=(ANGLE,), test=PELLETS).further == ""


def test_rolling_friction_counts_less_where_it_is_larger_than_sliding_friction() -> None:
    low = replace(ROLLING, minimum=0.05, maximum=0.25)
    high = replace(ROLLING, minimum=0.3, maximum=1.5)
    widths = [expected(p, targets=(ANGLE,)).narrowing[p.name] for p in (low, high)]
    assert widths[1] > 1.2 * widths[0]


@pytest.mark.parametrize(
    ("parameter", "remedy"), [(ENERGY, "a shear test"), (RATIO, "photographs of particles")]
)
def test_a_parameter_of_which_the_atlas_does_not_tell_does_not_count_as_known(
    parameter: gf.Parameter, remedy: str
) -> None:
    limits, untold, frictions = expected(DENSITY, SLIDING, ROLLING, parameter, test=PELLETS).notes

    assert messages.SLOPES_OF_DRY_SPHERES.is_in(limits)
    assert messages.EFFECT_NOT_TOLD(names=parameter.name, them="it") in untold
    assert "Even if it was known, " in untold
    assert messages.SHARE_KEPT.is_in(untold, name=SLIDING.name)
    assert f"To determine {parameter.name}: {remedy}" in untold
    assert "while particle.density is free: at least 8" in frictions
    # Nothing more is said of what would stay open where only its effect is not known.
    _, alone = expected(parameter, test=PELLETS).notes
    assert "Even if" not in alone


def test_several_parameters_of_which_the_atlas_does_not_tell_are_said_together() -> None:
    _, note = expected(ROLLING, ENERGY, RATIO, test=PELLETS).notes
    assert messages.EFFECT_NOT_TOLD(names=f"{ENERGY.name} and {RATIO.name}", them="them") in note
    assert "Even if they were known, " in note


def test_it_is_said_where_dry_spheres_stand_for_other_particles() -> None:
    [pellets] = expected(SLIDING, ROLLING, test=PELLETS).notes
    assert pellets == messages.SLOPES_OF_DRY_SPHERES(tests="heap")
    clumps = expected(SLIDING, ROLLING, test=CLUMPS)
    cohesive = expected(SLIDING, ROLLING, **{ENERGY.name: 0.1})
    for found in (clumps, cohesive, expected(SLIDING, ROLLING, **{ENERGY.name: 0.0})):
        assert not any(messages.SLOPES_OF_DRY_SPHERES.is_in(note) for note in found.notes)


def test_the_rows_of_clumps_and_cohesive_spheres_tell_what_is_theirs_alone() -> None:
    for parameter, test in ((ENERGY, HEAP), (RATIO, CLUMPS)):
        found = expected(SLIDING, parameter, test=test)
        assert not any(messages.EFFECT_NOT_TOLD.is_in(note) for note in found.notes)
        assert parameter.name in found.narrowing


def test_nothing_is_said_about_models_of_the_user_and_tests_without_rows(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    problem = gf.Problem([SLIDING, ROLLING, RESTITUTION], [gf.Target("angle", 30.0)])
    own = gf.solvers.PythonCallable(lambda _parameters, _seed: {"angle": 30.0}, ["angle"])
    assert gf.expected_narrowing(problem, {"own": own}) == ExpectedNarrowing()
    monkeypatch.setattr(expectation, "shipped_atlas", lambda: Atlas(tmp_path))
    assert expected(SLIDING, RESTITUTION) == ExpectedNarrowing()


def test_further_tests_recommend_a_shear_test_for_cohesion_alone_and_no_drum() -> None:
    cohesion = "particle_particle.surface_energy"
    assert "a shear test" in further.determining_tests(cohesion)
    said = [further.determining_tests(name) for name in further.TESTS if name != cohesion]
    said += [
        further.separating_tests((SLIDING.name, ROLLING.name)),
        further.separating_tests((DENSITY.name, SLIDING.name, ROLLING.name)),
        further.separating_tests((DENSITY.name, MODULUS.name)),
    ]
    for sentence in said:
        recommended = sentence.partition("Another angle does not help")[0]
        assert "drum" not in recommended
        assert "shear" not in recommended


@pytest.mark.parametrize("test", ["", "heap.", "steep."])
def test_what_is_measured_already_is_not_proposed(test: str) -> None:
    angle, density = f"{test}angle_of_repose", f"{test}bulk_density"
    rolling = further.determining_tests(ROLLING.name, [angle, density])
    assert messages.MEASURED_ALREADY(responses="angle of repose", is_measured="is") in rolling
    assert "heap" not in rolling
    sliding = further.determining_tests(SLIDING.name, [angle, density])
    assert "the bulk density" not in sliding
    assert "a draw-down test" in sliding
    assert "a draw-down test" not in further.determining_tests(
        SLIDING.name, [angle, f"{test}mass_flow"]
    )
    frictions = (SLIDING.name, ROLLING.name)
    assert "the bulk density" in further.separating_tests((DENSITY.name, *frictions))
    both = further.separating_tests((DENSITY.name, *frictions), [density])
    assert "give the particle density (pycnometer); a draw-down" in both
    one = further.separating_tests((SLIDING.name, MODULUS.name), ["c.lateral_stress_ratio"])
    assert "modulus of loading" in one
    assert "lateral stress ratio" not in one
    everything = [density, angle, f"{test}mass_flow", "lateral_stress_ratio"]
    assert "are measured already" in further.separating_tests(frictions, everything)


def test_two_tests_with_one_response_each_are_no_draw_down_test() -> None:
    apart = ["heap.angle_of_repose", "discharge.mass_flow"]
    assert "a draw-down test" in further.determining_tests(SLIDING.name, apart)
    cohesion = "particle_particle.surface_energy"
    stresses = [f"{name}.internal_friction_angle" for name in ("low", "high")]
    assert "a shear test" in further.determining_tests(cohesion, stresses[:1])
    assert "a shear test" not in further.determining_tests(cohesion, stresses)


def test_a_test_is_named_as_one_that_grainfit_runs_only_if_it_is_installed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    frictions = (SLIDING.name, ROLLING.name)
    heap = BUILT_IN["heap"]
    monkeypatch.setattr(further, "bulk_tests", lambda: {"heap": heap})
    assert "type =" not in further.separating_tests(frictions)
    assert 'a heap (type = "heap": at a sliding' in further.determining_tests(ROLLING.name)
    monkeypatch.setattr(
        further,
        "bulk_tests",
        lambda: {"heap": heap, "draw_down": heap, "compression": heap},
    )
    said = further.separating_tests(frictions)
    assert 'draw-down test (type = "draw_down": angle of repose, mass flow)' in said
    assert 'uniaxial compression (type = "compression": lateral stress ratio)' in said
    assert "the bulk density (at a particle density" in said


@pytest.mark.parametrize("coefficient", [0.0, 0.9, -0.9])
def test_correlated_errors_count_in_the_expected_narrowing(coefficient: float) -> None:
    density = replace(DENSITY, scale="log")
    targets = (BULK_DENSITY, ANGLE)
    known = [told(density)[target.name] for target in targets]
    slopes = np.array([found.slopes[density.name] for found in known]) * log(2.0)
    errors = np.array([0.01, 1.0 / 25.0])
    covariance = np.diag(errors**2 + np.array([found.variance() for found in known]))
    covariance[0, 1] = covariance[1, 0] = coefficient * errors.prod()
    information = slopes @ np.linalg.solve(covariance, slopes)
    pairs = [("bulk_density", "angle_of_repose", coefficient)] if coefficient else []
    found = expected(density, targets=targets, correlations=pairs)
    assert found.narrowing[density.name] == pytest.approx(1 / sqrt(1 + information / 12))


def test_nothing_is_expected_of_a_target_of_zero() -> None:
    zero = gf.Target("angle_of_repose", 0.0, tolerance=1.0)
    assert expected(ROLLING, targets=(BULK_DENSITY, zero)) == ExpectedNarrowing()
