"""Messages of work folders: tables of runs, and what is kept of a calibration."""

from grainfit.messages import Message

# Tables of runs.
CURVE = Message(
    "is a curve, and a table of runs holds single numbers only.",
    "A work folder holds curves: give the one that the runs are in (--runs DIR, --runs-from DIR).",
)
CURVE_BESIDE_NUMBERS = Message(
    "is a curve, and a table of runs holds single numbers only.",
    "A work folder holds curves: give the one that the runs are in (--runs DIR, --runs-from DIR), "
    "or leave the curve out of the targets of test {test!r}.",
)
OTHER_MATERIAL = Message(
    "is {value:g}, and {fixed:g} in the calibration file: this is a run of another material.",
    "Leave it out, or calibrate with that value.",
)
NO_SEED = Message("is {text!r}.", "A seed is a whole number, 0 or above.")
