"""A test of a user in the inputs of the atlas, and its responses back in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grainfit.atlas import messages
from grainfit.atlas.inputs import (
    MATERIAL,
    SIZE,
    STIFFNESS,
    WALL_ROLLING,
    apparatus,
    ranges_of,
    varied_of,
)
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.natural_units import Scale
from grainfit.bulk_tests.registry import bulk_tests
from grainfit.bulk_tests.sensitivities import DENSITY, MODULUS, ROLLING, WALL_SLIDING
from grainfit.bulk_tests.shared.part_friction import AS_PARTICLES
from grainfit.bulk_tests.size import size_power
from grainfit.bulk_tests.stiffness import stiffness_number
from grainfit.bulk_tests.varied_options import InAtlas
from grainfit.contact_models.registry import contact_law
from grainfit.errors import InputError
from grainfit.solvers.base import Solver
from grainfit.units import powers

Array = NDArray[np.float64]
#: Relative difference of an option from that of the rows which is none.
_SAME = 0.05
#: Walls are rigid when their modulus is so many times that of the particles.
_RIGID = 30.0
_DAMPING = "particle_particle.rolling_damping"


class NotInAtlasError(Exception):
    """The atlas tells nothing about a test; the text says why."""


class Reading:
    """A test of a user in the inputs of the atlas.

    Parameters
    ----------
    solver : Solver
        Of the test.
    parameters : mapping of str to float
        Free parameters somewhere in their intervals.

    Raises
    ------
    NotInAtlasError
        The atlas has no such test, particles, contact law or apparatus.
    """

    def __init__(self, solver: Solver, parameters: Mapping[str, float]) -> None:
        test = solver.bulk_test
        if test is None:
            raise NotInAtlasError(messages.NO_ROWS())
        self.test: BulkTest = test
        self.kind = _kind_of(test)
        self.ranges = ranges_of(self.kind)
        try:
            self._material = solver.run_parameters(parameters)
            _require_spheres_of_usual_law(solver, test, self._material)
            self._apparatus = _apparatus_inputs(self.kind, test)
        except InputError as error:
            raise NotInAtlasError(error.reasons) from None

    def shares(self, values: Mapping[str, Array]) -> Array:
        """Return points of the unit cube of the atlas, shape (m, inputs); beyond 1 outside of it.

        Parameters
        ----------
        values : mapping of str to ndarray
            Free parameters, SI, each of shape (m,).
        """
        inputs = self.inputs({**self._material, **values})
        count = len(next(iter(values.values())))
        return np.column_stack(
            [np.broadcast_to(span.share(inputs[name]), count) for name, span in self.ranges.items()]
        )

    def inputs(self, material: Mapping[str, Any]) -> dict[str, Any]:
        """Return the inputs of a material, or of arrays of materials, by name."""
        test, varied = self.test, varied_of(self.kind)
        weight = material[DENSITY] * float(test.gravity) * test.sizes.sauter_diameter
        options = test.resolved_options()
        return {
            **{name: material[name] for name in MATERIAL},
            STIFFNESS: stiffness_number(test, material),
            **self._apparatus,
            **{name: _as_number(name, options[name], material) for name in varied.values},
            **{name: options[name] / weight for name in varied.loads},
        }

    def unit(self, response: str, values: Mapping[str, Array]) -> Array:
        """Return the unit of a response of the metamodels in its SI unit, shape (m,) or ()."""
        unit = self.kind.responses[response].unit
        density: Any = values.get(DENSITY, np.asarray(self._material[DENSITY]))
        scale = Scale(self.test.sizes.sauter_diameter, 1.0, float(self.test.gravity))
        grown = self._apparatus[SIZE] ** (size_power(self.kind, response) or 0.0)
        return np.asarray(grown * scale.of(unit) * density ** powers(unit)[0])

    def require_inside(self, parameters: Mapping[str, float]) -> None:
        """Raise `NotInAtlasError` with the first input that lies outside of the rows.

        An apparatus that is larger and particles that are stiffer follow the trend of the rows.
        """
        values = {name: np.array([value]) for name, value in parameters.items()}
        inputs = self.inputs({**self._material, **values})
        for (name, span), at in zip(self.ranges.items(), self.shares(values)[0], strict=True):
            if not -_SAME <= at <= span.limit + _SAME:
                value = float(np.asarray(inputs[name]).flat[0])
                raise NotInAtlasError(
                    messages.OUTSIDE(name=name, value=value, low=span.low, high=span.high)
                )


def _kind_of(test: BulkTest) -> type[BulkTest]:
    kind = bulk_tests().get(test.type)
    if kind is None or not isinstance(kind, InAtlas):
        raise NotInAtlasError(messages.NO_ROWS())
    return kind


def _require_spheres_of_usual_law(
    solver: Solver, test: BulkTest, material: Mapping[str, float]
) -> None:
    if test.sizes.shape is not None:
        raise NotInAtlasError(messages.CLUMPS(shape=test.sizes.shape))
    models = tuple(getattr(solver, "contact_models", ()))
    if models:
        raise NotInAtlasError(messages.LAW(models=", ".join(models)))
    law = contact_law(material, models)
    if law.cohesion is not None:
        raise NotInAtlasError(messages.COHESION(model=law.cohesion.name))
    if getattr(solver, "walls", {}):
        raise NotInAtlasError(messages.WALLS())
    if material.get(_DAMPING, 0.0) > 0:
        raise NotInAtlasError(messages.DAMPING(name=_DAMPING, value=material[_DAMPING]))
    if material["wall.youngs_modulus"] < _RIGID * material[MODULUS]:
        raise NotInAtlasError(messages.SOFT_WALL())


def _apparatus_inputs(kind: type[BulkTest], test: BulkTest) -> dict[str, float]:
    """Return the inputs of an apparatus that no material changes."""
    varied = varied_of(kind)
    scale = Scale(test.sizes.sauter_diameter, 1.0, float(test.gravity))
    given = test.resolved_options()
    loads = {name: given[name] / scale.of("Pa") for name in varied.loads}
    usual = dict.fromkeys(varied.factors, 1.0) | {n: given[n] for n in varied.values} | loads
    reference = apparatus(kind, {**usual, SIZE: 1.0}, scale).resolved_options()
    size = given[varied.size_option] / reference[varied.size_option]
    usual[SIZE] = float(size ** (1 / varied.size_power))
    at_size = apparatus(kind, usual, scale).resolved_options()
    for name in varied.factors:
        usual[name] = given[name] / at_size[name]
    alike = apparatus(kind, usual, scale).resolved_options()
    for name, value in given.items():
        is_input = name in varied.values or name in varied.indifferent
        if not is_input and not _is_same(value, alike[name]):
            raise NotInAtlasError(
                messages.OTHER_OPTION(name=name, value=_shown(value), usual=_shown(alike[name]))
            )
    return {name: usual[name] for name in (SIZE, *varied.factors)}


def _as_number(name: str, value: Any, material: Mapping[str, Any]) -> Any:
    """Return the value of an option; the friction of a part may be that of walls or particles."""
    if value is None:
        return material[WALL_SLIDING if "sliding" in name else WALL_ROLLING]
    return material[ROLLING] if value == AS_PARTICLES else value


def _is_same(one: Any, other: Any) -> bool:
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return math.isclose(one, other, rel_tol=_SAME)
    return bool(one == other)


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
