"""Messages of problems: refused parameters, targets, curves, correlations and tests."""

from grainfit.messages import Message

# Parameters.
NO_PARAMETER_NAME = Message("has no name.", "Give it one.")
NO_TANGENT = Message("is no tangent of an angle.", "Angles measure {known}.")
UNKNOWN_SCALE = Message("is {scale!r}.", 'Use "linear" or "log".')
NOT_FINITE = Message("is {given}, not a finite number.", "Give a finite number.")
BAD_SIZE = Message("is {given}.", "{remedy}")
BOUNDS_NOT_IN_ORDER = Message(
    "bounds are {order} (min {low:g}, max {high:g}).", "min must be below max."
)
BOUNDS_ALMOST_EQUAL = Message(
    "bounds are almost equal (min {low!r}, max {high!r}).",
    "Fix the parameter, or give a wider interval.",
)
NOT_POSITIVE_ON_LOG_SCALE = Message("is {low:g} on a log scale.", "It must be above 0 there.")
HALF_A_MEASUREMENT = Message("is missing.", "Give both, or neither.")
MEASURED_OUTSIDE = Message("is {given}.", "It must be in its interval, {low:g} to {high:g}.")
NOT_ABOVE_ZERO = Message("is {given}.", "It must be a number above 0.")
UNCERTAINTY_TOO_SMALL = Message(
    "is {given}, nothing beside its interval of {width:g}.", "Fix it, or check its unit."
)
UNCERTAINTY_TOO_LARGE = Message(
    "is {given}, too much beside its interval of {width:g}.", "Leave it out, or check its unit."
)

# Targets.
NO_TARGET_NAME = Message("has no name.", "Give it the name of its response.")
NO_STATISTIC = Message("is {given}.", "Possible here: {known}.")
NO_NUMBER = Message("is {given}.", "It must be a number.")
NO_DEFAULT_TOLERANCE = Message(
    "is missing: 2 % of the value, the default, is nothing where the value is 0.",
    "Give a tolerance or an uncertainty in the unit of the response.",
)
FEW_MEASUREMENTS = Message(
    "are fewer than two.", "Give at least two; a single one is a value with its uncertainty."
)
EQUAL_MEASUREMENTS = Message(
    "are all {value:g}, so that nothing is known of their scatter.",
    "Give systematic, the standard uncertainty of the instrument, beside them; or give value and "
    "uncertainty instead.",
)
FEW_CURVES = Message(
    "are fewer than two curves.",
    "Give at least two; a single one is a curve with its uncertainty.",
)
EQUAL_CURVES = Message(
    "are all the same, so that nothing is known of their scatter.",
    "Give the curves of different tests, or a single one with its uncertainty.",
)
NO_COMMON_RANGE = Message(
    "share fewer than two points of the first one: all of them span {span} only.",
    "Give curves over the same coordinates.",
)
NO_OVERLAP = Message(
    "do not overlap: curve {high} is over {high_range}, and curve {low} over {low_range}.",
    "Give curves over the same coordinates, and check their units.",
)
NO_PAIR = Message(
    "have one that is no curve.",
    "Give pairs of coordinates, increasing, and as many values, all finite.",
)
SHARE_OF_ZERO = Message(
    "is {given}.",
    "Give it in the unit of the response: the value is 0, and so is any percentage of it.",
)
BAD_WEIGHT = Message("is {given:g}.", "Give {least:g} to {most:g}; 1 is usual.")
TOO_EXACT = Message(
    "is {width:g}, and the {other} is {size:g}.",
    "Give at least {least:g} times as much; no measurement is as exact.",
)

# Measured curves.
NOT_ALL_FINITE = Message("are not all finite numbers.", "Give a list of finite numbers.")
BAD_POINT = Message("has {given} at position {position}.", "{remedy}")
UNEQUAL_NUMBERS = Message(
    "has {count} coordinates and {values} values.", "Give one value for each coordinate."
)
BAD_NUMBER_OF_POINTS = Message(
    "has {count} points.", "Give 2 to {most}; average neighbours of a longer curve."
)
NOT_INCREASING = Message("do not increase.", "Sort the points, and keep one for each coordinate.")
NO_UNCERTAINTY = Message(
    "is missing.", 'Give the standard uncertainty of the values, such as "2 %", or a covariance.'
)
NO_PERCENTAGE = Message(
    "is {given!r}.", 'Give a number in the unit of the values, or a percentage such as "2 %".'
)
NOT_ABOVE_ZERO_EVERYWHERE = Message(
    "is not above 0 everywhere.",
    'Give a number above 0, or a percentage such as "2 %" where no value is 0.',
)
DOES_NOT_FIT_POINTS = Message(
    "does not fit the points.", "Give one number for all points, or one of at least 0 for each."
)
COVARIANCE_AND_UNCERTAINTIES = Message(
    "is given beside uncertainties.", "The covariance replaces them: remove the uncertainties."
)
BAD_LARGEST = Message("is {largest:g} at most.", "{remedy}")
CURVE_TOO_EXACT = Message(
    "is {largest:g} at most, and the largest value {size:g}.",
    "Give at least {least:g} times as much; no measurement is as exact.",
)
NOT_POSITIVE_DEFINITE = Message(
    "is not positive definite.",
    "Errors that differ from point to point must not be tiny beside those in common.",
)

# Correlations.
NO_TARGET_HERE = Message("{name!r} has no target here.", "Use two of {known}.")
NAMED_TWICE = Message("names {name!r} twice.", "Name two responses.")
SECOND_COEFFICIENT = Message(
    "is a second coefficient of {first!r} and {second!r}.", "Keep one of them."
)
BAD_COEFFICIENT = Message(
    "gives {first!r} and {second!r} the coefficient {given}.", "It must be above -1 and below 1."
)
CONTRADICTION = Message(
    "contradict each other: their matrix has the eigenvalue {smallest:.2g}, and all must be "
    "above 0.",
    "Quantities that both go with a third one go together as well: correct a coefficient.",
)
BAD_SHAPE = Message("has the shape {shape}.", "Give {wanted}: a row for each {row}.")
NOT_FINITE_ENTRY = Message("is {given} for {first!r} and {second!r}.", "Give finite numbers.")
NOT_SYMMETRIC = Message("is not symmetric.", "Row i, column j is that of j, i.")
BAD_VARIANCE = Message("has a variance that is not above 0.")
NO_TRIPLES = Message("are {given}.", 'Give triples: [("first", "second", 0.8)].')

# Tests and problems.
NO_TEST_NAME = Message("has the name {given!r}.", "Give it a text as its name.")
NO_LIST_OF_NAMES = Message("are {given!r}.", "Give a list of names.")
NOT_A_PARAMETER = Message(
    "name {name!r}, which is not a parameter of the problem.", "There are: {known}."
)
NOT_CHEAPER = Message(
    "is {given}.", "Give the computing time of its run in runs of the test: above 0, below 1."
)
RELATIVE_OF_NO_TEST = Message(
    "name {of!r}, which is no test of the problem.", "There are: {known}."
)
GIVEN_TWICE = Message("is given as a {kind} more than once.", "Keep one of them.")
EMPTY = Message("are empty.", "Give at least one {kind}.")
NO_RAYLEIGH = Message("is {given}.", "Give a RayleighTimeStep, or None.")
BAD_RAYLEIGH_WEIGHT = Message("is {given}.", "It must be 0 or above, and at most {most:g}.")
NOT_A_TARGET = Message("is no target.", "There are: {known}.")
