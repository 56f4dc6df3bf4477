"""Entry point of the command line: ``grainfit`` and ``python -m grainfit``."""

import sys

_INTERRUPTED = 130


def main() -> None:
    """Run the command line."""
    try:
        from grainfit.cli.app import main as command_line
    except KeyboardInterrupt:
        sys.exit(_INTERRUPTED)
    command_line()


if __name__ == "__main__":
    # Python looks for modules in the current folder first, where a model's numpy.py may be.
    if not sys.flags.safe_path:
        del sys.path[0]
    main()
