"""Bulk tests that can be simulated for a material on a solver, beside those of a calibration."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from grainfit.bulk_tests.abilities import friction_options, material_faults, options_for
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import sized_for
from grainfit.bulk_tests.conditions import conditions_of
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.time_steps import with_safe_time_step
from grainfit.errors import InputError
from grainfit.formatting import in_a_row
from grainfit.materials.walls import PLAIN, on_wall, walls_among, with_plain_wall
from grainfit.options.fields import Amount
from grainfit.options.kinds import suggest
from grainfit.problem import Parameter
from grainfit.solvers.base import Solver
from grainfit.solvers.parameters_for import of_material
from grainfit.solvers.registry import DEM_PROGRAMS
from grainfit.which_test import messages


@dataclass(frozen=True)
class AvailableTests:
    """Tests that can be simulated, and reasons why others cannot.

    Parameters
    ----------
    solvers : mapping of str to Solver
        By name of the test.
    refused : mapping of str to str
        Reasons by type of the test.
    options : mapping of str to mapping of str to object
        Options that replace defaults which do not suit the material, by type of the test.
    enlarged : frozenset of str
        Tests without an apparatus, which are sized for particles of coarse graining.
    """

    solvers: Mapping[str, Solver]
    refused: Mapping[str, str]
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    enlarged: frozenset[str] = frozenset()

    def without(self, failed: Mapping[str, str]) -> AvailableTests:
        """Return them without tests that gave no responses, by the reasons."""
        kept = {name: solver for name, solver in self.solvers.items() if name not in failed}
        return replace(self, solvers=kept, refused={**self.refused, **failed})

    def beside(self, own: Mapping[str, Solver], refused: Mapping[str, str]) -> AvailableTests:
        """Return them after tests of the user, with those of the user that are refused."""
        return replace(self, solvers={**own, **self.solvers}, refused={**refused, **self.refused})

    def remarks(self) -> Iterator[str]:
        """Yield sentences about tests with other options than the usual ones, and refused ones."""
        for test, options in self.options.items():
            for key, value in options.items():
                yield messages.OTHER_DEFAULT(test=test, key=key, value=value)
        tests = {name: self.solvers[name].bulk_test for name in self.enlarged & self.solvers.keys()}
        for factor in {test.sizes.coarse_graining for test in tests.values() if test is not None}:
            yield messages.SIZED_FOR_PARTICLES(tests=in_a_row(sorted(tests)), factor=factor)
        for test, why in self.refused.items():
            yield messages.NOT_COMPARED(test=test, why=why)


def material_of(solvers: Mapping[str, Solver], values: Mapping[str, float]) -> dict[str, float]:
    """Return all material parameters, given the free ones, by the first solver of a bulk test.

    The free ones alone where there is no bulk test.
    """
    found = (solver.run_parameters(values) for solver in solvers.values() if solver.bulk_test)
    return next(found, dict(values))


def types_of(solvers: Mapping[str, Solver]) -> list[str]:
    """Return the types of the bulk tests of solvers, each once, in their order."""
    return list(dict.fromkeys(s.bulk_test.type for s in solvers.values() if s.bulk_test))


def available_tests(
    parameters: Sequence[Parameter],
    solvers: Mapping[str, Solver],
    material: Mapping[str, float],
    wanted: Collection[str] = (),
) -> AvailableTests:
    """Return the tests that a calibration does not have, with their usual options.

    Those of enlarged particles have an apparatus that suits these: nobody has built one.

    Parameters
    ----------
    parameters : sequence of Parameter
        Free parameters.
    solvers : mapping of str to Solver
        Tests that there are; the first bulk test gives program, contact models, particles and
        gravity.
    material : mapping of str to float
        A material within the intervals, with all material parameters.
    wanted : collection of str
        Types of test to consider; all by default.

    Raises
    ------
    InputError
        No test is simulated by a DEM program, or a wanted test is not known.
    """
    known = bulk_tests()
    for name in wanted:
        if name not in known:
            remedy = suggest(name, list(known), "Tests are")
            raise InputError(messages.UNKNOWN_TEST.fault("test", name=name, known=remedy))
    maker = _Maker.like(solvers, material, {p.name for p in parameters})
    present = types_of(solvers)
    found: dict[str, Solver] = {}
    refused: dict[str, str] = {}
    options = {name: maker.options(kind) for name, kind in known.items()}
    for name, kind in known.items():
        if name in present or (wanted and name not in wanted):
            continue
        try:
            found[name] = maker.solver(kind, options[name])
        except InputError as error:
            refused[name] = " ".join(str(fault) for fault in error.faults)
    chosen = {name: options[name] for name in found if options[name]}
    is_enlarged = maker.test.sizes.coarse_graining > 1
    return AvailableTests(found, refused, chosen, frozenset(found) if is_enlarged else frozenset())


@dataclass(frozen=True)
class _Maker:
    """Makes solvers of other tests with the program, particles and gravity of a first one."""

    program: Solver
    test: BulkTest
    material: Mapping[str, float]
    free: Collection[str]

    @classmethod
    def like(
        cls, solvers: Mapping[str, Solver], material: Mapping[str, float], free: Collection[str]
    ) -> _Maker:
        for solver in solvers.values():
            if solver.bulk_test and solver.name in DEM_PROGRAMS:
                return cls(solver, solver.bulk_test, material, free)
        raise InputError(messages.ONLY_OWN_MODELS.fault("test"))

    @property
    def _usual_wall(self) -> Sequence[str]:
        """The plain wall, or else the roughest: heaps roll off smooth floors."""

        def roughness(wall: str) -> float:
            return self.material[on_wall("particle_wall.rolling_friction", wall)]

        walls = walls_among(self.material)
        return [PLAIN] if PLAIN in walls else sorted(walls, key=roughness)[-1:]

    @property
    def plain_material(self) -> dict[str, float]:
        return with_plain_wall(self.material, self._usual_wall)

    def options(self, kind: type[BulkTest]) -> dict[str, Amount]:
        """Return what suits the material; walls with a name have their own friction."""
        found = options_for(kind, self.plain_material)
        own = {name for names in friction_options(kind).values() for name in names}
        of_walls = own if any(self._usual_wall) else set()
        return {name: value for name, value in found.items() if name not in of_walls}

    def solver(self, kind: type[BulkTest], options: Mapping[str, Any]) -> Solver:
        like = conditions_of(self.test)
        test = sized_for(
            kind,
            like.sizes,
            gravity=like.gravity,
            time_step_fraction=like.time_step_fraction,
            **options,
        )
        InputError.raise_for(material_faults(test, self.plain_material))
        fixed = {name: value for name, value in self.material.items() if name not in self.free}
        models = self.program.model().get("contact_models", ())
        values = {name: (value, value) for name, value in self.material.items()}
        test = with_safe_time_step(test, values, models)
        walls = {part: wall for part in kind.parts or () for wall in self._usual_wall if wall}
        make = DEM_PROGRAMS[self.program.name]
        solver: Solver = make(test, fixed, contact_models=models, walls=walls)
        solver.check()
        return of_material(solver, self.free)
