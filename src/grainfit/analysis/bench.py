"""The bench: every bulk test that can be simulated for a material on a solver."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.coarse_graining import sized_for
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.errors import Fault, InputError
from grainfit.formatting import in_a_row
from grainfit.materials.walls import PLAIN, on_wall, walls_among, with_plain_wall
from grainfit.options.kinds import suggest
from grainfit.problem import Parameter
from grainfit.solvers.base import Solver
from grainfit.solvers.parameters_for import of_material
from grainfit.solvers.registry import DEM_PROGRAMS


@dataclass(frozen=True)
class Bench:
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

    def without(self, failed: Mapping[str, str]) -> Bench:
        """Return it without tests that gave no responses, by the reasons."""
        kept = {name: solver for name, solver in self.solvers.items() if name not in failed}
        return replace(self, solvers=kept, refused={**self.refused, **failed})

    def remarks(self) -> list[str]:
        """Return sentences about tests with other options than the usual ones, and refused ones."""
        chosen = [
            f"{test} has {key} = {value} here: its default does not suit the material."
            for test, options in self.options.items()
            for key, value in options.items()
        ]
        return [
            *chosen,
            *self._sized(),
            *(f"Not compared: {test}. {why}" for test, why in self.refused.items()),
        ]

    def _sized(self) -> Iterator[str]:
        """Yield a sentence on the apparatus of tests that are not those of the user."""
        tests = {name: self.solvers[name].bulk_test for name in self.enlarged & self.solvers.keys()}
        for factor in {test.sizes.coarse_graining for test in tests.values() if test is not None}:
            yield (
                f"{in_a_row(sorted(tests))}: their apparatus is sized for the simulated particles, "
                f"{factor:g} times as large as the real ones (particle.coarse_graining)."
            )


def material_of(solvers: Mapping[str, Solver], values: Mapping[str, float]) -> dict[str, float]:
    """Return all material parameters, given the free ones, by the first solver of a bulk test.

    The free ones alone where there is no bulk test.
    """
    found = (solver.run_parameters(values) for solver in solvers.values() if solver.bulk_test)
    return next(found, dict(values))


def other_tests(
    parameters: Sequence[Parameter],
    solvers: Mapping[str, Solver],
    material: Mapping[str, float],
    wanted: Collection[str] = (),
) -> Bench:
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

    Returns
    -------
    Bench

    Raises
    ------
    InputError
        No test is simulated by a DEM program, or a wanted test is not known.
    """
    known = bulk_tests()
    for name in wanted:
        if name not in known:
            remedy = suggest(name, list(known), "Tests are")
            raise InputError(Fault("test", f"{name!r} is not a bulk test.", remedy))
    like = next((s for s in solvers.values() if s.bulk_test and s.name in DEM_PROGRAMS), None)
    if like is None or like.bulk_test is None:
        remedy = "Only bulk tests on a DEM program can be compared with others."
        raise InputError(Fault("test", "all tests are simulated by models of your own.", remedy))
    present = {s.bulk_test.type for s in solvers.values() if s.bulk_test}
    free = {p.name for p in parameters}
    fixed = {name: value for name, value in material.items() if name not in free}
    found: dict[str, Solver] = {}
    refused: dict[str, str] = {}
    plain = with_plain_wall(material, _usual_wall(material))
    chosen = {name: kind.options_for(plain) for name, kind in known.items()}
    for name, kind in known.items():
        if name in present or (wanted and name not in wanted):
            continue
        try:
            found[name] = _solver(kind, chosen[name], like, like.bulk_test, fixed, material, free)
        except InputError as error:
            refused[name] = " ".join(str(fault) for fault in error.faults)
    options = {name: chosen[name] for name in found if chosen[name]}
    is_enlarged = like.bulk_test.sizes.coarse_graining > 1
    return Bench(found, refused, options, frozenset(found) if is_enlarged else frozenset())


def _walls_like(kind: type[BulkTest], material: Mapping[str, float]) -> dict[str, str]:
    """Return the usual wall for all parts of a test, unless it is the plain one."""
    return {part: wall for part in kind.parts or () for wall in _usual_wall(material) if wall}


def _usual_wall(material: Mapping[str, float]) -> Sequence[str]:
    """Return the plain wall, or else the roughest: heaps roll off smooth floors."""

    def roughness(wall: str) -> float:
        return material[on_wall("particle_wall.rolling_friction", wall)]

    walls = walls_among(material)
    return [PLAIN] if PLAIN in walls else sorted(walls, key=roughness)[-1:]


def _solver(
    kind: type[BulkTest],
    options: Mapping[str, Any],
    program: Solver,
    like: BulkTest,
    fixed: Mapping[str, float],
    material: Mapping[str, float],
    free: Collection[str],
) -> Solver:
    conditions = like.conditions
    test = sized_for(
        kind,
        conditions.sizes,
        gravity=conditions.gravity,
        time_step_fraction=conditions.time_step_fraction,
        **options,
    )
    faults = [*test.material_faults(with_plain_wall(material, _usual_wall(material)))]
    if faults:
        raise InputError(faults)
    models = program.model().get("contact_models", ())
    walls = _walls_like(kind, material)
    solver: Solver = DEM_PROGRAMS[program.name](test, fixed, contact_models=models, walls=walls)
    solver.check()
    return of_material(solver, free)
