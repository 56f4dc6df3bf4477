"""Messages to users about the particles and definition of a bulk test."""

from grainfit.messages import Message

NO_SIZES = Message(
    "is {sizes!r}.",
    'Give diameter="10 mm", or a ParticleSizes.',
)
DAMAGED_DEFINITION = Message(
    "does not define a {type} test: {reason}.",
    "It was edited, or written by another version of grainfit.",
)
GIVEN = Message("Apparatus of {test}, given: {values}.")
ASSUMED = Message("Apparatus of {test}, assumed: {values}.")
SMALLER = Message("{test}, smaller in the search")
NEVER_DESCRIBED = Message(
    "The apparatus of {test} is not described, so all of it is assumed: {values}.",
    "Describe that of the laboratory in [[test]], so that the same test is simulated.",
)
REST_NOT_DESCRIBED = Message(
    "Nothing else of the apparatus of {test} is described, so the rest is assumed: {values}.",
    "Describe that of the laboratory in [[test]], so that the same test is simulated.",
)
OF_INSTRUMENT = Message("Apparatus of {test}, as of {instrument}: {values}.")
NO_INSTRUMENT = Message("is {name!r}, which is no instrument that grainfit knows.", "{nearest}")
OTHER_TYPE = Message(
    "is {name!r}, which does another test.", 'Give type = "{type}", or the dimensions by hand.'
)
NO_SIZE_OF_ITS_OWN = Message(
    "a test of type {type} has no apparatus whose size can be changed.",
    "Leave it out.",
)
NO_DIAMETER = Message("is missing.", 'Give diameter="10 mm", or a ParticleSizes.')
DIAMETER_BESIDE_SIZES = Message(
    "is given beside sizes.", 'Give diameter="10 mm", or a ParticleSizes.'
)
LENGTH_IS_SHORT = Message(
    "{value:g} m is less than {fewest:g} of the largest particles ({largest:g} m).",
    "Use at least {least:g} m.",
)
TOO_LOW = Message("is {value}.", "Nothing is below {least}. {why}")
TOO_HIGH = Message("is {value}.", "Nothing is above {most}. {why}")
FALLS = Message("is {last}, and the curve begins with {first}.", "It rises. {why}")
