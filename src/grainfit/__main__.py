"""Entry point of the command line: ``grainfit`` and ``python -m grainfit``."""

import gc
import sys

_INTERRUPTED = 130
#: Objects after which Python looks for cycles. Its default of 700 does so a hundred times while
#: modules are imported, and finds nothing; a report leaves 300,000.
_OBJECTS_PER_COLLECTION = 500_000


def main() -> None:
    """Run the command line."""
    gc.set_threshold(_OBJECTS_PER_COLLECTION)
    try:
        from grainfit.cli.main import main as command_line
    except KeyboardInterrupt:
        sys.exit(_INTERRUPTED)
    command_line()


if __name__ == "__main__":
    # Python looks for modules in the current folder first, where a model's numpy.py may be.
    if not sys.flags.safe_path:
        del sys.path[0]
    main()
