"""Run Parsl's interchange between a calibration and its jobs, as long as the calibration lives.

It is run as a separate file, so that nothing of grainfit has to be imported.
"""

import ctypes
import os
import runpy
import signal

_PR_SET_PDEATHSIG = 1


def main() -> None:
    """Become the interchange."""
    # Ctrl-C in the terminal is for the calibration, which needs the interchange to end its jobs.
    os.setsid()  # type: ignore[attr-defined, unused-ignore]
    # Without it a calibration that is killed would leave its jobs waiting until their walltime.
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    runpy.run_module("parsl.executors.high_throughput.interchange", run_name="__main__")


if __name__ == "__main__":
    main()
