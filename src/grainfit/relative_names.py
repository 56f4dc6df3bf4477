"""Names of the cheaper relatives of tests, which problems and runs share."""

_SUFFIX = " (relative)"


def relative_name(test: str) -> str:
    """Return the name of the cheaper relative of a test, and of its runs.

    Examples
    --------
    >>> relative_name("heap")
    'heap (relative)'
    """
    return f"{test}{_SUFFIX}"


def is_relative(run: str) -> bool:
    """Return True if a run, or a test, is that of a relative; seeds may be numbered."""
    return _SUFFIX in run
