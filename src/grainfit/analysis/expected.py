"""Parameters that the chosen tests can settle, estimated before any run.

Linear: the recorded sensitivities of the responses in the middle of the intervals, the
uncertainties of the measurements and the scatter of the runs, with even spreads over the intervals,
give the expected widths of what remains.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grainfit.analysis.bench import material_of
from grainfit.analysis.further_tests import (
    BETTER_FIXED,
    DIRECT,
    better_fixed,
    how_to_determine,
    how_to_tell_apart,
    to_settle,
)
from grainfit.analysis.information import (
    Knowledge,
    Observation,
    even_deviation,
    recorded_measurable,
)
from grainfit.analysis.limits_of_trials import are_dry_spheres, unrecorded_effects
from grainfit.analysis.wall_sensitivities import on_walls
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.evaluation import response_name
from grainfit.formatting import in_a_row
from grainfit.materials.walls import plain_name
from grainfit.metamodels.likelihood import standard_uncertainty
from grainfit.problem import Problem
from grainfit.solvers.base import Solver

Array = NDArray[np.float64]

#: Share of an interval above which a parameter counts as open: the sensitivities are those of two
#: materials, so only wide intervals are worth a note.
_OPEN = 0.75
_DRY_SPHERES = (
    "What the tests leave open is estimated with recorded slopes, which are those of dry spheres: "
    "those of clumps and of cohesive materials are not recorded. 'grainfit design --simulate' "
    "finds them."
)
#: A parameter is tied to another one if its interval is narrower by this factor once that is known.
_TIED = 0.75


@dataclass(frozen=True)
class ExpectedNarrowing:
    """Estimate of what a calibration will determine, before any run.

    Attributes
    ----------
    narrowing : dict of str to float
        Width of the interval that each free parameter will keep, over that of its interval now:
        0 when it will be known exactly, 1 when the tests give no information. Only parameters whose
        effect has been measured; empty if that of a response has not. Least widths while a
        parameter is free whose effect has not.
    notes : tuple of str
        Sentences about the limits of the estimate, and about parameters that will stay open, with
        tests to add.
    """

    narrowing: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def expected_narrowing(problem: Problem, solvers: Mapping[str, Solver]) -> ExpectedNarrowing:
    """Estimate which free parameters the chosen tests can settle; nothing is simulated.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    solvers : mapping of str to Solver
        By name of the test. Nothing is known of models of the user.

    Returns
    -------
    ExpectedNarrowing
        Empty if the sensitivities of a target are not known; those of curves never are.

    Examples
    --------
    >>> import grainfit as gf
    >>> from grainfit.testing.materials import GLASS_BEADS
    >>> friction = "particle_particle.sliding_friction"
    >>> material = {name: value for name, value in GLASS_BEADS.items() if name != friction}
    >>> heap = gf.solvers.Lammps(gf.tests.Heap(diameter="10 mm"), material)
    >>> target = gf.Target("angle_of_repose", "22 deg", uncertainty="0.5 deg")
    >>> problem = gf.Problem([gf.Parameter(friction, 0.1, 0.9)], [target])
    >>> round(gf.expected_narrowing(problem, {"heap": heap}).narrowing[friction], 1)
    0.1
    """
    material = middle_material(problem, solvers)
    seen = _observations(problem, solvers, material)
    if not seen:
        return ExpectedNarrowing()
    unrecorded = list(unrecorded_effects(solvers, [p.name for p in problem.parameters]))
    without_effect = [p.name for p in problem.parameters if plain_name(p.name) in BETTER_FIXED]
    free = [p for p in problem.parameters if p.name not in (*unrecorded, *without_effect)]
    spreads = {p.name: even_deviation(p) for p in free}
    estimate = _Estimate(Knowledge.of_intervals(free), spreads, seen, _covariances(problem))
    tests = in_a_row(dict.fromkeys(s.bulk_test.type for s in solvers.values() if s.bulk_test))
    widths = estimate.narrowing()
    notes = (
        *(() if are_dry_spheres(solvers, material) else (_DRY_SPHERES,)),
        *([_note_on_unrecorded(unrecorded, widths)] if unrecorded else ()),
        *_notes(estimate, tests, about="at least" if unrecorded else "about"),
        *map(better_fixed, without_effect),
    )
    return ExpectedNarrowing(widths, notes)


def middle_material(problem: Problem, solvers: Mapping[str, Solver]) -> dict[str, float]:
    """Return the material in the middle of the intervals, fixed parameters included."""
    return material_of(solvers, problem.middle)


def _observations(
    problem: Problem, solvers: Mapping[str, Solver], material: Mapping[str, float]
) -> list[Observation] | None:
    """Return what the targets tell; None if the sensitivities of one are not known."""
    if problem.curves:
        return None
    infos = {
        response_name(test, name, len(solvers)): on_walls(info, solver)
        for test, solver in solvers.items()
        for name, info in (solver.bulk_test.responses if solver.bulk_test else {}).items()
    }
    found = []
    for target in problem.targets:
        accuracy = Accuracy(standard_uncertainty(target))
        info = infos.get(target.name)
        seen = info and recorded_measurable(target.name, info, material, target.value, accuracy)
        if not seen:
            return None
        found.append(seen.observation())
    return found


def _covariances(problem: Problem) -> Array:
    """Covariances of the errors of different measured values, relative to these."""
    errors = [standard_uncertainty(target) / target.value for target in problem.targets]
    between = problem.correlation_matrix - np.eye(len(errors))
    return np.asarray(between * np.outer(errors, errors))


@dataclass(frozen=True)
class _Estimate:
    """Free parameters whose effect is known, and the responses that tell about them."""

    before: Knowledge
    spreads: Mapping[str, float]
    observations: Sequence[Observation]
    covariances: Array

    def narrowing(self, given: Sequence[str] = ()) -> dict[str, float]:
        """Expected narrowing by name of those parameters that are not given."""
        after = self.before.without(given).after(self.observations, self.covariances)
        return {name: after.deviation(name) / self.spreads[name] for name in after.names}

    def narrowing_alone(self, name: str) -> float:
        """Expected narrowing of a parameter if all others were known."""
        return self.narrowing([other for other in self.before.names if other != name])[name]


def _note_on_unrecorded(unrecorded: Sequence[str], widths: Mapping[str, float]) -> str:
    """Return sentences on parameters whose effect is not recorded."""
    them, they_were = ("it", "it was") if len(unrecorded) == 1 else ("them", "they were")
    kept = f" Even if {they_were} known, {_kept(widths, widths)} would stay open." if widths else ""
    return (
        f"It is not recorded how the tests respond to {in_a_row(unrecorded)}, so nothing is known "
        f"of what they tell about {them}.{kept} {' '.join(map(to_settle, unrecorded))}"
    )


def _kept(names: Iterable[str], widths: Mapping[str, float]) -> str:
    return in_a_row([f"{100 * widths[name]:.0f} % of the interval of {name}" for name in names])


def _notes(estimate: _Estimate, tests: str, about: str) -> Iterator[str]:
    widths = estimate.narrowing()
    is_open = [name for name, width in widths.items() if width > _OPEN]
    unseen = [name for name in is_open if estimate.narrowing_alone(name) > _OPEN]
    for group in _groups(estimate, [name for name in is_open if name not in unseen]):
        yield _note_on_group(group, widths, tests, about)
    for name in unseen:
        yield f"{name} will not be determined by {tests}. To determine it: {how_to_determine(name)}"


def _groups(estimate: _Estimate, names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return open parameters with those on which they depend, merged where they overlap."""
    groups: list[set[str]] = []
    for name in names:
        group = {name, *_tied(estimate, name)}
        joined = [other for other in groups if other & group]
        groups = [other for other in groups if not other & group]
        groups.append(group.union(*joined))
    return [tuple(sorted(group, key=estimate.before.names.index)) for group in groups]


def _tied(estimate: _Estimate, name: str) -> list[str]:
    width = estimate.narrowing()[name]
    others = [other for other in estimate.before.names if other != name]
    return [o for o in others if estimate.narrowing([o])[name] < _TIED * width]


def _note_on_group(
    group: tuple[str, ...], widths: Mapping[str, float], tests: str, about: str
) -> str:
    """Return sentences on those that stay open, and on those that need not be free."""
    easy = [name for name in group if plain_name(name) in DIRECT and widths[name] <= _OPEN]
    hard = [name for name in group if name not in easy]
    while_free = f" while {in_a_row(easy)} {'is' if len(easy) == 1 else 'are'} free" if easy else ""
    kept = _kept([name for name in hard if widths[name] > _OPEN], widths)
    if len(hard) == 1:
        return (
            f"{hard[0]} will hardly be determined by {tests}{while_free}: {about} "
            f"{100 * widths[hard[0]]:.0f} % of its interval stays open. To determine it: "
            f"{how_to_determine(hard[0])}"
        )
    return (
        f"{in_a_row(hard)} can hardly be told apart by {tests} alone{while_free}: {about} {kept} "
        f"stays open. To tell them apart: {how_to_tell_apart(group)}"
    )
