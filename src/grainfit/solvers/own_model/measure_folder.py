"""Evaluate a run folder with a custom function, as a separate program.

    python -P measure_folder.py FILE.py FUNCTION OUTPUT.json

It is started in the run folder and uses only the standard library, so that it starts fast.
"""

import importlib.util
import json
import sys
from pathlib import Path
from typing import Any


def _plain(found: Any) -> Any:
    """Convert NumPy numbers and arrays, `Response` and `Curve` to types that JSON supports."""
    if hasattr(found, "tolist"):
        return found.tolist()
    if hasattr(found, "value") and hasattr(found, "standard_error"):
        return {"value": found.value, "standard_error": found.standard_error}
    if hasattr(found, "coordinates") and hasattr(found, "values"):
        return {key: getattr(found, key) for key in ("coordinates", "values", "stays")}
    raise TypeError(f"a response cannot be of type {type(found).__name__}")


def main() -> None:
    """Call the function with the current folder, and write the responses that it returns."""
    file, function, output = sys.argv[1:]
    # Modules next to the file can be imported, as if the file itself were run.
    sys.path.insert(0, str(Path(file).parent))
    specification = importlib.util.spec_from_file_location("evaluation", file)
    if specification is None or specification.loader is None:
        raise ImportError(f"{file} is not a Python file")
    module = importlib.util.module_from_spec(specification)
    sys.modules["evaluation"] = module
    specification.loader.exec_module(module)
    found = getattr(module, function)(Path.cwd())
    Path(output).write_text(json.dumps(found, default=_plain), encoding="utf-8")


if __name__ == "__main__":
    main()
