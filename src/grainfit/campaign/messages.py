"""Messages of campaigns: work folders, stores, workers and clusters."""

from grainfit.messages import Message

# Runs.
NO_MORE_RUNS = Message(
    "the executor takes no more runs: {reason}.",
    "Finished runs are kept; start again to continue.",
)
CANNOT_BE_SENT = Message(
    "a run cannot be sent to another process: {reason}.",
    "Give a function that is defined at the top of a module, or use threads.",
)
WORKER_LOST = Message("the worker was lost: {kind}: {reason}")
FOLDER_REMOVED = Message("the folder of the run was removed while it ran")
FOLDER_NOT_KEPT = Message("the run's folder could not be kept: {reason}")
UNEXPECTED = Message("unexpected {kind}: {reason}")
NOT_FINITE = Message("response {name} is {value}")
NAME_OF_FURTHER_RUNS = Message(
    "is a name that further runs of a test have.", "Give the test another name."
)
NUMBER_AND_CURVE = Message(
    "is a number in some runs and a curve in others.", "Let every run yield the same."
)
NOTHING_IN_COMMON = Message(
    "of the runs have no coordinates in common.", "Let every run cover the same range."
)

NEAR_RUNS = Message(
    "{runs} of {problems} guide the search, and no verdict rests on them: {differs}."
)
NO_RUN_USED = Message("No run of {source} is used: {why}.")
NO_FINISHED_RUN = Message("it has no finished run")
OTHER_TESTS = Message("its runs are of {theirs}, and those of this calibration of {ours}")
OTHER_MODEL = Message("its runs of {test} differ in {what} from those of this calibration")
OTHER_FIXED_VALUE = Message("{name} is {here} in this calibration, and {there} in its runs")
PARAMETER_NOT_THERE = Message("its runs have no {name}")
PARAMETER_NOT_HERE = Message("its runs have {name}, which this calibration does not have")
BEYOND_INTERVALS = Message(
    "they are too far outside of the interval of {name}, which is {here}: they have {there}"
)
WITHOUT_RESPONSES = Message("its runs have no {names}")

# Work folder.
FOLDER_UNUSABLE = Message("the work folder {folder!r} cannot be used: {reason}.", "{remedy}")
ANOTHER_FOLDER = Message("Choose another (workdir).")
MAKE_WRITABLE = Message("Make it writable: this command changes the folder itself.")
NOT_A_FILE = Message("{path!r} is a pipe, a socket or a device, not a file.", "Remove it.")
FOLDER_IN_USE = Message("the work folder {folder!r} is in use by process {process}.", "{remedy}")
WAIT_OR_ANOTHER = Message("Wait for it to end, or choose another folder (workdir).")
WAIT = Message("Wait for it to end.")
NOT_LOCKED = Message("the work folder {folder!r} cannot be locked: {reason}.", "{remedy}.")
NO_LOCKS = Message(
    "the work folder {folder!r} cannot be locked: {reason}. Its file system has no locks; without "
    "them two starts would disturb each other, and the run store cannot be written.",
    "{remedy}, or ask the administrator for locks (NFS: its lock service, Lustre: the mount option "
    "flock).",
)
_NO_WORK_FOLDER = "{folder!r} is not a work folder of grainfit: it has no {store}."
_NAME_THE_FOLDER = "Name the folder that 'grainfit run' wrote"
NO_WORK_FOLDER = Message(_NO_WORK_FOLDER, f"{_NAME_THE_FOLDER}.")
NO_SOURCE = Message(_NO_WORK_FOLDER, f"{_NAME_THE_FOLDER}, or the address of a store.")
FOLDERS_ONLY = Message(
    "this is about a work folder, and cannot be had from the address of a store.",
    f"{_NAME_THE_FOLDER}.",
)

