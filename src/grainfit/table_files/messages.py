"""Messages of the reader of tables: faults of files, headings, rows and cells."""

from grainfit.messages import Message

CANNOT_BE_READ = Message("cannot be read: {reason}.", "Give the path of a table as text.")
NO_REGULAR_FILE = Message("is no regular file.", "Give the path of a table as text.")
EMPTY = Message("is empty.", "Give {content}.")
OTHER_ENCODING = Message("is not {encoding} text.", "Save the table as CSV in UTF-8.")
NOT_CSV = Message("is not CSV: {reason}.", "Save the table as CSV in UTF-8.")

NO_HEADINGS = Message("has no names of columns.", "Name the columns in the first line.")
ONE_COLUMN = Message(
    "has one column, {name}.", "Separate columns by commas, semicolons, tabs or blanks."
)
MISSING = Message("is missing.", "{remedy}")
REPEATED = Message("is there more than once.", "Keep one of them.")
RESEMBLES = Message(
    "is ignored, and {meant} is not there.", 'Did you mean "{meant}"? Name it so, or otherwise.'
)
STATES_OTHER_UNIT = Message(
    "states {stated}, and its numbers are taken {taken}.", "{correct} the heading."
)
NO_UNIT = Message("has no unit.", 'State the unit behind the name: "{name} [{unit}]".')
WRONG_UNIT = Message("has the unit {stated}.", 'State the unit behind the name: "{name} [{unit}]".')
SAID_TO_BE_WITHOUT_UNIT = Message(
    "is said to have no unit, and is in {unit}.", "Name the unit that it is in."
)
UNIT_OF_MODEL_UNKNOWN = Message(
    "is in {stated!r}, and nothing says which unit your model takes.",
    'Name the unit in the calibration file, such as unit = "J/m^3".',
)

TOO_LONG = Message(
    "is in a row of {count} cells, and the header has {width}.",
    "Use decimal points, and one separator between cells; or separate cells by semicolons.",
)
TOO_SHORT = Message(
    "has no cell: the row has {count}, and the header {width}.",
    "Complete the row, or leave it out.",
)
NO_VALUE = Message("has no value.", "Complete the row, or leave it out.")
NOT_A_NUMBER = Message("is {shown}, not a number.", "{remedy}")
UNIT_BELOW_HEADING = Message(
    "is {unit}, a unit, and not all cells of this row are units.",
    'Write the unit into the heading, "{name} [{unit}]", and leave this row out.',
)
USE_A_POINT = Message("Use a decimal point.")
USE_A_COMMA = Message("Use a decimal comma, as in the other rows, and no separator of thousands.")
THOUSANDS_OR_DECIMAL = Message(
    "is {shown}: {whole} or {decimal}?",
    "Write {whole} or {decimal}, without a separator of thousands.",
)
OTHER_DECIMAL_MARK = Message(
    'is {shown}, where other numbers of the table have the decimal "{mark}".',
    'Write all numbers with the decimal "{mark}".',
)
NOT_FINITE = Message("is {number}.", "Leave the row out.")
MORE_FAULTS = Message("has {count} more faults.")

# Points of a curve, and their covariance.
BOTH_X_AND_Y = Message("is both x and y.", 'Name two: x = "...", y = "...".')
NO_VALUES = Message(
    "has {why} and no values, by its name.", 'Name the column of the values: y = "...".'
)
NUMBER_OF_POINTS = Message(
    "ends a table of {count} points.", "Give 2 to {most}; average neighbours of a longer curve."
)
SAME_COORDINATE = Message(
    "is the same as in line {first}, {value:g}.",
    "Give one point for each {label}, such as the mean of several.",
)
NO_COUNT = Message("is {count:g}.", "A deviation needs a whole number of measurements, 2 or more.")
ROWS_OF_COVARIANCE = Message(
    "ends a table of {rows} rows, and the curve has {count} points.",
    "Give {count} rows of {count} numbers, one for each point of the curve.",
)
CELLS_OF_COVARIANCE = Message(
    "ends a row of {cells} numbers, and the curve has {count} points.",
    "Give {count} rows of {count} numbers, one for each point of the curve.",
)
