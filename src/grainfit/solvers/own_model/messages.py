"""Texts of custom models for the user."""

from grainfit.messages import Message

# --- command and function ------------------------------------------------------------------------

NO_COMMAND = Message(
    "is {command!r}.", 'Give program and arguments as a list: ["lmp", "-in", "in.deck"].'
)
PROGRAM_OUTSIDE = Message(
    "{program!r} is outside the model's folder.",
    "Put the program into the folder, or give its whole path.",
)
RESPONSES_OUTSIDE = Message("{file!r} is outside the run's folder.", "Name a file.")
NO_TEMPLATE = Message("no file matches {pattern!r}.", "Name a file of the folder.")
UNMENTIONED = Message(
    "is mentioned nowhere in the model, which therefore cannot depend on it.",
    "Use {{{{ {name} }}}} in a template or in the command, or include {include} and use the "
    "variable {variable}, or read {json}.",
)
NO_PROGRAM = Message(
    "the program {program!r} is neither on the PATH nor in {folder}.",
    "Install it, or give its path.",
)
NOT_EXECUTABLE = Message("cannot be executed.", "Allow it: chmod +x {path}")
NO_FUNCTION = Message(
    "{function!r} cannot be called.", "Give a function of the parameters by name and a seed."
)
NOT_IN_IDENTITY = Message(
    "runs of {function} are reused whatever is in {left_out}, which cannot be read as data.",
    'Give another identity when it changes: PythonCallable(..., identity="model 2").',
)
NO_FREE_PARAMETER = Message(
    "name {named}, which is no free parameter of the file.", "Name some of: {free}."
)

# --- names of parameters -------------------------------------------------------------------------

RESERVED_NAME = Message("{root!r} is reserved.", "Give it another name.")
RESERVED_VARIABLE = Message(
    "is the solver variable {variable}, which is reserved.", "Give it another name."
)
SAME_VARIABLE = Message("is the same solver variable as {other}.", "Rename one of them.")
BEGINS_ANOTHER = Message("is the beginning of another name too.", "Rename it.")
UNDEFINED = Message("{name} is no parameter that the model is passed.", "{remedy}")
NOT_FILLED_IN = Message("cannot be filled in: {reason}.")

# --- folder --------------------------------------------------------------------------------------

NO_FOLDER = Message("does not exist.", "Give the folder of your model.")
ALL_FILES = Message("holds all files.", "Give the folder of your model.")
NOT_COPIED = Message("{problem}", "Put a copy of the files there instead.")
TOO_MANY_FILES = Message(
    "holds more than {most} files and folders, and is copied for every run.",
    "Is it the folder of your model? Leave only what a run reads.",
)
FILE_OUTSIDE = Message("is outside the folder.")
NOT_READ = Message("cannot be read: {error}.")
NOT_LISTED = Message(
    "cannot be read: {error}.",
    "Leave only what a run reads in the folder of your model, or allow it.",
)

RESPONSES_TWICE = Message(
    "is given together with evaluate.",
    "Keep the JSON file that your command writes, or the function that evaluates the run.",
)
FUNCTION_OUTSIDE = Message(
    "is {given}, which is outside the model's folder.", "Put the file into {folder}."
)

# --- runs ----------------------------------------------------------------------------------------

CHANGED_MODEL = Message(
    "the files in {folder} were changed while the calibration is running; start it again"
)
NOTHING_WRITTEN = Message("the command ended without writing {file}; it left {left}")
RESPONSES_UNREADABLE = Message("{file} cannot be read: {reason}")
CUT_SHORT = Message("{file} is not valid JSON (cut short?): {reason}")
NO_JSON = Message("{file} is not valid JSON: {reason}")
TWO_VALUES = Message("both {first} and {second} return the response {name}, with different values")
EVALUATION_TOO_LONG = Message(
    "simulation and evaluation took longer than the time-out of {timeout:g} s"
)
EVALUATION_FAILED = Message("{file}:{function} failed: {reason}")
FILLING_TOO_LONG = Message("filling in {where} took longer than {timeout:g} s and was ended")
