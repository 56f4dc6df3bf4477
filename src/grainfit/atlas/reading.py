"""A test of a user in the inputs of the atlas, and its responses back in SI units."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from grainfit.arrays import Array
from grainfit.atlas import messages
from grainfit.atlas.strata import SIZE, STIFFNESS, Particles, Stratum, strata
from grainfit.bulk_tests.abilities import friction_options
from grainfit.bulk_tests.apparatus import shown_value
from grainfit.bulk_tests.base import BulkTest
from grainfit.bulk_tests.natural_units import Scale, unit_of_parameter
from grainfit.bulk_tests.parameter_names import (
    DENSITY,
    MODULUS,
    ROLLING,
    WALL_RESTITUTION,
    WALL_ROLLING,
    WALL_SLIDING,
)
from grainfit.bulk_tests.shared.part_friction import AS_PARTICLES
from grainfit.bulk_tests.stiffness import stiffness_number
from grainfit.bulk_tests.varied_options import NUMERICAL, Range
from grainfit.contact_models.registry import contact_law
from grainfit.errors import InputError
from grainfit.formatting import in_a_row, number
from grainfit.materials.walls import PLAIN, on_wall, plain_name, wall_of
from grainfit.solvers.base import Solver
from grainfit.units import powers

#: Relative difference of an option from that of the rows which is none.
_SAME = 0.05
#: Share down to which responses follow the trend of the size: as far as the rows are wide.
_SMALLEST = -1.0
#: Walls are rigid when their modulus is so many times that of the particles.
_RIGID = 30.0
_DAMPING = "particle_particle.rolling_damping"
#: Inputs that are no option or parameter of the file, for readers.
_IN_WORDS = {
    STIFFNESS: "the stiffness number (Young's modulus over what presses particles together)",
    SIZE: "the size of the apparatus over the usual one",
}
#: Parameters that move an input, besides those that are one. Trials showed no effect of the
#: restitution of walls: rows have that of the particles.
_TOLD = frozenset({WALL_RESTITUTION, DENSITY, MODULUS})


class NotInAtlasError(Exception):
    """The atlas tells nothing about a test; the text says why."""


class DamagedAtlasError(NotInAtlasError):
    """The rows of a test are damaged, or of another physics."""


class Reading:
    """A test of a user in the inputs of the atlas.

    Parameters
    ----------
    solver : Solver
        Of the test.
    parameters : mapping of str to float
        Free parameters somewhere in their intervals.
    is_nearest : bool
        Whether rows of dry spheres of the usual law, in the apparatus that is nearest, stand for
        what the atlas does not have: enough to tell what a response depends on, not its value.

    Raises
    ------
    NotInAtlasError
        The atlas has no such test, particles, contact law or apparatus.

    Attributes
    ----------
    test : BulkTest
        The test.
    stratum : Stratum
        The rows that tell of it.
    has_own_particles : bool
        Whether these are of its particles, and not of dry spheres that stand for them.
    """

    def __init__(
        self, solver: Solver, parameters: Mapping[str, float], *, is_nearest: bool = False
    ) -> None:
        test = solver.bulk_test
        if test is None:
            raise NotInAtlasError(messages.NO_ROWS())
        self.test: BulkTest = test
        self._walls = _Walls.of(solver, test)
        try:
            self._material = solver.run_parameters(parameters)
            of_test = _strata_of(test)
            cohesion = _cohesion(solver, self._material)
            own = [one for one in of_test if _are(one.particles, test, cohesion)]
            self.has_own_particles = bool(own)
            # A mass that is filled in reaches as high as the density of the particles says.
            of_material = test.of_material(self._material)
            self.stratum, inputs = _nearest(own or of_test, of_material)
            if not is_nearest:
                if not self.has_own_particles:
                    raise NotInAtlasError(_other_particles(of_test, test, cohesion))
                _require_told_law(solver, self._material, self._walls)
                self._walls.require_told(self.stratum.varied.values)
                if inputs.other:
                    raise NotInAtlasError(inputs.other[0])
            self._apparatus = inputs.values
            self.ranges = self.stratum.ranges
            self.inputs(self._material)
        except InputError as error:
            raise NotInAtlasError(error.reasons) from None
        except KeyError as error:
            raise NotInAtlasError(messages.NO_VALUE(name=error.args[0])) from None

    @property
    def kind(self) -> type[BulkTest]:
        """Class of the test."""
        return self.stratum.kind

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

    def tells_of(self, name: str) -> bool:
        """Return whether a parameter moves an input."""
        wall, plain = wall_of(name), plain_name(name)
        is_told = plain in (*_TOLD, *self.stratum.particles.material)
        if not is_told or wall in (None, self._walls.first):
            return is_told
        options = self._walls.of_options(self.stratum.varied.values)
        return any(own == wall and _friction(option) == plain for option, own in options.items())

    def inputs(self, material: Mapping[str, Any]) -> dict[str, Any]:
        """Return the inputs of a material, or of arrays of materials, by name."""
        values = self.stratum.varied.values
        return {
            **{name: self._of_material(name, material) for name in self.stratum.particles.material},
            STIFFNESS: stiffness_number(self.test, material),
            **self._apparatus,
            **{name: self._as_number(name, self._options[name], material) for name in values},
            **self._loads(material[DENSITY]),
        }

    @cached_property
    def _options(self) -> Mapping[str, Any]:
        return self.test.resolved_options()

    def _loads(self, density: Any) -> dict[str, Any]:
        """Return stresses over the weight of a particle on its cross-section."""
        weight = self._natural("Pa", density)
        return {name: self._options[name] / weight for name in self.stratum.varied.loads}

    def _of_material(self, name: str, material: Mapping[str, Any]) -> Any:
        # A test without walls has no parameters of one.
        value = material.get(on_wall(name, self._walls.first))
        if value is None:
            return self.ranges[name].at(0.5)
        return value / self._natural(unit_of_parameter(name), material[DENSITY])

    def _natural(self, unit: str, density: Any) -> Any:
        """Return the natural unit of a quantity at one density of the particles, or at many."""
        scale = Scale(self.test.sizes.sauter_diameter, 1.0, float(self.test.gravity))
        return scale.of(unit) * density ** powers(unit)[0]

    def _as_number(self, name: str, value: Any, material: Mapping[str, Any]) -> Any:
        """Return the value of an option; the friction of a part may be a wall's or particles'."""
        if value is None:
            return material[on_wall(_friction(name), self._walls.of_options([name])[name])]
        return material[ROLLING] if value == AS_PARTICLES else value

    def unit(self, response: str, values: Mapping[str, Array]) -> Array:
        """Return the unit of a response of the metamodels in its SI unit, shape (m,) or ()."""
        unit = self.kind.responses[response].unit
        density: Any = values.get(DENSITY, np.asarray(self._material[DENSITY]))
        given = {**self._apparatus, **self._loads(density)}
        return np.asarray(self.stratum.proportion(response, given) * self._natural(unit, density))

    def require_inside(self, parameters: Mapping[str, float]) -> None:
        """Raise `NotInAtlasError` with the first input that lies outside of the rows.

        An apparatus that is larger and particles that are stiffer follow the trend of the rows;
        what a laboratory chooses may lie beyond them (`beyond`).
        """
        values = {name: np.array([value]) for name, value in parameters.items()}
        inputs = self.inputs({**self._material, **values})
        for name, is_outside in self.outside(values).items():
            if is_outside.any():
                value = float(np.asarray(inputs[name]).flat[0])
                raise NotInAtlasError(
                    messages.OUTSIDE(value=number(value, 3), **self._range_in_words(name))
                )

    def outside(self, values: Mapping[str, Array]) -> dict[str, Array]:
        """Return which points are outside of the rows, by the input, each of shape (m,).

        Parameters
        ----------
        values : mapping of str to ndarray
            Free parameters, SI, each of shape (m,).
        """
        return {
            name: (at < span.share(self._lowest(name)) - _SAME) | (at > span.limit + _SAME)
            for (name, span), at in zip(self.ranges.items(), self.shares(values).T, strict=True)
            if name not in self._chosen
        }

    def left_out(self, name: str) -> str:
        """Return a sentence that intervals go beyond the rows with an input."""
        return messages.LEFT_OUT(**self._range_in_words(name))

    def _range_in_words(self, name: str) -> dict[str, str]:
        span = self.ranges[name]
        end = span.at(span.limit) if span.power == 0 else span.high
        low, high = number(self._lowest(name), 3), number(end, 3)
        shown = f"{name} / (ρ g d)" if name in self.stratum.varied.loads else name
        return {"name": _IN_WORDS.get(name, shown), "low": low, "high": high}

    def _lowest(self, name: str) -> float:
        """Return the lower end of an input: dry spheres and a smaller apparatus are known, too."""
        if name == SIZE:
            return self.ranges[name].at(_SMALLEST)
        low = self.ranges[name].low
        return min(self.stratum.limit.get(name, low), low)

    @cached_property
    def _chosen(self) -> Collection[str]:
        """Inputs that a laboratory chooses: lengths and speeds over their usual value."""
        varied = self.stratum.varied
        return [name for name in varied.factors if name not in varied.bounded]

    @cached_property
    def chosen_columns(self) -> tuple[int, ...]:
        """Their columns among the inputs."""
        return tuple(index for index, name in enumerate(self.ranges) if name in self._chosen)

    def beyond(self) -> Iterator[str]:
        """Yield a sentence for every one of them that is beyond the rows."""
        for name in self._chosen:
            span, value = self.ranges[name], self._apparatus[name]
            if not _has(span, value):
                yield messages.LESS_SURE(name=name, value=value, low=span.low, high=span.high)


@dataclass(frozen=True)
class _Walls:
    """Walls that the parts of a test are made of, by part; the plain one has no name.

    That of the first part, which most particles touch, is the wall of the atlas. Another one is
    told where an option of its part has a friction of its own in the rows.
    """

    parts: Mapping[str, str]
    options: Mapping[str, str]

    @classmethod
    def of(cls, solver: Solver, test: BulkTest) -> _Walls:
        parts = {part: solver.walls.get(part, PLAIN) for part in test.parts or ()}
        given = friction_options(type(test)).items()
        return cls(parts, {name: part for part, names in given for name in names})

    @property
    def first(self) -> str:
        return next(iter(self.parts.values()), PLAIN)

    def of_options(self, names: Iterable[str]) -> dict[str, str]:
        """Return the walls of the parts of which options are the friction."""
        known = self.options.keys() & names
        return {name: self.parts.get(self.options[name], PLAIN) for name in known}

    def require_told(self, varied: Collection[str]) -> None:
        told = {self.options[name] for name in varied if name in self.options}
        if any(wall != self.first for part, wall in self.parts.items() if part not in told):
            raise NotInAtlasError(messages.WALLS())


def _friction(option: str) -> str:
    """Return the parameter that the friction of a part has by default."""
    return WALL_SLIDING if "sliding" in option else WALL_ROLLING


def _strata_of(test: BulkTest) -> list[Stratum]:
    """Return the strata of a test, that of dry spheres first."""
    found = [one for one in strata().values() if one.kind.type == test.type]
    if not found:
        raise NotInAtlasError(messages.NO_ROWS())
    return found


def _models(solver: Solver) -> tuple[str, ...]:
    """Return the contact models that replace the usual ones."""
    return tuple(getattr(solver, "contact_models", ()))


def _cohesion(solver: Solver, material: Mapping[str, float]) -> str:
    """Return the model of cohesion that acts; empty without one."""
    law = contact_law(material, _models(solver))
    return "" if law.cohesion is None else law.cohesion.name


def _are(particles: Particles, test: BulkTest, cohesion: str) -> bool:
    """Return whether those of a test are of a kind; aspect ratios are inputs."""
    families = [one and one.definition() for one in (particles.shape, test.sizes.shape)]
    return families[0] == families[1] and particles.cohesion == cohesion


def _other_particles(of_test: Iterable[Stratum], test: BulkTest, cohesion: str) -> str:
    known = in_a_row(dict.fromkeys(one.particles.title for one in of_test))
    given = f"{test.sizes.shape or 'spheres'}{cohesion and f' with {cohesion}'}"
    return messages.PARTICLES(known=known, given=given)


def _require_told_law(solver: Solver, material: Mapping[str, float], walls: _Walls) -> None:
    if models := _models(solver):
        raise NotInAtlasError(messages.LAW(models=", ".join(models)))
    if material.get(_DAMPING, 0.0) > 0:
        raise NotInAtlasError(messages.DAMPING(name=_DAMPING, value=material[_DAMPING]))
    moduli = [material[on_wall("wall.youngs_modulus", one)] for one in {*walls.parts.values()}]
    if any(modulus < _RIGID * material[MODULUS] for modulus in moduli):
        raise NotInAtlasError(messages.SOFT_WALL())


class _Apparatus(NamedTuple):
    """Inputs of an apparatus that no material changes, and what is not as in the rows."""

    values: Mapping[str, float]
    #: Sentences about options that the rows do not vary.
    other: Sequence[str]
    #: Options beyond the range that they have.
    beyond: int


def _nearest(known: Sequence[Stratum], test: BulkTest) -> tuple[Stratum, _Apparatus]:
    """Return the stratum whose apparatus is most like that of a test, the usual one first.

    Raises
    ------
    InputError
        None is possible with the dimensions of the test.
    """
    found, faults = [], []
    for one in known:
        try:
            found.append((one, _apparatus(one, test)))
        except InputError as error:
            faults.append(error)
    if not found:
        raise faults[0]
    return min(found, key=lambda pair: (len(pair[1].other), pair[1].beyond))


def _apparatus(stratum: Stratum, test: BulkTest) -> _Apparatus:
    """Return the inputs of the apparatus of a test."""
    varied = stratum.varied
    scale = Scale(test.sizes.sauter_diameter, 1.0, float(test.gravity))
    given = test.resolved_options()
    loads = {name: given[name] / scale.of("Pa") for name in varied.loads}
    usual = dict.fromkeys(varied.factors, 1.0) | {n: given[n] for n in varied.values} | loads
    reference = stratum.options({**usual, SIZE: 1.0}, scale)
    size = given[varied.size_option] / reference[varied.size_option]
    usual[SIZE] = float(size ** (1 / varied.size_power))
    at_size = stratum.options(usual, scale)
    factors = [name for name in varied.factors if given[name] is not None]
    usual |= {name: given[name] / at_size[name] for name in factors}
    alike = stratum.apparatus(usual, scale).resolved_options()
    told = (*factors, *varied.values, *varied.indifferent, *NUMERICAL)
    other = [
        messages.OTHER_OPTION(
            name=name, value=_shown(test, name, value), usual=_shown(test, name, alike[name])
        )
        for name, value in given.items()
        if name not in told and not _is_same(value, alike[name])
    ]
    numbers = [(span, given[n]) for n, span in varied.values.items() if _is_number(given[n])]
    beyond = sum(not _has(span, value) for span, value in numbers)
    return _Apparatus({name: usual[name] for name in (SIZE, *varied.factors)}, other, beyond)


def _has(span: Range, value: float) -> bool:
    """Return whether the rows have a value, or one that is hardly beyond them."""
    return bool(-_SAME <= span.share(value) <= 1 + _SAME)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float))


def _is_same(one: Any, other: Any) -> bool:
    if _is_number(one) and _is_number(other):
        return math.isclose(one, other, rel_tol=_SAME)
    return bool(one == other)


def _shown(test: BulkTest, name: str, value: Any) -> str:
    """Return the value of an option for readers."""
    [key] = [one for one in test.option_keys() if one.name == name]
    return shown_value(key, value) or "not given"
