"""Format numbers, units and texts for readers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from math import ceil, floor, inf, isfinite, log10, pi
from typing import Any

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Numbers between these are written without a power of ten.
_FIXED = 1e-3, 1e5
#: Digits of a value whose uncertainty is almost zero.
_MOST_DIGITS = 6
#: Places of a table's text at which a spreadsheet would start a formula: its beginning, and the
#: separators of other countries and of lines. See OWASP, "CSV Injection".
_FORMULA = r"""(?=['"\s]*[=+\-@\uff1d\uff0b\uff0d\uff20])"""
_CELL_START = rf"(^(?:{_FORMULA}|(?='*[\t\r\n]))|[;\t\r\n]{_FORMULA})"
_FORMULA_START = re.compile(_CELL_START)
_ESCAPED_START = re.compile(_CELL_START.replace("(?=", "(?='"))
#: Below this share of a value, half of its interval is nothing but rounding of the computer.
_ROUNDING = 1e-9
#: Significant digits of numbers as they are given, and what products of them are off, relative.
_SHORT, _NOISE = 12, 1e-15
_POWER = re.compile(r"\^([+-]?\d+)")
_DAY = 86_400
#: Durations from this number of days on are told without hours.
_WHOLE_DAYS = 10


def unit_for_people(unit: str) -> str:
    """Return a unit as readers expect it.

    Examples
    --------
    >>> unit_for_people("kg/m^3"), unit_for_people("mJ/m^2"), unit_for_people("deg")
    ('kg/m³', 'mJ/m²', '°')
    """
    if unit == "deg":
        return "°"
    return _POWER.sub(lambda power: str(int(power[1])).translate(_SUPERSCRIPTS), plain(unit))


def as_sentence(words: str) -> str:
    """Return words with a capital letter at their beginning; other letters stay."""
    return words[:1].upper() + words[1:]


def with_unit(shown: str, unit: str) -> str:
    """Return a formatted number with its unit.

    Examples
    --------
    >>> with_unit("22", "°"), with_unit("1500", "kg/m³"), with_unit("0.5", "")
    ('22°', '1500 kg/m³', '0.5')
    """
    return f"{shown}{unit}" if unit in ("", "°") else f"{shown} {unit}"


def value_with_unit(value: float, unit: str) -> str:
    """Return a value with up to six digits, in a unit as readers expect it.

    Examples
    --------
    >>> value_with_unit(2205.0, "kg/m^3"), value_with_unit(0.45, "")
    ('2205 kg/m³', '0.45')
    """
    return with_unit(f"{value:g}", unit_for_people(unit))


def in_unit(name: str, unit: str) -> str:
    """Return a name with its unit, as the head of a row or a column of values.

    Examples
    --------
    >>> in_unit("angle_of_repose", "deg"), in_unit("share", "")
    ('angle_of_repose in °', 'share')
    """
    return f"{name} in {unit_for_people(unit)}" if unit else name


def assigned(
    values: Mapping[str, float], units: Mapping[str, str], digits: int = 4
) -> Iterator[str]:
    """Yield each value with its name and its unit.

    Examples
    --------
    >>> list(assigned({"particle.density": 2308.79}, {"particle.density": "kg/m^3"}))
    ['particle.density = 2309 kg/m³']
    """
    for name, value in values.items():
        unit = unit_for_people(units.get(name, ""))
        yield f"{plain(name)} = {with_unit(number(value, digits), unit)}"


def probability(value: float) -> str:
    """Return a probability in percent: no metamodel makes anything certain."""
    if value > 0.995:
        return "more than 99\u00a0%"
    return "less than 1\u00a0%" if value < 0.005 else f"{100 * value:.0f}\u00a0%"


def plain_probability(value: float) -> str:
    """Return `probability` with a plain space, for terminals and messages."""
    return probability(value).replace("\u00a0", " ")


def number(value: float | None, digits: int = 4) -> str:
    """Return a number with some significant digits, for readers.

    Examples
    --------
    >>> number(23456.0, 3), number(3.6e-7)
    ('23500', '3.6·10⁻⁷')
    """
    if value is None or not isfinite(value):
        return "–"
    return with_power(_significant(value, digits))


def _significant(value: float, digits: int) -> str:
    text = f"{value:.{digits}g}"
    if "e" in text and _FIXED[0] <= abs(value) < _FIXED[1]:
        text = f"{float(text):.0f}"
    return text


def rounded_off(value: float, digits: int, *, up: bool) -> float:
    """Return a value with some significant digits that is not below it, or not above it.

    Examples
    --------
    >>> rounded_off(10.2, 2, up=True), rounded_off(0.1289, 2, up=False)
    (11.0, 0.12)
    """
    if value == 0:
        return 0.0
    unit = 10.0 ** (floor(log10(abs(value))) - digits + 1)
    steps = ceil(value / unit) if up else floor(value / unit)
    return float(f"{steps * unit:.6g}")


def without_noise(value: float, size: float | None = None) -> float:
    """Return the number of twelve digits that a value is, but for rounding of the computer.

    Other numbers keep all digits.

    Parameters
    ----------
    value : float
        Any number.
    size : float, optional
        Of the quantities that it was computed from, where it may be a small difference of them.

    Examples
    --------
    >>> without_noise(3 * 0.003), without_noise(2.7e-20, size=0.009), without_noise(2 / 3)
    (0.009, 0.0, 0.6666666666666666)
    """
    if value == 0 or not isfinite(value):
        return value
    size = abs(size or value)
    short = round(value, _SHORT - 1 - floor(log10(size))) + 0.0
    return short if abs(short - value) <= _NOISE * size else value


def rounded(value: float | None, uncertainty: float | None) -> str:
    """Return a value with its significant digits: down to two digits of its uncertainty.

    Examples
    --------
    >>> rounded(2309.4312, 31.0), rounded(0.52, 0.045), rounded(0.0, 1e-13)
    ('2309', '0.520', '0')
    """
    if value is None or not isfinite(value):
        return "–"
    return with_power(_to_uncertainty(value, uncertainty))


def on_curve(place: float, coordinate: str, unit: str) -> str:
    """Return a place on a curve in words.

    Examples
    --------
    >>> on_curve(0.04, "strain", ""), on_curve(20.0, "", "deg")
    ('strain = 0.04', 'coordinate = 20°')
    """
    return f"{coordinate or 'coordinate'} = {with_unit(number(place), unit_for_people(unit))}"


def plain_interval(value: float, half_width: float) -> str:
    """Return a value and half of its interval as programs write numbers, to be copied.

    Examples
    --------
    >>> plain_interval(22.0034, 0.381), plain_interval(1498.2, 14.3), plain_interval(30.0, 0.0)
    ('22.00 ± 0.38', '1498 ± 14', '30 ± 0')
    >>> plain_interval(-0.0000134, 0.012)
    '0.000 ± 0.012'
    """
    half_width = telling(half_width, value)
    return f"{_to_uncertainty(value, half_width)} ± {_to_uncertainty(half_width, half_width)}"


def interval(value: float, half_width: float) -> str:
    """Return a value and half of its interval, for readers.

    Examples
    --------
    >>> interval(9.279e6, 4.35e5), interval(22.0034, 0.381)
    ('9.28·10⁶ ± 4.4·10⁵', '22.00 ± 0.38')
    """
    half_width = telling(half_width, value)
    return f"{rounded(value, half_width)} ± {rounded(half_width, half_width)}"


def telling(half_width: float, value: float) -> float:
    """Return half of an interval, or zero where it is rounding of the computer.

    Examples
    --------
    >>> telling(0.01, 22.0), telling(4e-15, 0.00114)
    (0.01, 0.0)
    """
    return half_width if half_width > _ROUNDING * abs(value) else 0.0


def _to_uncertainty(value: float, uncertainty: float | None) -> str:
    if uncertainty is None or not 0 < uncertainty < inf:
        return _significant(value, 4)
    if not value and uncertainty < _FIXED[0]:
        return "0"
    magnitude = floor(log10(abs(value))) if value else floor(log10(uncertainty))
    decimals = min(1 - floor(log10(uncertainty)), _MOST_DIGITS - 1 - magnitude)
    if not value or _FIXED[0] <= max(abs(value), uncertainty) < _FIXED[1]:
        # Adding zero turns minus zero into zero.
        return f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"
    return f"{value:.{max(magnitude + decimals, 0)}e}"


def deviation_off(percent: float | None, difference: float, tolerance: float, unit: str) -> str:
    """Return a deviation with its sign: in percent, or with its unit where that makes no sense.

    Parameters
    ----------
    percent : float or None
        The deviation in percent.
    difference, tolerance : float
        The deviation and its tolerance, in the unit; two digits of the tolerance are shown.
    unit : str
        Unit as it is to be shown.

    Examples
    --------
    >>> deviation_off(-2.114, -31.7, 15.0, "kg/m³")
    '-2.11 %'
    >>> deviation_off(None, 0.0141, 0.05, "mm"), deviation_off(None, -1e-9, 0.05, "mm")
    ('+0.014 mm', '+0.000 mm')
    """
    if percent is not None:
        return percentage_off(percent)
    decimals = 1 - floor(log10(tolerance))
    shown = round(difference, decimals) + 0.0
    form = f"+.{decimals}f" if 0 <= decimals <= _MOST_DIGITS else "+.4g"
    return with_unit(f"{shown:{form}}", unit)


def percentage_off(percent: float) -> str:
    """Return a deviation in percent with its sign, and no minus before zero.

    Examples
    --------
    >>> percentage_off(-0.0004), percentage_off(-2.114)
    ('+0.00 %', '-2.11 %')
    """
    return f"{round(percent, 2) + 0.0:+.2f} %"


def _telling_digits(low: float, high: float) -> int:
    """Number of significant digits with which both ends of an interval differ."""
    share = (high - low) / max(abs(low), abs(high), 1e-300)
    return min(max(1 - floor(log10(max(share, 1e-9))), 3), _MOST_DIGITS)


def ends(low: float, high: float) -> str:
    """Return both ends of an interval, for readers.

    Examples
    --------
    >>> ends(0.4712, 0.8193), ends(2256.8, 2256.9)
    ('0.471 to 0.819', '2256.8 to 2256.9')
    """
    digits = _telling_digits(low, high)
    return f"{number(low, digits)} to {number(high, digits)}"


def plain_ends(low: float, high: float) -> str:
    """Return both ends of an interval as programs write numbers, to be copied.

    Examples
    --------
    >>> plain_ends(1.1234e6, 8.8e7)
    '1.12e+06 to 8.8e+07'
    """
    digits = _telling_digits(low, high)
    return f"{_significant(low, digits)} to {_significant(high, digits)}"


def with_power(text: str) -> str:
    """Return a number printed by Python with a typographic minus sign and power of ten.

    Examples
    --------
    >>> with_power("-5.0e-04")
    '−5.0·10⁻⁴'
    """
    mantissa, _, power = text.replace("-", "−").partition("e")
    if not power:
        return mantissa
    digits = power.lstrip("+").replace("−", "-")
    return f"{mantissa}·10{str(int(digits)).translate(_SUPERSCRIPTS)}"


def plain(text: str) -> str:
    r"""Return a text as one line that is safe for a terminal: control characters are escaped.

    Examples
    --------
    >>> plain("red: \x1b[31m")
    'red: \\x1b[31m'
    """
    shown = text.replace("\t", "    ")
    if shown.isprintable():
        return shown
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in shown
    )


def plain_lines(text: str) -> list[str]:
    """Return the lines of a text, each as `plain` makes it."""
    return [plain(line) for line in text.splitlines()]


def spreadsheet_text(text: str) -> str:
    """Return a text as a cell of a table that no spreadsheet takes for a formula.

    An apostrophe comes before what would be one. Numbers, negative ones too, stay as they are.

    Examples
    --------
    >>> spreadsheet_text("=1+1"), spreadsheet_text("a;@b"), spreadsheet_text("-5")
    ("'=1+1", "a;'@b", '-5')
    """
    return text if _is_number(text) else _FORMULA_START.sub(r"\1'", text)


def from_spreadsheet_text(cell: str) -> str:
    """Return the text from which `spreadsheet_text` made a cell.

    Examples
    --------
    >>> from_spreadsheet_text("'=1+1"), from_spreadsheet_text("it's")
    ('=1+1', "it's")
    """
    if "'" not in cell:
        return cell
    starts = {match.end() for match in _ESCAPED_START.finditer(cell)}
    return "".join(character for i, character in enumerate(cell) if i not in starts)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def duration(seconds: float) -> str:
    """Return a duration in hours, minutes and seconds; from two days on in days.

    Examples
    --------
    >>> duration(3720), duration(190_000), duration(5.12e8)
    ('1 h 02 min', '2 days 05 h', '5926 days')
    """
    if seconds >= _WHOLE_DAYS * _DAY:
        return f"{seconds / _DAY:.0f} days"
    if round(seconds) >= 2 * _DAY:
        days, hours = divmod(round(seconds / 3600), 24)
        return f"{days} days {hours:02d} h"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


def millimetres(length: float) -> str:
    """Return a length, given in m, with three digits in millimetres.

    Examples
    --------
    >>> millimetres(0.00286), millimetres(1.2)
    ('2.86 mm', '1200 mm')
    """
    return in_usual_unit(length, "m", 3)


def turns_per_minute(speed: float) -> str:
    """Return a rotational speed, given in rad/s, with three digits in turns a minute.

    Examples
    --------
    >>> turns_per_minute(1.1073617)
    '10.6 rpm'
    """
    return in_usual_unit(speed, "rad/s", 3)


def in_usual_unit(value: float, unit: str, digits: int = 4) -> str:
    """Return a value, given in an SI unit, in the unit of a laboratory.

    Examples
    --------
    >>> in_usual_unit(0.06, "m"), in_usual_unit(2.11e11, "Pa"), in_usual_unit(9.81, "m/s^2")
    ('60 mm', '211 GPa', '9.81 m/s²')
    >>> in_usual_unit(0.00135, "m^3"), in_usual_unit(500.0, "Pa"), in_usual_unit(10000.0, "Pa")
    ('1350 cm³', '500 Pa', '10 kPa')
    """
    usual, name = _in_usual_unit(value, unit)
    return with_unit(number(usual, digits), name)


def _in_usual_unit(value: float, unit: str) -> tuple[float, str]:
    # Factors are whole numbers, which are exact: so a tie is rounded alike wherever it is shown.
    match unit:
        case "m":
            return 1000 * value, "mm"
        case "m^3":
            return 1e6 * value, "cm³"
        case "rad/s":
            return 30 * value / pi, "rpm"
        case "Pa":
            sizes = ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"))
            size, name = next((one for one in sizes if value >= one[0]), (1.0, "Pa"))
            return value / size, name
    return value, unit_for_people(unit)


def percent(share: float) -> str:
    """Return a share as a percentage with three digits, or more if they would make it the whole.

    Examples
    --------
    >>> percent(0.2), percent(0.99987), percent(1.004)
    ('20 %', '99.99 %', '100.4 %')
    """
    written = (f"{100 * share:.{digits}g}" for digits in range(3, 13))
    return f"{next((text for text in written if text != '100'), '100')} %"


def counted(count: int, noun: str) -> str:
    """Return a count with its noun, singular or plural.

    Examples
    --------
    >>> counted(1, "run"), counted(3, "run")
    ('1 run', '3 runs')
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def in_a_row(names: Iterable[str], last: str = "and") -> str:
    """Return names as in a sentence.

    Examples
    --------
    >>> in_a_row(["a", "b", "c"], "or")
    'a, b or c'
    """
    *first, end = names
    return f"{', '.join(first)} {last} {end}" if first else end


def alike(texts: Iterable[str]) -> list[list[str]]:
    """Return texts in groups that differ in their numbers only, the largest group first.

    Examples
    --------
    >>> alike(["no heap", "no rest in 4.1 s", "no rest in 12 s"])
    [['no rest in 4.1 s', 'no rest in 12 s'], ['no heap']]
    """
    found: dict[str, list[str]] = {}
    for text in texts:
        found.setdefault(re.sub(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "#", text), []).append(text)
    return sorted(found.values(), key=len, reverse=True)


def causes(reasons: Iterable[str]) -> list[str]:
    """Return why runs failed, with one example of reasons that differ in their numbers only.

    Examples
    --------
    >>> causes(["no heap.", "no rest in 4.1 s.", "no rest in 12 s."])
    ['no rest in 4.1 s (2 alike).', 'no heap.']
    """
    return [
        f"{one.removesuffix('.')} ({1 + len(others)} alike){'.' * one.endswith('.')}"
        if others
        else one
        for one, *others in alike(reasons)
    ]


def short_names(names: Sequence[str]) -> list[str]:
    """Return dotted names as headings: without sections where they stay different, in words.

    Examples
    --------
    >>> short_names(["particle_particle.sliding_friction", "wall.density", "particle.density"])
    ['sliding friction', 'wall.density', 'particle.density']
    """
    last = [name.rpartition(".")[2] for name in names]
    return [
        (own if last.count(own) == 1 else name).replace("_", " ")
        for own, name in zip(last, names, strict=True)
    ]


def variable_name(name: str) -> str:
    """Return a parameter's name as a solver's variable: ``particle_density``."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)


def short_repr(owner: Any, *first: str) -> str:
    """Return a dataclass in one line: some arguments by position, others unless they are defaults.

    Examples
    --------
    >>> from grainfit.evaluation import Response
    >>> short_repr(Response(2.0), "value"), short_repr(Response(2.0, 0.5), "value")
    ('Response(2.0)', 'Response(2.0, standard_error=0.5)')
    """
    parts = [repr(getattr(owner, key)) for key in first]
    values = {f.name: (getattr(owner, f.name), f.default) for f in fields(owner)}
    parts += [
        f"{name}={value!r}"
        for name, (value, default) in values.items()
        if name not in first and value != default
    ]
    return f"{type(owner).__name__}({', '.join(parts)})"
