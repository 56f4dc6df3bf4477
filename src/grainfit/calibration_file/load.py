"""Read a calibration file: report all its faults at once, and execute nothing."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path
from typing import Any

from grainfit.calibration_file.content import CalibrationFile, SearchOptions
from grainfit.calibration_file.layout import (
    chosen_models,
    material_values,
    read_document,
    simulated_sizes,
)
from grainfit.calibration_file.line_numbers import key_lines
from grainfit.calibration_file.parameters import MeasuredAngle
from grainfit.calibration_file.same_simulation import join_evaluations
from grainfit.calibration_file.toml_faults import NOT_TOML, toml_fault
from grainfit.errors import InputError
from grainfit.files import LARGEST_CALIBRATION_FILE, TooLargeError, line_of, read_within
from grainfit.options.places import FileFault, Findings, Place
from grainfit.problem import Parameter

# Python's TOML reader takes hours for a key of very many parts; three are all there are here.
_DEEP_KEY = re.compile(
    r"""(?<![\w"'-])(?:(?:[\w-]++|"(?:\\.|[^"\\\n])*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){33}"""
)


def load_calibration_file(
    path: str | os.PathLike[str],
    *,
    planned: bool = False,
    work_folder: Path | None = None,
    text: str | None = None,
) -> CalibrationFile:
    """Read a calibration file.

    Parameters
    ----------
    path : path-like
        The TOML file.
    planned : bool
        Read a file from before the laboratory, in which measured values may be missing.
    work_folder : Path, optional
        Where what is measured on photographs is kept; the default work folder of the file if not
        given.
    text : str, optional
        Content to read in place of that of the file, which need not exist: for edits that are not
        saved yet.

    Returns
    -------
    CalibrationFile
        Its content, in SI units and degrees.

    Raises
    ------
    InputError
        With every fault of the file: key, line, offending value, and remedy.
    """
    path = Path(path)
    text = read_text(path) if text is None else text
    document = parse_text(text, path)

    def kept_in() -> Path:
        # Imported here: most files name no photographs.
        from grainfit.campaign.work_folder import default_workdir

        return work_folder or default_workdir(path)

    findings = Findings(path.parent.absolute(), key_lines(text), work_folder=kept_in)
    values = read_document(document, Place(findings), planned=planned)
    if findings.faults:
        findings.faults.sort(key=lambda fault: fault.line or 0)
        raise InputError(findings.faults, str(path))
    return _calibration_file(values, path, findings)


def read_text(path: Path) -> str:
    """Return the text of a calibration file.

    Raises
    ------
    InputError
        It is no readable text, or too large.
    """
    try:
        if path.is_dir():
            raise _fault(path, "is a folder.", "Name the calibration file in it.")
        if not path.is_file():
            raise _fault(path, "there is no such file.", '"grainfit new" writes a first one.')
        data = read_within(path, LARGEST_CALIBRATION_FILE, waiting=True)
    except TooLargeError:
        raise _fault(path, "is larger than 1 MB.", "Is it a calibration file?") from None
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise _fault(path, f"cannot be read: {reason}.", "") from None
    try:
        # Some editors put a byte order mark first, which TOML does not know.
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _fault(path, "is not UTF-8 text.", "Save it as UTF-8.", line_of(error)) from None


def parse_text(text: str, path: Path) -> dict[str, Any]:
    """Return the tables of a calibration file.

    Raises
    ------
    InputError
        It is not TOML.
    """
    deep = _DEEP_KEY.search(text)
    if deep is not None:
        start = text.count("\n", 0, deep.start()) + 1
        raise _fault(path, "has a key of too many parts.", NOT_TOML, start)
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise _fault(path, "has brackets nested too deeply.", NOT_TOML) from None
    except ValueError as error:
        message, remedy, line = toml_fault(text, error)
        raise _fault(path, message, remedy, line) from None


def _fault(path: Path, message: str, remedy: str, line: int | None = None) -> InputError:
    return InputError(FileFault("", message, remedy, line), str(path))


def _calibration_file(values: dict[str, Any], path: Path, findings: Findings) -> CalibrationFile:
    material = material_values(values)
    angles = tuple(v for v in material.values() if isinstance(v, MeasuredAngle))
    material |= {angle.name: angle.value for angle in angles}
    everything = material | values.get("parameters", {})
    return CalibrationFile(
        name=values["name"],
        path=path,
        sizes=simulated_sizes(values),
        fixed={n: v for n, v in everything.items() if not isinstance(v, Parameter)},
        parameters=tuple(v for v in everything.values() if isinstance(v, Parameter)),
        tests=join_evaluations(values["test"]),
        strategy=values.get("strategy", SearchOptions()),
        cluster=values.get("cluster"),
        contact_models=chosen_models(values),
        measured_angles={angle.name: str(angle) for angle in angles},
        holdouts=tuple(values.get("holdout", ())),
        tables=tuple(findings.tables),
        photographs=tuple(findings.photographs),
    )
