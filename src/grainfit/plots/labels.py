"""Labels of parameters and responses in figures: symbol, unit and description."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape

from markupsafe import Markup

from grainfit.bulk_tests.registry import response_info
from grainfit.contact_models.registry import material_parameter
from grainfit.formatting import plain, unit_for_people
from grainfit.work_folder.saved_calibration import SavedCalibration

#: Characters of a line beside a row of a figure: more would leave no room for it on a phone.
_LONGEST_LINE = 18


@dataclass(frozen=True)
class Label:
    """Label of a quantity.

    Parameters
    ----------
    name : str
        As in the calibration file; any text.
    symbol : str
        As in ``"μ_r_pp"``, where the text after the first ``_`` is the index; or the name.
    unit : str
        As shown to readers; ``""`` when there is none.
    description : str
        The quantity in words; ``""`` when there are none.
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
        """Symbol for the text of a figure, in which Plotly allows some tags."""
        return str(self._marked())

    @property
    def tick(self) -> str:
        """Symbol beside a row of a figure, in lines where it is a long name."""
        return "<br>".join(_lines(self._marked()) if self.symbol == self.name else [self.plot])

    @property
    def axis(self) -> str:
        """Symbol and unit for an axis."""
        words = f" ({escape(self.unit)})" if self.unit else ""
        return f"{self.plot}{words}"

    @property
    def words(self) -> str:
        """Description in a few words; the name if there is none."""
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


def _lines(name: str) -> Iterator[str]:
    """Yield a name in lines, divided after its dots and underscores."""
    line = ""
    for part in re.split(r"(?<=[._])", name):
        if line and len(line + part) > _LONGEST_LINE:
            yield line
            line = ""
        line += part
    yield line


def parameter_label(name: str, unit: str = "") -> Label:
    """Return the label of a parameter; a custom one is called by its name."""
    known = material_parameter(name)
    if known is None:
        return Label(name, name, unit_for_people(unit), "")
    return Label(name, known.symbol, unit_for_people(known.unit), known.description)


def response_label(name: str, unit: str = "") -> Label:
    """Return the label of a response; with several tests it is called ``test.response``."""
    test, _, last = name.rpartition(".")
    info = response_info(last)
    symbol, description = (name, "") if info is None else (info.symbol, info.description)
    if test and symbol != name:
        symbol = name
    return Label(name, symbol, unit_for_people(unit), description)


def in_words(saved: SavedCalibration, sentence: str) -> str:
    """Return a sentence with the words of the pages for free parameters and responses."""
    labels = [label_of_parameter(saved, one.name) for one in saved.problem.parameters]
    labels += [label_of_response(saved, name) for name in saved.problem.responses]
    words = {plain(label.name): label.words for label in labels}
    names = "|".join(map(re.escape, sorted(words, key=len, reverse=True)))
    return re.sub(rf"(?<![\w.])(?:{names})(?![\w.]*\w)", lambda m: words[m[0]], plain(sentence))


def label_of_parameter(saved: SavedCalibration, name: str) -> Label:
    """Return the label of a free or fixed parameter of a calibration."""
    return parameter_label(name, saved.units.get(name, ""))


def label_of_response(saved: SavedCalibration, name: str) -> Label:
    """Return the label of a response of a calibration."""
    units = {target.name: target.unit for target in saved.problem.targets}
    return response_label(name, units.get(name, ""))
