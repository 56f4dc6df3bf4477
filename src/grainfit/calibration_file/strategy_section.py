"""The ``[strategy]`` table of the calibration file, derived from the declared options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grainfit.calibration.options import CalibrationOptions
from grainfit.calibration_file.content import SearchOptions
from grainfit.errors import InputError
from grainfit.options.fields import option_keys
from grainfit.options.kinds import Choice, Kind, Quantity, Schema, Whole
from grainfit.options.places import Place
from grainfit.options.tables import Key, Table, Values
from grainfit.strategies.registry import (
    DEFAULT_STRATEGY,
    all_options,
    make_strategy,
    merged_key,
    option_faults,
    strategies,
)

#: Weight in `Problem`, which only some strategies take into account.
RAYLEIGH_WEIGHT = Key(
    "rayleigh_weight",
    Quantity("", lowest=0.0),
    "Weight of the Rayleigh criterion among the deviations. Above 0 it trades accuracy for a "
    "larger time step. Strategy: staged.",
    default="0",
)
#: Relatives of the tests, which only some strategies run.
SOFTER = Key(
    "softer",
    Quantity("Pa", above_zero=True),
    "Young's modulus of softer particles, with which a part of the search runs: a fixed "
    "`particle.youngs_modulus` of 10 MPa takes 2.7 times the computing time of 0.5 MPa. What they "
    "give is corrected by runs with the stiff particles, on which the verdict rests alone. "
    "Strategy: sequential.",
    example='"0.5 MPa"',
    default="none",
)
COARSER = Key(
    "coarser",
    Quantity("", lowest=1.0, highest=20.0),
    "Times the particle diameters with which a part of the search runs, in the same apparatus: 2 "
    "takes a sixteenth of the computing time. What they give is corrected by runs of the real "
    "test, on which the verdict rests alone. Strategy: sequential.",
    example="2",
    default="none",
)
SMALLER = Key(
    "smaller",
    Quantity("", highest=1.0, above_zero=True),
    "Share of the particles with which a part of the search runs, in an apparatus that is smaller "
    "in all directions. What they give is corrected by runs of the real test, on which the "
    "verdict rests alone. Strategy: sequential.",
    example="0.1",
    default="none",
)
#: Smaller apparatus instead of those of the tests.
TWINS = Key(
    "twins",
    Whole(100),
    "Number of particles: each test that holds more is simulated in an apparatus smaller in all "
    "directions that holds so many, and its responses at the real size follow from a series of "
    "sizes at the answer. The result is predicted until `grainfit run FILE --full-size` has made "
    "one run of each real test.",
    example="1500",
    default="none",
)
RELATIVES = (SOFTER, COARSER, SMALLER)
#: Options of every calibration, with any strategy.
CALIBRATION_KEYS = (*option_keys(CalibrationOptions), RAYLEIGH_WEIGHT, *RELATIVES, TWINS)


def name_key() -> Key:
    """Return the key that names the strategy."""
    default = f'"{DEFAULT_STRATEGY}"'
    kind = Choice(tuple(strategies()))
    return Key("name", kind, "Strategy that chooses the runs.", example=default, default=default)


def strategy_keys() -> list[str]:
    """Return the names of all keys except that of the strategy's name."""
    return [*(known.name for known in CALIBRATION_KEYS), *all_options()]


@dataclass(frozen=True)
class StrategySection(Kind):
    """Options of the calibration, and of the strategy that the table names.

    Parameters
    ----------
    homes : mapping of str to str
        Right section of keys that belong elsewhere, for the remedy.
    """

    homes: Mapping[str, str]

    def read(self, value: Any, place: Place) -> SearchOptions | None:
        """Read the table; an option that the named strategy does not have is a fault."""
        own: tuple[Key, ...] = ()
        if isinstance(value, dict):
            name = value.get("name", DEFAULT_STRATEGY)
            if isinstance(name, str) and name in strategies():
                own = option_keys(strategies()[name])
                for fault in option_faults(name, _of_strategies(value)):
                    place.at(fault.key).refuse(fault)
            # A wrong name is noted below; options of other strategies are noted above.
            names = {key.name for key in own}
            value = {k: v for k, v in value.items() if k in names or k not in all_options()}
        options: SearchOptions | None = self._of_calibration(own).read(value, place)
        return options

    def schema(self) -> Schema:
        """Return the JSON Schema of the table with the options of all strategies."""
        schema = self._of_calibration().schema()
        for name, declared in all_options().items():
            schema["properties"][name] = _merged_schema(declared)
        return schema

    def _of_calibration(self, own: tuple[Key, ...] = ()) -> Table:
        keys = (name_key(), *CALIBRATION_KEYS, *own)
        return Table(keys, _search_options, self.homes)


def _search_options(values: Values, place: Place) -> SearchOptions | None:
    if None in values.values():
        return None
    name = values.pop("name", DEFAULT_STRATEGY)
    weight = values.get(RAYLEIGH_WEIGHT.name, 0.0)
    of_strategy = _of_strategies(values)
    rest = {key: value for key, value in values.items() if key not in of_strategy}
    try:
        strategy = make_strategy(name, of_strategy)
        strategy.check_rayleigh_weight(weight)
        asked = [key.name for key in RELATIVES if values.get(key.name)]
        strategy.check_relatives(asked[0] if asked else "")
        return SearchOptions(strategy=strategy, **rest)
    except InputError as error:
        for fault in error.faults:
            place.at(fault.key).refuse(fault)
        return None


def _of_strategies(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if key in all_options()}


def _merged_schema(declared: Mapping[str, Key]) -> Schema:
    schema = merged_key(declared).schema()
    kinds = [key.kind.schema() for key in declared.values()]
    if all(kind == kinds[0] for kind in kinds):
        return schema
    return {"description": schema["description"], "anyOf": kinds}
