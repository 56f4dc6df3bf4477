"""How parameters and responses are called on the page: symbol, unit, and what it is in words."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from math import floor, inf, isfinite, log10

from markupsafe import Markup

from grainfit.material import MATERIAL_PARAMETERS
from grainfit.printable import plain

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Numbers between these are written without a power of ten.
_FIXED = 1e-3, 1e5
#: Of a value whose uncertainty is next to nothing.
_MOST_DIGITS = 6
_UNITS = {"kg/m^3": "kg/m³", "deg": "°", "m^3": "m³", "m^2": "m²", "m/s^2": "m/s²"}
_RESPONSES = {
    "bulk_density": ("ρ_b", "bulk density: mass of the bed over its volume, voids included"),
    "angle_of_repose": ("α", "angle of repose: inclination of the heap's flanks"),
}


@dataclass(frozen=True)
class Label:
    """What a quantity is called.

    Parameters
    ----------
    name : str
        As in the calibration file; any text.
    symbol : str
        As in ``"μ_r_pp"``, what is behind the first ``_`` being the index; or the name.
    unit : str
        For people, ``""`` when there is none.
    description : str
        What it is, in words; ``""`` when that is not known.
    """

    name: str
    symbol: str
    unit: str
    description: str

    @property
    def html(self) -> Markup:
        """Symbol for HTML, with the description to hover over."""
        if not self.description:
            return Markup("<span>{}</span>").format(plain(self.symbol))
        return Markup('<abbr title="{}">{}</abbr>').format(self.description, self._marked())

    @property
    def plot(self) -> str:
        """Symbol for a figure's text, where Plotly takes some tags."""
        return str(self._marked())

    @property
    def axis(self) -> str:
        """Symbol and unit for an axis."""
        words = f" ({escape(self.unit)})" if self.unit else ""
        return f"{self.plot}{words}"

    @property
    def words(self) -> str:
        """What it is in a few words; its name where there are none."""
        if self.symbol == self.name:
            return plain(self.name)
        return self.description.partition(":")[0]

    def _marked(self) -> Markup:
        if self.symbol == self.name:
            return Markup.escape(plain(self.name))
        symbol, _, index = self.symbol.partition("_")
        return (
            Markup("{}<sub>{}</sub>").format(symbol, index.replace("_", ","))
            if index
            else (Markup.escape(symbol))
        )


def parameter_label(name: str, unit: str = "") -> Label:
    """Return the label of a parameter; one of the user's own is called by its name."""
    known = MATERIAL_PARAMETERS.get(name)
    if known is None:
        return Label(name, name, unit_for_people(unit), "")
    return Label(name, known.symbol, unit_for_people(known.unit), known.description)


def response_label(name: str, unit: str = "") -> Label:
    """Return the label of a response; with several tests it is called ``test.response``."""
    test, _, last = name.rpartition(".")
    symbol, description = _RESPONSES.get(last, (name, ""))
    if test and symbol != name:
        symbol = name
    return Label(name, symbol, unit_for_people(unit), description)


def unit_for_people(unit: str) -> str:
    """Return a unit as it is printed."""
    return _UNITS.get(unit, plain(unit))


def with_unit(shown: str, unit: str) -> str:
    """Return a number, as it is shown, with a unit for people.

    Examples
    --------
    >>> with_unit("22", "°"), with_unit("1500", "kg/m³"), with_unit("0.5", "")
    ('22°', '1500 kg/m³', '0.5')
    """
    return f"{shown}{unit}" if unit in ("", "°") else f"{shown} {unit}"


def number(value: float | None, digits: int = 4) -> str:
    """Return a number with so many significant digits, for people.

    Examples
    --------
    >>> number(23456.0, 3), number(3.6e-7)
    ('23500', '3.6·10⁻⁷')
    """
    if value is None or not isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    if "e" in text and _FIXED[0] <= abs(value) < _FIXED[1]:
        text = f"{float(text):.0f}"
    return _with_power(text)


def rounded(value: float | None, uncertainty: float | None) -> str:
    """Return a value with the digits that mean something: down to two of its uncertainty.

    Examples
    --------
    >>> rounded(2309.4312, 31.0), rounded(0.52, 0.045)
    ('2309', '0.520')
    """
    if value is None or not isfinite(value):
        return "–"
    if uncertainty is None or not 0 < uncertainty < inf:
        return number(value)
    magnitude = floor(log10(abs(value))) if value else floor(log10(uncertainty))
    decimals = min(1 - floor(log10(uncertainty)), _MOST_DIGITS - 1 - magnitude)
    if not value or _FIXED[0] <= abs(value) < _FIXED[1]:
        # Adding zero: there is no minus zero for people.
        return _with_power(f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}")
    return _with_power(f"{value:.{max(magnitude + decimals, 0)}e}")


def _with_power(text: str) -> str:
    """Return a number as Python prints it with a true minus and power of ten."""
    mantissa, _, power = text.replace("-", "−").partition("e")
    if not power:
        return mantissa
    digits = power.lstrip("+").replace("−", "-")
    return f"{mantissa}·10{str(int(digits)).translate(_SUPERSCRIPTS)}"
