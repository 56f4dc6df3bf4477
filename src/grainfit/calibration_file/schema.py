"""The JSON Schema of the calibration file, with which editors complete and check it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from grainfit.calibration_file.layout import LAYOUT


def calibration_file_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of the calibration file.

    It covers keys, kinds of values and limits. Units, and rules that span several keys, are
    checked by `grainfit.calibration_file.load_calibration_file` only.
    """
    schema = LAYOUT.schema()
    # The reader has its own message for a missing test.
    schema["required"] = [*schema["required"], "test"]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "grainfit calibration file",
        "description": "Calibrates the parameters of a DEM model from bulk tests.",
        **schema,
    }


def schema_path() -> Path:
    """Return the path of the JSON Schema that is installed with the package."""
    return Path(__file__).with_name("calibration.schema.json")


def write_schema() -> None:
    """Write the JSON Schema into the package, for developers after a change of the layout."""
    text = json.dumps(calibration_file_schema(), indent=1, ensure_ascii=False)
    schema_path().write_text(text + "\n", encoding="utf-8")
