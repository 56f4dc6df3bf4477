"""Parameters that the chosen tests will leave open, estimated before any run.

Slopes are those of the atlas over the intervals. They, the uncertainties of the measurements, and
the scatter of the runs give the expected widths of what remains of even spreads over the intervals.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from grainfit.arrays import Array
from grainfit.bulk_tests.accuracy import Accuracy
from grainfit.evaluation import response_name
from grainfit.formatting import in_a_row
from grainfit.materials.walls import plain_name
from grainfit.one_line import OneLine
from grainfit.problem import Problem, Target
from grainfit.solvers.base import Solver
from grainfit.which_test import messages
from grainfit.which_test.available import types_of
from grainfit.which_test.candidate import CandidateResponse
from grainfit.which_test.determining_tests import (
    BETTER_FIXED,
    DIRECT,
    better_fixed,
    determining_tests,
    how_to_determine,
    how_to_tell_apart,
)
from grainfit.which_test.further_response import further_response
from grainfit.which_test.knowledge import Knowledge, even_deviation
from grainfit.which_test.slopes import Cloud
from grainfit.which_test.told_by_atlas import of_dry_spheres, told_responses, untold_effects

#: Share of an interval above which a parameter counts as open: slopes are those of a straight line,
#: so only wide intervals are worth a note.
_OPEN = 0.75
#: A parameter is tied to another one if its interval is narrower by this factor once that is known.
_TIED = 0.75


@dataclass(frozen=True)
class ExpectedNarrowing(OneLine):
    """Estimate of what a calibration will determine, before any run.

    Attributes
    ----------
    narrowing : dict of str to float
        Width of the interval that each free parameter will keep, over that of its interval now:
        0 when it will be known exactly, 1 when the tests give no information. Only parameters whose
        effect the atlas tells; empty if it does not tell of a target. Least widths while a
        parameter is free whose effect it does not tell.
    notes : tuple of str
        Sentences about the limits of the estimate, and about parameters that will stay open, with
        tests to add.
    further : str
        Sentence on a response of the same runs that would narrow a parameter further; may be empty.
    """

    narrowing: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    further: str = ""


def expected_narrowing(problem: Problem, solvers: Mapping[str, Solver]) -> ExpectedNarrowing:
    """Estimate which free parameters the chosen tests can determine; nothing is simulated.

    Parameters
    ----------
    problem : Problem
        Free parameters and targets.
    solvers : mapping of str to Solver
        By name of the test. Nothing is known of models of the user.

    Returns
    -------
    ExpectedNarrowing
        Empty if the atlas does not tell of a target; of curves it never does.

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
    0.2
    """
    cloud = Cloud.even(problem.parameters)
    responses = _responses(problem, solvers, cloud)
    if not responses:
        return ExpectedNarrowing()
    untold = list(untold_effects(solvers, cloud))
    without_effect = [p.name for p in problem.parameters if plain_name(p.name) in BETTER_FIXED]
    free = [p for p in problem.parameters if p.name not in (*untold, *without_effect)]
    spreads = {p.name: even_deviation(p) for p in free}
    slopes = [response.slopes for response in responses]
    estimate = _Estimate(Knowledge.of_intervals(free), spreads, slopes, _errors(problem, responses))
    tests = in_a_row(types_of(solvers))
    widths = estimate.narrowing()
    measured = problem.responses
    then = estimate.before.after(slopes, estimate.errors)
    seen = [name for name, width in widths.items() if width <= _OPEN]
    further = further_response(then, seen, solvers, measured, cloud)
    notes = (
        *of_dry_spheres(messages.SLOPES_OF_DRY_SPHERES, solvers, problem.middle),
        *([_note_on_untold(untold, widths, measured)] if untold else ()),
        *_notes(estimate, tests, measured, about="at least" if untold else "on average about"),
        *map(better_fixed, without_effect),
    )
    return ExpectedNarrowing(widths, notes, further)


def _responses(
    problem: Problem, solvers: Mapping[str, Solver], cloud: Cloud
) -> list[CandidateResponse]:
    """Return the responses of the targets; none if the atlas does not tell of one."""
    if problem.curves or not all(target.value for target in problem.targets):
        return []
    targets = {target.name: target for target in problem.targets}
    told: dict[str, CandidateResponse] = {}
    for test, solver in solvers.items():
        accuracy_of = partial(_measured, targets, test, len(solvers))
        for one in told_responses(test, solver, cloud, accuracy_of):
            name = response_name(test, one.short_name, len(solvers))
            told[name] = replace(one, name=name, value=targets[name].value)
    return [told[name] for name in targets] if told.keys() == targets.keys() else []


def _measured(
    targets: Mapping[str, Target], test: str, tests: int, name: str, _info: object
) -> Accuracy | None:
    target = targets.get(response_name(test, name, tests))
    return None if target is None else Accuracy(target.standard_uncertainty)


def _errors(problem: Problem, responses: Sequence[CandidateResponse]) -> Array:
    """Covariance of the errors of the measured values and the runs, relative to the values."""
    relative = [target.standard_uncertainty / target.value for target in problem.targets]
    between = problem.correlation_matrix - np.eye(len(relative))
    own = np.diag([response.variance() for response in responses])
    return np.asarray(own + between * np.outer(relative, relative))


@dataclass(frozen=True)
class _Estimate:
    """Free parameters whose effect is known, and the measured responses."""

    before: Knowledge
    spreads: Mapping[str, float]
    slopes: Sequence[Mapping[str, float]]
    errors: Array

    def narrowing(self, given: Sequence[str] = ()) -> dict[str, float]:
        """Return the expected narrowing by name of those parameters that are not given."""
        after = self.before.without(given).after(self.slopes, self.errors)
        return {name: after.deviation(name) / self.spreads[name] for name in after.names}

    def narrowing_alone(self, name: str) -> float:
        """Return the expected narrowing of a parameter if all others were known."""
        return self.narrowing([other for other in self.before.names if other != name])[name]

    def tied(self, name: str) -> list[str]:
        """Return the parameters whose values would narrow a parameter further."""
        width = self.narrowing()[name]
        others = [other for other in self.before.names if other != name]
        return [o for o in others if self.narrowing([o])[name] < _TIED * width]

    def groups(self, names: Sequence[str]) -> list[tuple[str, ...]]:
        """Return open parameters with those that they are tied to, merged where they overlap."""
        groups: list[set[str]] = []
        for name in names:
            group = {name, *self.tied(name)}
            joined = [other for other in groups if other & group]
            groups = [other for other in groups if not other & group]
            groups.append(group.union(*joined))
        return [tuple(sorted(group, key=self.before.names.index)) for group in groups]


def _note_on_untold(
    untold: Sequence[str], widths: Mapping[str, float], measured: Sequence[str]
) -> str:
    """Return sentences on parameters whose effect the atlas does not tell."""
    them, they_were = ("it", "it was") if len(untold) == 1 else ("them", "they were")
    parts = [messages.EFFECT_NOT_TOLD(names=in_a_row(untold), them=them)]
    if widths:
        parts.append(messages.OPEN_EVEN_SO(they_were=they_were, kept=_kept(widths, widths)))
    return " ".join([*parts, *(determining_tests(name, measured) for name in untold)])


def _kept(names: Iterable[str], widths: Mapping[str, float]) -> str:
    shares = [messages.SHARE_KEPT(share=100 * widths[name], name=name) for name in names]
    return in_a_row(shares)


def _notes(estimate: _Estimate, tests: str, measured: Sequence[str], about: str) -> Iterator[str]:
    widths = estimate.narrowing()
    is_open = [name for name, width in widths.items() if width > _OPEN]
    unseen = [name for name in is_open if estimate.narrowing_alone(name) > _OPEN]
    for group in estimate.groups([name for name in is_open if name not in unseen]):
        yield _note_on_group(group, widths, tests, measured, about)
    for name in unseen:
        yield messages.NOT_DETERMINED(name=name, tests=tests, how=how_to_determine(name, measured))


def _note_on_group(
    group: tuple[str, ...],
    widths: Mapping[str, float],
    tests: str,
    measured: Sequence[str],
    about: str,
) -> str:
    """Return sentences on those that stay open, and on those that need not be free."""
    easy = [name for name in group if plain_name(name) in DIRECT and widths[name] <= _OPEN]
    hard = [name for name in group if name not in easy]
    while_free = f" while {in_a_row(easy)} {'is' if len(easy) == 1 else 'are'} free" if easy else ""
    if len(hard) == 1:
        return messages.HARDLY_DETERMINED(
            name=hard[0],
            tests=tests,
            while_free=while_free,
            about=about,
            share=100 * widths[hard[0]],
            how=how_to_determine(hard[0], measured),
        )
    return messages.HARDLY_TOLD_APART(
        names=in_a_row(hard),
        tests=tests,
        while_free=while_free,
        about=about,
        kept=_kept([name for name in hard if widths[name] > _OPEN], widths),
        how=how_to_tell_apart(group, measured),
    )