# Store.
NO_DRIVER = Message(
    "the run store {store} needs the Python package psycopg, which is not installed.", "{install}"
)
STORE_UNUSABLE = Message("the run store {store} cannot be used: {reason}.", "{remedy}")
NO_REPLY = Message("no answer from the server within {seconds:g} s")
CHECK_SERVER = Message(
    "Check that the database server runs, can be reached, and accepts this user."
)
CHECK_ADDRESS = Message("Check its address.")
CHECK_OPTIONS = Message("Check the options in its address.")
CREATE_DATABASE = Message("Create it, such as with: createdb {name}")
GRANT = Message(
    "Have its owner give this user the right, in SQL: GRANT CREATE ON SCHEMA public TO name; with "
    "tables of grainfit in it, GRANT SELECT, INSERT, UPDATE, DELETE ON about, runs, calibrations, "
    "requests TO name."
)
WRITES_NOTHING = Message(
    "The server only reads, as a standby does: give the address of the one that also writes."
)
SERVER_FULL = Message("The disk of the server is full: make room there and start again.")
UTF8_DATABASE = Message(
    "Use a database that has all characters: createdb --encoding=UTF8 --template=template0 NAME"
)
OWN_DATABASE = Message(
    "It is damaged, or of another program: use a database for grainfit alone, or another file."
)
MAKE_ROOM = Message("The disk is full: make room and start again.")
USED_OR_NO_LOCKS = Message(
    "Another process uses it (wait for its end), or its file system has no locks."
)
CORRECT_THAT = Message("{cause}.", "Correct that and start again.")
CHECK_FILES = Message(
    "Check that its folder, and the files beside it ending in -wal and -shm, can be written."
)
FOLDER_MISSING = Message("The folder {folder!r} is missing")
NOT_WRITABLE = Message("{file!r} cannot be written: {reason}")
NOTHING_WRITABLE = Message("Nothing can be written to {folder!r}: {reason}")
STORE_DAMAGED = Message("the run store {store} is damaged: {reason}.", "{remedy}")
STORE_IS_FOLDER = Message("the run store {store} is a folder, not a file.", "{remedy}")
NO_STORE_FILE = Message("there is no run store {store}.", "Correct its path.")
STORE_EMPTY = Message("the run store {store} is empty: nothing was run yet.")
STORE_TOO_NEW = Message(
    "the run store {store} has schema version {version}, this grainfit reads version {own}.",
    "Use the grainfit version that wrote it, or another work folder.",
)
STORE_TOO_OLD = Message(
    "the run store {store} has the older schema version {version}.",
    "Start 'grainfit run' in its work folder once: that brings it up to date.",
)
STORE_REMOVED = Message(
    "the run store {store}, or the {name}-wal beside it, was removed or replaced while it was in "
    "use.",
    "Start again: that continues with the runs whose folders still exist.",
)
STORE_AWAY = Message(
    "{reason} It was tried again for {seconds:g} s.",
    "Finished runs are kept; start again to continue.",
)
STORE_BACK = Message("The store {store} is back after {seconds:.0f} s.")
NO_ADDRESS = Message("{address!r} is not the address of a run store.", "{remedy}")
_SUCH_AS = (
    "Give one such as postgresql+psycopg://user@host/database or sqlite:////path/to/runs.sqlite"
)
GIVE_AN_ADDRESS = Message(f"{_SUCH_AS}.")
OTHER_BEGINNING = Message("It must begin with {right}://, not with {given}://.", f"{_SUCH_AS}.")
OTHER_SYSTEM = Message("Only PostgreSQL and SQLite can have one.", f"{_SUCH_AS}.")
PARTS_OF_ADDRESS = Message(
    f"{_SUCH_AS}; a port is a number, an IPv6 host stands in [ ], and special characters of a "
    "password are written as %XX."
)
NO_SQLITE_PATH = Message("The path of a file follows sqlite:///.", f"{_SUCH_AS}.")
NO_SQLITE_OPTIONS = Message(
    "SQLite has no options here, and no path with a question mark.", f"{_SUCH_AS}."
)

# Cluster.
NO_SCHEDULER = Message("{command} is not found: the runs are executed on this machine.")
PATH_FOR_SCRIPTS = Message(
    "the work folder {folder!r} cannot be used on a cluster: scripts of jobs cannot have such a "
    "path.",
    "Choose one of letters (a to z), digits and _ . - (workdir).",
)
RUNS_HERE = Message("scheduler is local: the runs are executed on this machine.")
NO_PARSL = Message("runs on a cluster need Parsl, which is not installed.", "{install}")
NO_CONFIG = Message("{reference} is of the type {kind}, not a parsl.Config.")
INTERCHANGE_ENDED = Message(
    "Parsl's interchange, which connects to the jobs of the cluster, was ended. Its log is in "
    "{folder}.",
    "Start again to continue.",
)
NO_JOB_STARTS = Message(
    "no job of the cluster starts: {reason}. Scripts and output of the jobs are in {folder}."
)
NO_LIST = Message("{scheduler} does not list its jobs: {reason}")
NO_COMMAND = Message("{command} is not found, which lists the jobs")

# Options of a cluster.
_PARSL_CONFIG = 'Write the file and the name of the parsl.Config in it: "my_parsl.py:config".'
NO_PARSL_CONFIG = Message("is {given}.", _PARSL_CONFIG)
BAD_PARSL_CONFIG = Message("is {given}: {reason}", _PARSL_CONFIG)
NOT_KNOWN = Message("is {given!r}.", "There is: {known}.")
BELOW_ONE = Message("is {given}.", "It must be at least 1.")
BESIDE_PARSL = Message("has no effect beside parsl.", "Set it in your Parsl configuration instead.")
NO_NAME = Message("{given!r} cannot be a name.", "Use letters (a to z), digits and _ . , : @ + -")
NO_WALLTIME = Message("is missing.", 'Set how long a job may last: walltime = "2 h".')
WALLTIME = Message("is {given}.", "It must be from 1 minute to 1 year.")
NOT_ONE_LINE = Message("{given!r} is not one line.", "Write a list, line by line.")
NO_DIRECTIVE = Message(
    "{given!r} is no directive of the scheduler.", "Write it like {example!r}, or set scheduler."
)
OF_SLURM = Message(
    "works with Slurm alone.",
    'Remove it, or write a Parsl configuration: parsl = "my_parsl.py:config".',
)
ONE_RUN = Message(
    "is {given}.", "With nodes_per_run = {nodes} a job has one run: set jobs instead."
)
IDLE_NODES = Message("is {given}, fewer than the {nodes} nodes of a run.", "Lower nodes_per_run.")
OF_GRID_ENGINE = Message("is of Grid Engine alone.", 'Remove it, or set scheduler = "sge".')
HAS_A_KEY = Message("{given!r} has a key of its own.", "Use {key}.")
DECIDED = Message("{given!r} is for grainfit to decide.", "Remove it.")
