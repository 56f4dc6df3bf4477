"""Messages of tables of runs: recorded ones, and those that are imported."""

from grainfit.messages import Message

COLUMNS_NOT_LISTED = Message("are {columns!r}.", "List the names of the columns.")
NO_RESPONSES = Message(
    "are missing: any column of the table could be a response.",
    "Name those that are as targets.",
)
NO_RUNS = Message("holds no runs.", "Give one line for each run.")
NEGATIVE_ERROR = Message("is {value:g}; a standard error is not negative.")
OLD_ERROR_NAME = Message(
    "is the name of the standard error of {response} in version 0.1.0.",
    "Name it {response}{suffix}.",
)
REPEATED_RUN = Message(
    "has the same parameters and seed as {first}.",
    "Keep one of them, or give them the seeds they were run with.",
)
NO_PARAMETER = Message("is not a parameter of the table.", "It has: {there}.")
NO_VALUE = Message("has no value, and the table has a column of that name.", "Give a value.")
NO_RUN_THERE = Message("no run is recorded there; the nearest is at {there}")
