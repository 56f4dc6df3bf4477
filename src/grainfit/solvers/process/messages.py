"""Messages of runs that failed as processes: what happened, and what to blame."""

from grainfit.messages import Message

STOPPED = Message("stopped by the user")
TOO_LONG = Message("took longer than its time-out of {timeout:g} s and was ended")

# The program.
NOT_STARTED = Message("cannot start {program!r}: {reason}")
STARTED_NOTHING = Message("{program} could not start a program: {reason}")
EXIT_CODE = Message("exit code {code}")
ENDED = Message("{program} ended with {reason}")
KILLED = Message("{program} was killed by {signal}")
PROCESS_KILLED = Message("{program} ended because one of its processes was killed by {signal}")
PROCESS_LOST = Message("{program} lost one of its processes: {line}")
SIGNAL = Message("signal {number}")
OUT_OF_MEMORY = Message("{signal}, most often for lack of memory")

# The machine, as the log of a program says.
DISK_IN_LOG = Message(
    "the disk of the run's folder, or another one it writes to, was full: {reason}"
)
NO_MEMORY = Message("not enough memory: {reason}")
NO_LICENCE = Message("no licence for the program: {reason}")
NO_PROGRAM = Message("a program could not be started: {reason}")

# The folder of the run.
DISK_FULL = Message("the disk of the run's folder is full")
QUOTA_USED_UP = Message("the disk quota for the run's folder is used up")
FOLDER_REMOVED = Message("its folder was removed while it ran")
FOLDER_UNUSABLE = Message("its folder cannot be used: {reason}")
FOLDER_READ_ONLY = Message("its folder cannot be written: {reason}")
