"""Messages to users about the options and the runs of a triaxial test."""

from grainfit.messages import Message

TOO_MANY_PARTICLES = Message(
    "in a box of {width:g} m x {width:g} m x {height:g} m are {count:.3g} particles; at most "
    "{most:g} are allowed.",
    "Use particles at least {factor:g} times as large (particle.coarse_graining), or smaller "
    "lengths.",
)
NO_ROOM = Message(
    "{count} particles find no place in the box.", "Use a larger box, or less elongated particles."
)
NO_CURVE = Message(
    "the critical state is averaged over {averaged:g} of an axial strain of {strain:g}.",
    "Use at most half of it.",
)
SHORT_STRAIN = Message(
    "the bed was compressed by {found:.3g} instead of {wanted:g}: under the confining stress it is "
    "{height:.3g} m high, much looser than a solid fraction of 0.6; use a larger confining_stress "
    "or a smaller initial_friction"
)
NOT_BALANCED = Message(
    "the compression is not quasi-static: the forces on {low} and {high} differ by {share:.0%}; "
    "use a smaller inertial_number"
)
NOT_CONFINED = Message(
    "the confining stress was not held: {stress:.4g} Pa instead of {wanted:g} Pa at an axial "
    "strain of {strain:.3g}; use a smaller inertial_number, or a larger box"
)
FAST_COMPRESSION = Message(
    "the inertial number is {number:g}; compression is quasi-static up to about {slowest:g}.",
    "Use a smaller inertial_number.",
)
SHORT_COMPRESSION = Message(
    "the bed is compressed by {strain:g}; dense and loose beds come to one critical state at about "
    "{least:g}.",
    "Use a larger axial_strain, or take the angle for that of this strain.",
)
FEW_RECORDS = Message("the compression was recorded a few times only")
