"""Fill in the templates of a custom model, as a separate program.

    python -P fill_templates.py REQUEST.json ANSWER.json BYTES

A template may come from somebody else, loop for hours or need all memory: a process has limits and
can be ended. It is started in the run folder and uses only Jinja2 and the standard library, so that
it starts fast.
"""

import json
import os
import sys
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jinja2
from jinja2.sandbox import SandboxedEnvironment

#: Name of all values in templates, for those that are no names in Jinja2.
ALL_VALUES = "parameters"
_GIB = 2**30
#: Limits of a process; Windows has none.
_limits: Any = None
with suppress(ImportError):
    import resource as _limits


def open_environment(read: Callable[[str], bytes]) -> SandboxedEnvironment:
    """Return a Jinja2 environment in which an undefined name is an error.

    Parameters
    ----------
    read : callable
        Returns the contents of a file of the model by name; raises `OSError` or `ValueError` if
        there is none.
    """

    def load(name: str) -> str | None:
        try:
            contents = read(name)
        except (OSError, ValueError):
            return None
        return contents.decode("utf-8")

    # A template may come from somebody else; it must only format values.
    return SandboxedEnvironment(
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        loader=jinja2.FunctionLoader(load),
    )


def fill(request: Mapping[str, Any], folder: Path, begin: Callable[[str], Any]) -> dict[str, Any]:
    """Fill in files of a run folder and texts.

    Parameters
    ----------
    request : mapping
        ``model``, the folder with the templates; ``files``, the name of each filled-in file by the
        name of its template; ``texts`` by their place in the calibration file; ``values``;
        ``seeds``.
    folder : Path
        The run folder, a copy of the model.
    begin : callable
        Called with the name of each template before it is filled in.

    Returns
    -------
    dict
        ``texts``, filled in; or ``fault``: key, message and remedy.

    Raises
    ------
    OSError
        The run folder cannot be written.
    """
    environment = open_environment(_reader(request["model"]))
    context = _context(request["values"], request["seeds"])
    texts: list[str] = []
    where = ""
    try:
        for where, target in request["files"].items():
            begin(where)
            text = environment.get_template(where).render(context)
            _write(folder, where, target, text)
        for where, text in request["texts"].items():
            begin(where)
            texts.append(environment.from_string(text).render(context))
    # An expression in a template can raise any exception.
    except Exception as error:
        # Jinja2 calls a missing template an OSError, too.
        if isinstance(error, OSError) and not isinstance(error, jinja2.TemplateNotFound):
            raise
        return {"fault": fault_of(error, where)}
    return {"texts": texts}


def fault_of(error: Exception, where: str) -> tuple[str, str, str]:
    """Return key, message and remedy of the fault of a template."""
    reason = str(error).removesuffix(".")
    if isinstance(error, jinja2.TemplateSyntaxError):
        key = f"{error.name or where}, line {error.lineno}"
        return key, f"is not a valid template: {reason}.", ""
    if isinstance(error, jinja2.TemplateNotFound):
        return where, f"there is no template {error.name!r} in the folder.", ""
    if isinstance(error, UnicodeDecodeError):
        return where, "is not a text in UTF-8.", "Only texts can be templates."
    if isinstance(error, MemoryError):
        return where, f"cannot be filled in{_within()}.", "Shorten its loops and texts."
    return f"{where}{_line(error)}", f"cannot be filled in: {reason}.", ""


def _reader(model: str) -> Callable[[str], bytes]:
    inside = os.path.realpath(model)

    def read(name: str) -> bytes:
        path = Path(os.path.realpath(Path(model, name)))
        if not path.is_relative_to(inside):
            raise ValueError(f"{name!r} is outside the folder")
        return path.read_bytes()

    return read


def _context(values: Mapping[str, float], seeds: Mapping[str, int]) -> dict[str, Any]:
    """Return the names in templates: ``particle.density``, ``seed``, ``parameters["x"]``."""
    root = SimpleNamespace()
    for name, value in values.items():
        *sections, key = name.split(".")
        table = root
        for section in sections:
            table = vars(table).setdefault(section, SimpleNamespace())
        vars(table)[key] = value
    return {**vars(root), ALL_VALUES: dict(values), **seeds}


def _write(folder: Path, name: str, target: str, text: str) -> None:
    # The copy of a template may be read-only.
    (folder / name).unlink()
    (folder / target).write_text(text, encoding="utf-8")


def _line(error: Exception) -> str:
    """Return the line of the template in which an error occurred, if it is known."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == "<template>"]
    return f", line {lines[-1]}" if lines else ""


def _within() -> str:
    if _limits is None:
        return ""
    limit = _limits.getrlimit(_limits.RLIMIT_AS)[0]
    return "" if limit == _limits.RLIM_INFINITY else f" within {limit / _GIB:.2g} GiB of memory"


def _limit_memory(limit: int) -> None:
    if _limits is None:
        return
    soft, hard = _limits.getrlimit(_limits.RLIMIT_AS)
    given = [number for number in (limit, soft, hard) if number != _limits.RLIM_INFINITY]
    # macOS takes no such limit.
    with suppress(ValueError):
        _limits.setrlimit(_limits.RLIMIT_AS, (min(given), hard))


def main() -> None:
    """Fill in a request in the current folder, and write the answer."""
    request, answer, limit = sys.argv[1:]
    _limit_memory(int(limit))
    given = json.loads(Path(request).read_text(encoding="utf-8"))
    # The last line of the output names the template if this process has to be ended.
    found = fill(given, Path(), lambda where: print(where, flush=True))
    Path(answer).write_text(json.dumps(found), encoding="utf-8")


if __name__ == "__main__":
    main()
