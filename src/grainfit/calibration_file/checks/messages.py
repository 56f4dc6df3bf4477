"""Messages to users about values of a calibration file."""

from grainfit.messages import Message

UNUSUAL_DENSITY = Message(
    "{name} = {value:g} kg/m^3 is that of no solid.",
    'Write it with its unit, such as "{value:g} {unit}".',
)
UNUSUAL_DIAMETER = Message(
    "particle.diameter = {value:g} m is that of no particle in a laboratory.",
    'Write it with its unit, such as "10 mm".',
)
UNUSUAL_GRAVITY = Message(
    "Test {test}: gravity = {value:g} m/s^2 is that of no laboratory.",
    'Write it with its unit: "981 cm/s^2" is 9.81 m/s^2, that on Earth.',
)
LARGE_FRICTION = Message(
    "{name} = {value:g} is more than materials have.",
    "If it is an angle in degrees, the friction is its tangent, {tangent:.2g}.",
)
SMALL_ANGLE = Message(
    "Test {name} = {value:g} deg is flatter than any bed.",
    'If it was measured in radians, write "{value:g} rad".',
)
STEEP_ANGLE = Message(
    "Test {name} = {value:g} deg is steeper than beds that flow.",
    "If it was measured from the vertical, it is {rest:g} deg.",
)
FINER_THAN_INSTRUMENTS = Message(
    "{name}: its tolerance, {tolerance}, is finer than instruments reach, about {finest}.",
    "Give as tolerance what is good enough for you, and the error of the instrument as "
    "uncertainty, or as systematic beside measurements.",
)
ASSUMED_SIZE = Message(
    "Test {test}: {vessel} is assumed, {size}. In trials with soft spheres, an apparatus that "
    "holds {times} times the particles moved {moved}.",
    "Give {vessel} of the laboratory; 'grainfit size' simulates it in several sizes.",
)
FEW_PARTICLES = Message(
    "Test {test} has {particles} of {diameter}, for {share} of the mass.",
    "Use more particles, or leave out the ends of the distribution.",
)
FINE_TOLERANCE = Message(
    "{target}: {recorded} by about {scatter} %, and its tolerance, {tolerance}, is {share} % of "
    "the value: {runs} runs. About {undecided} of 10 such calibrations end undecided, with a "
    "budget of {budget} runs; a tolerance of {wide} % takes about {offered}."
)
MEANT_AS_PERCENTAGE = Message('If a percentage was meant, write it as one: "1 %".')
LARGE_TIME_STEP = Message(
    "Test {test}: a time step of {fraction:.3g} of the Rayleigh time step is more than the "
    "{safe:.2g} that is safe with this contact law, restitution and stiffness. Beds may never "
    "come to rest, or come to rest up to 16 % too dense without any error."
)
SHORT_TIMEOUT = Message(
    "Test {test}: timeout = {limit}, but a run takes about {seconds} and would be stopped before "
    "its end.",
    "Leave timeout out, or give several times as much.",
)
MORE_RANKS_THAN_CORES = Message(
    "{runs} at a time with {ranks} MPI ranks each take {needed} cores, and there are {cores}: "
    "ranks then wait for each other, and a run takes many times as long.",
    "Use fewer workers, or ranks = 1.",
)
RANKS_DO_NOT_PAY = Message(
    "With {ranks} MPI ranks a run and {runs} at a time, the calibration takes {time}; with "
    "ranks = 1 and {more} at a time, {alone}. Ranks pay where one run alone is waited for."
)
RANKS_PAY = Message(
    "With ranks = {ranks} in every test and {runs} at a time, the calibration takes {shared}; as "
    "it is, {time}, and cores are idle."
)
LONG = Message(
    "The calibration takes {time}.",
    "More workers shorten it: a computer with more cores, or a cluster (docs/clusters.md).",
)
LONG_BUT_SHORTER = Message("The calibration takes {time}.", "Shorter: {ways}.")
WOULD_TAKE = Message("with {change}, it would take {time}")
USUAL_DIMENSIONS = Message(
    "the usual dimensions of the {type} test ({count} particles), measured in an apparatus of "
    "that size"
)
SOFTER = Message("{key} = {modulus} MPa, whose overlaps add {percent:.0f} % to bulk densities")
COARSER = Message(
    "{factor}, fewer and larger particles in the same apparatus (docs/coarse_graining.md)"
)
WITH_TWINS = Message(
    "smaller apparatus that hold {count} particles (strategy.twins = {count} searches in them and "
    "predicts the real ones: one run of each, and a series of sizes, come on top)"
)
SHARED_SIMULATION = Message(
    "Tests {tests} differ in their evaluation only: each simulation serves all of them. They are "
    "called {name}."
)
REPEATED_SIMULATION = Message(
    "Tests {one} and {other} differ at most in their evaluation, but each simulation is made for "
    "one of them only.",
    "Make them one [[test]] with the targets of both{of_both}.",
)
ONE_FUNCTION = Message(": let the function in {key} return all their responses")
IMPOSSIBLE_BULK_DENSITY = Message(
    "{target} = {value:g} kg/m^3 is out of reach: with {within} particles, of {density:g} kg/m^3, "
    "the bed would have a solid fraction of {fraction}, {limit} packing of spheres.",
    "{remedy}",
)
DENSEST = Message("above {limit:.2f}, the densest")
LOOSEST = Message("below {limit:.2f}, looser than any")
USUAL_DENSITY = Message(
    "{key} is that of the solid, not of the bulk. Poured beds have {usual[0]:g} to {usual[1]:g}: "
    'density = {{ min = "{low:g} kg/m^3", max = "{high:g} kg/m^3" }}.'
)
ANOTHER_UNIT = Message(
    'One of them seems to be in another unit: write it with its unit, as "1.5 g/cm^3".'
)
FEW_TARGETS_WITH_CURVES = Message(
    "{free} free parameters and {targets}, curves included. A curve can determine several "
    "parameters if its shape depends on them: the intervals of the result will show how many."
)
FEW_TARGETS = Message(
    "{free} free parameters and {targets}: many parameter sets will fit equally well.",
    "Fix a parameter or measure another response.",
)
NEAR_SPHERES = Message(
    "{key} is {lowest}: there, spheres of the shape {family} nearly coincide and touch at once. "
    "{jump}Time steps are {share} of what their smallest sphere allows; larger aspect ratios are "
    "faster (docs/clumps.md)."
)
STIFFER_THAN_SPHERES = Message(
    "Clumps are stiffer than spheres, so soft particles respond otherwise than at 1."
)
