"""A run's identity is computed from what defines it, so that resume and reuse come free."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any


def run_identity(definition: Mapping[str, Any]) -> str:
    """Return the identity of a run: equal definitions have equal identities, others do not.

    Parameters
    ----------
    definition : mapping
        JSON-serialisable, as `Solver.definition` returns it. The order of keys does not count.

    Returns
    -------
    str
        32 hexadecimal digits.
    """
    canonical = json.dumps(definition, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()[:32]
