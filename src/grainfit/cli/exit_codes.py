"""Exit codes of the command line, see docs/command_line.md."""

BAD_INPUT = 1
INTERRUPTED = 130
#: Of `grainfit run`, by status of the result.
OF_STATUS = {
    "calibrated": 0,
    "predicted": 3,
    "undecided": 3,
    "out_of_tolerance": 3,
    "unreachable": 3,
    "interrupted": INTERRUPTED,
}
