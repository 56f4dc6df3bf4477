"""Find out which parameters a custom model mentions, and which names in its templates are none."""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from grainfit.errors import Fault
from grainfit.formatting import variable_name
from grainfit.options.kinds import suggest
from grainfit.solvers.own_model import messages
from grainfit.solvers.own_model.fill_templates import ALL_VALUES
from grainfit.solvers.own_model.model_folder import ModelFolder
from grainfit.solvers.own_model.model_input import (
    INCLUDE_NAME,
    JSON_NAME,
    RESERVED,
    SEEDS,
    Templates,
)
from grainfit.solvers.own_model.template_names import Path, TemplateNames, Use


@dataclass(frozen=True)
class Undefined:
    """Name in a template that is no parameter.

    Parameters
    ----------
    where : str
        Template and line.
    path : tuple of str
        The name.
    known : tuple of str
        Names that it can have.
    """

    where: str
    path: Path
    known: tuple[str, ...]

    @property
    def meant(self) -> list[str]:
        """The known name that is most like it, if there is one."""
        return difflib.get_close_matches(self._name, self.known, n=1)

    @property
    def fault(self) -> Fault:
        """The fault, with a suggestion."""
        shown = f'{ALL_VALUES}["{self._name}"]' if self.path[0] == ALL_VALUES else self._name
        remedy = suggest(self._name, self.known, "There are")
        return messages.UNDEFINED.fault(self.where, name=shown, remedy=remedy)

    @property
    def _name(self) -> str:
        return self.path[1] if self.path[0] == ALL_VALUES else ".".join(self.path)


@dataclass(frozen=True)
class Mentions:
    """Names of parameters in a model.

    Parameters
    ----------
    text : bytes
        Text of its files and arguments, without what templates fill in.
    templates : mapping of str to TemplateNames
        Names in its templates, by their place.
    included : tuple of TemplateNames
        Names in templates that only others fill in.
    known : frozenset of str
        Names that every template has without being given them.
    reads_all : bool
        Whether it reads the values of all parameters.
    """

    text: bytes
    templates: Mapping[str, TemplateNames]
    included: tuple[TemplateNames, ...]
    known: frozenset[str]
    reads_all: bool

    def __contains__(self, name: str) -> bool:
        """Return True if the model mentions a parameter."""
        variable = variable_name(name)
        # LAMMPS refers to its variables as ${name} and as v_name.
        names = (name, variable, f"v_{variable}")
        return (
            self.reads_all
            or any(_has_name(self.text, form) for form in names)
            or any(self._is_read(name, path) for path in self._paths)
        )

    @property
    def has_seed(self) -> bool:
        """Whether the model has the name of a seed, or reads all values in a template."""
        in_templates = (self._is_read(name, path) for name in SEEDS for path in self._paths)
        return b"seed" in self.text or any(in_templates)

    def undefined(self, names: Collection[str]) -> Iterator[Undefined]:
        """Yield the names in templates that are none of the parameters, nor else known.

        Parameters
        ----------
        names : collection of str
            Names of all parameters that the model is passed.
        """
        for where, template in self.templates.items():
            for use in template.uses:
                if self._is_undefined(use, template, names):
                    yield Undefined(f"{where}, line {use.line}", use.path, (*names, *RESERVED))

    @cached_property
    def _all(self) -> tuple[TemplateNames, ...]:
        return (*self.templates.values(), *self.included)

    @cached_property
    def _paths(self) -> frozenset[Path]:
        return frozenset(use.path for template in self._all for use in template.uses)

    @cached_property
    def _loose_keys(self) -> frozenset[str]:
        return frozenset().union(*(template.loose_keys for template in self._all))

    @cached_property
    def _has_computed_keys(self) -> bool:
        return any(template.has_computed_keys for template in self._all)

    def _is_read(self, name: str, path: Path) -> bool:
        """Return True if reading a path may read a parameter."""
        if path[0] == ALL_VALUES:
            return path[1:2] == (name,) or _is_whole_table(path)
        parts = tuple(name.split("."))
        if path != parts[: len(path)]:
            return path[: len(parts)] == parts
        # A section may be given another name: {% set p = particle %}{{ p.density }}.
        return self._has_computed_keys or self._loose_keys.issuperset(parts[len(path) :])

    def _is_undefined(self, use: Use, template: TemplateNames, names: Collection[str]) -> bool:
        path = use.path
        if not use.is_certain or path[0] in template.own or path[0] in self.known:
            return False
        if any(path[: len(tested)] == tested for tested in template.optional):
            return False
        if path[0] == ALL_VALUES:
            return not _is_whole_table(path) and path[1] not in names
        if path[0] in RESERVED:
            return False
        given = (tuple(name.split(".")) for name in names)
        return not any(path[: len(parts)] == parts[: len(path)] for parts in given)


def read_mentions(
    model: ModelFolder,
    command: Sequence[str],
    template_files: Collection[str],
    evaluations: Collection[str],
) -> Mentions:
    """Read a model.

    Parameters
    ----------
    model : ModelFolder
        The model.
    command : sequence of str
        Program and arguments.
    template_files : collection of str
        Names of the files that are filled in.
    evaluations : collection of str
        Names of the files that only evaluate a run.

    Raises
    ------
    InputError
        A file cannot be read.
    """
    filler = Templates(model)
    contents = {name: model.read(name) for name in model.files()}
    arguments = {f"command[{i}]": os.fsencode(text) for i, text in enumerate(command)}
    filled = {name: contents[name] for name in template_files}
    filled |= {where: text for where, text in arguments.items() if where != "command[0]"}
    found = {where: filler.names(text) for where, text in filled.items()}
    templates = {where: names for where, names in found.items() if names is not None}
    texts = [
        templates[where].text.encode() if where in templates else text
        for where, text in (contents | arguments).items()
        if where not in evaluations or _gets_values(where, text, filled, arguments)
    ]
    everything = [*contents.values(), *arguments.values()]
    return Mentions(
        b"\n".join(texts),
        templates,
        tuple(_included(templates, filler, contents)),
        filler.known_names,
        any(JSON_NAME.encode() in text for text in everything),
    )


def _gets_values(
    evaluation: str, text: bytes, filled: Collection[str], arguments: Mapping[str, bytes]
) -> bool:
    """Return True if the file of an evaluation can read values of parameters, or simulates too."""
    is_executed = any(evaluation.encode() in argument for argument in arguments.values())
    return evaluation in filled or is_executed or INCLUDE_NAME.encode() in text


def _included(
    templates: Mapping[str, TemplateNames], filler: Templates, contents: Mapping[str, bytes]
) -> Iterator[TemplateNames]:
    """Yield the names of templates that others include, unless they are filled in themselves."""
    seen = set(templates)
    waiting = [name for names in templates.values() for name in names.templates]
    while waiting:
        name = waiting.pop()
        if name in seen or name not in contents:
            continue
        seen.add(name)
        if (names := filler.names(contents[name])) is not None:
            yield names
            waiting += names.templates


def _is_whole_table(path: Path) -> bool:
    """Return True for ``parameters`` and ``parameters.items``, but not ``parameters["x"]``."""
    return len(path) == 1 or hasattr(dict, path[1])


def _has_name(text: bytes, name: str) -> bool:
    """Return True if a text has a name that is no part of a longer one."""
    found = re.escape(name.encode())
    # The name comes first, because a search for its beginning is fast in large files.
    return re.search(rb"%b(?!\w)(?<!\w%b)" % (found, found), text) is not None
