"""Messages of the interview."""

from grainfit.messages import Message

# Measurements.
NO_MEASUREMENT = Message(
    "{given!r} is no measurement.", "Type the repeats with their unit: {example}; {example}."
)
NO_UNIT = Message("{given} has no unit.", "Add it, as in {example}.")
NO_ERROR_HERE = Message("{given!r} has an uncertainty.", "Type the value alone.")
NO_ERROR = Message("{given!r} after ± is no uncertainty.", 'Type "0.5 deg" or "1 %".')

# The file.
NOT_BY_MACHINE = Message(
    "this cannot be changed here without changing more of the file.",
    "Change it in an editor; the interview goes on from there.",
)

# The material.
NO_MATERIAL = Message("is empty.", "Name it, or one that is like it: 'grainfit materials' lists.")
UNKNOWN_MATERIAL = Message("{given!r} is no starting material, and says no class.", "{instead}")
OF_CLASS = Message(
    "{given!r} is none of the starting materials: it begins with usual ranges of {title}. {near}"
)
OTHER_MATERIAL = Message(
    "the file has values or tests of another material, which would be lost.",
    "Begin another file for this one.",
)
NOT_BEGUN = Message("comes before all others.", "Say what material it is.")
NO_SIZES = Message(
    "{given!r} is neither a diameter nor sieve classes.",
    'Type "3 mm", "2 mm: 40 %; 3 mm: 60 %", or the name of a table: sieve.csv.',
)
NO_DENSITY = Message(
    "{given!r} is no density.", 'Type "950 kg/m^3", or an interval: "850 to 1050 kg/m^3".'
)
NO_ASPECT_RATIO = Message("{given!r} is no aspect ratio.", 'Type "1.5", or "1.2 to 1.8".')
NO_WALL_FRICTION = Message(
    "{given!r} is neither an angle nor a friction.",
    'Type "21 deg ± 1 deg", "0.35", or an interval of the friction: "0.3 to 0.5".',
)
ANGLE_OR_FRICTION = Message(
    "{given} would be a friction, and is more than {most:g}.",
    'Is it the angle? Type it with its unit: "{given} deg".',
)

# Choices.
NO_CHOICE = Message("{given!r} is none of the choices: {known}.")
TEST_IS_MEASURED = Message(
    "{name} has measured values.", "Remove its section in an editor if they are not to count."
)
NO_QUESTION = Message("there is no such question.")
NOT_TYPED = Message("{given!r} has signs that no file can hold.", "Type it again without them.")
NOTHING_AT_HAND = Message(
    "Say which material it is, and what is at hand:", "the tests that it can measure follow."
)
NOTHING_POSSIBLE = Message(
    "No test can be measured with what is at hand.",
    "A bucket and a scale are enough for the bulk density.",
)
NO_TESTS = Message(
    "no test can be measured with what is at hand.",
    "Add what you have or can borrow; a bucket and a scale are enough for the bulk density.",
)

# What is left to do.
NOT_MEASURED = Message(
    "{names} {verb} no measured value yet.", "Measure, or leave out in the choice of tests."
)
NOT_CHOSEN = Message("No test is chosen yet.")

# Remarks on a measurement.
REPEATS = Message("Mean {value} of {count} repeats, standard uncertainty {error}, within {width}.")
ONE_VALUE = Message("{value}, standard uncertainty {error}, met within {width}.")
REPEAT_IT = Message("One value says nothing of its scatter: three repeats or more do.")
ENLARGED = Message(
    "The apparatus holds too many of the real particles. Simulated ones are {factor:g} times as "
    "large (docs/coarse_graining.md)."
)
NO_SHEET = Message("no test is chosen.", "Choose those that you measure: the sheet is for them.")
