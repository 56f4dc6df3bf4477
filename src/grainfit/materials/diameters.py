"""Particle diameters as an option: one, classes by mass, or a distribution by mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grainfit.errors import InputError
from grainfit.materials import messages
from grainfit.materials.sieve_file import opening_column, read_sieve_curve
from grainfit.materials.size_classes import Truncation, divide
from grainfit.materials.size_distributions import (
    DIAMETER,
    LogNormal,
    RosinRammler,
    SieveCurve,
    SizeDistribution,
)
from grainfit.materials.sizes import ParticleSizes
from grainfit.options.fields import option_keys
from grainfit.options.kinds import Kind, ListOf, Schema, Share, Text, note_wrong_kind
from grainfit.options.paths import Located
from grainfit.options.places import Place
from grainfit.options.tables import Finish, Key, Table, Values

_FORMS = (
    'Write diameter = "10 mm"; a list: '
    '[{ value = "8 mm", mass_fraction = 0.3 }, { value = ..., mass_fraction = ... }]; or one of '
    '{ sieve_curve = "sieve.csv" }, { log_normal = { ... } } and { rosin_rammler = { ... } }.'
)


@dataclass(frozen=True)
class Diameters(Kind):
    """The particle diameter, a discrete distribution of diameters, or a continuous one."""

    def read(self, value: Any, place: Place) -> ParticleSizes | None:
        """Read one diameter, a list of diameters with mass fractions, or a distribution."""
        if isinstance(value, list):
            return self._classes(value, place)
        if isinstance(value, dict):
            if value.keys().isdisjoint(_DISTRIBUTIONS):
                note_wrong_kind(value, place, "a length, a list or a distribution", _FORMS)
                return None
            sizes: ParticleSizes | None = DISTRIBUTION.read(value, place)
            return sizes
        diameter = DIAMETER.read(value, place)
        return None if diameter is None else ParticleSizes((diameter,))

    @staticmethod
    def _classes(value: list[Any], place: Place) -> ParticleSizes | None:
        classes = _SIZE_CLASSES.read(value, place)
        if classes is None or any(
            None in (c.get("value"), c.get("mass_fraction")) for c in classes
        ):
            return None
        diameters = tuple(c["value"] for c in classes)
        fractions = tuple(c["mass_fraction"] for c in classes)
        if len(set(diameters)) < len(diameters):
            place.refuse(messages.SAME_DIAMETER.fault(""))
        elif abs(sum(fractions) - 1) > 1e-6:
            place.refuse(messages.SUM_OF_FRACTIONS.fault("", sum=sum(fractions)))
        else:
            return ParticleSizes(diameters, fractions)
        return None

    def schema(self) -> Schema:
        """Return the JSON Schema of all forms."""
        forms = DIAMETER.schema()["anyOf"]
        return {"anyOf": [*forms, _SIZE_CLASSES.schema(), DISTRIBUTION.schema()]}


_SIZE_CLASSES = ListOf(
    Table(
        (
            Key("value", DIAMETER, "Diameter of this class.", required=True, example='"8 mm"'),
            Key(
                "mass_fraction",
                Share(),
                "Share of the mass in this class, as a sieve gives it; all sum to 1.",
                required=True,
                example="0.3",
            ),
        )
    )
)


def _note_all(error: InputError, place: Place, otherwise: Place) -> None:
    """Note faults at their keys below a place; those without a key elsewhere."""
    for fault in error.faults:
        at = place.at(fault.key) if fault.key else otherwise
        at.refuse(fault)


def _made_by(distribution: type[SizeDistribution]) -> Finish:
    def finish(values: Values, place: Place) -> SizeDistribution | None:
        if None in values.values():
            return None
        try:
            return distribution(**values)
        except InputError as error:
            _note_all(error, place, place)
            return None

    return finish


def _divided(values: Values, place: Place) -> ParticleSizes | None:
    given = [name for name in _DISTRIBUTIONS if name in values]
    if len(given) != 1:
        place.refuse(messages.SEVERAL_DISTRIBUTIONS.fault("", given=" and ".join(given)))
        return None
    [name] = given
    if "opening_unit" in values and name != SieveCurve.key:
        place.at("opening_unit").refuse(messages.UNIT_WITHOUT_CURVE.fault(""))
        return None
    if None in values.values():
        return None
    distribution = values[name]
    if name == SieveCurve.key:
        column = opening_column(values.get("opening_unit"), place)
        distribution = column and read_sieve_curve(distribution, column, place.at(name))
    if distribution is None:
        return None
    options = {key.name: values[key.name] for key in _TRUNCATION if key.name in values}
    try:
        return divide(distribution, Truncation(**options))
    except InputError as error:
        _note_all(error, place, place.at(name))
        return None


_DISTRIBUTIONS = (SieveCurve.key, LogNormal.key, RosinRammler.key)
_TRUNCATION = option_keys(Truncation)
#: A continuous distribution.
DISTRIBUTION = Table(
    (
        Key(
            SieveCurve.key,
            Located(),
            "CSV file of a sieve analysis: a header, and one line for each sieve with its opening "
            "and the share of the mass that passes it, in percent.",
            example='"sieve.csv"',
        ),
        Key(
            "opening_unit",
            Text(),
            "Unit of the openings, unless the header of the file states it.",
            example='"mm"',
        ),
        Key(
            LogNormal.key,
            Table(option_keys(LogNormal), _made_by(LogNormal)),
            "Log-normal distribution by mass: median and geometric_standard_deviation, or d10 and "
            "d90.",
            example='{ median = "3 mm", geometric_standard_deviation = 1.4 }',
        ),
        Key(
            RosinRammler.key,
            Table(option_keys(RosinRammler), _made_by(RosinRammler)),
            "Rosin-Rammler distribution by mass: d63 and exponent.",
            example='{ d63 = "3 mm", exponent = 3 }',
        ),
        *_TRUNCATION,
    ),
    _divided,
)
