"""Messages of the report and of the page of a watch: the verdict, or the progress."""

from grainfit.messages import Message

RUNNING = Message("Running: no answer yet.")
STOPPED = Message("Stopped by an error.")
INTERRUPTED = Message("Interrupted. The numbers are the best so far.")
INTERRUPTED_EARLY = Message("Interrupted. No answer yet.")
NO_ANSWER = Message("It has ended ({state}), but there is no answer to be read.")
CALIBRATED = Message("Calibrated: every measurement is met within its tolerance.")
PREDICTED = Message("Predicted, full size pending: no run of the real apparatus was made.")
UNREACHABLE = Message("Out of reach within the given intervals.")
UNDECIDED = Message("Undecided: the runs do not tell whether {what} {verb} met.")
NOT_TOGETHER = Message("Not calibrated: the measurements are not met together.")
NOT_CALIBRATED = Message("Not calibrated: {missed}.")

SIMULATED = Message("Simulated so far: {runs}.")
SIMULATED_AND_RUNNING = Message("Simulated so far: {runs}; under way: {running}.")
CONTINUE = Message("Simulated so far: {runs}.", "Start the same command again to continue.")
RESULT_MISSING = Message(
    "Its result.json is missing.", "Start the same command again: it is written again."
)
DETERMINATIONS = Message("Of {parameters}: {parts}.")
BIASED = Message("Biased is the {parameter}: {bias}.")
DOUBTFUL = Message("{response} is within {accepted} with a probability of {probability}")
MISSED = Message("{response} deviates by {deviation}, and {accepted} are accepted")

# The page of a watch.
STARTING = Message("Starting: no run has been asked for yet.")
NOTHING_THERE = Message("Nothing has been calibrated here yet.")
UNREADABLE = Message("The work folder cannot be read.")
LAST_RUN_ENDED = Message("The last run has ended.")
WRITING_RESULT = Message("Its result is computed and written: this takes some seconds.")
HOLDOUTS_UNDER_WAY = Message("Calibrated. Tests that were not fitted are being simulated.")
VERDICT_STAYS = Message(
    "Whether they are predicted is said when their runs have ended. The verdict on the fitted "
    "tests stays, also if they are stopped."
)
FIRST_RUNS = Message("Running.")
TOO_FEW_RUNS = Message("A first verdict follows when there are enough runs for metamodels.")
SO_FAR = Message("Running. So far, every target is met with a probability of {probability}.")
ABOUT_SO_FAR = Message(
    "The probability, by the runs so far, that every expected response is within its tolerance. "
    "There is no verdict before fresh seeds at the answer agree."
)
MISSED_SO_FAR = Message("Missed so far: {targets}.")
