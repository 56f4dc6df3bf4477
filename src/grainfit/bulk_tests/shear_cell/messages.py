"""Messages to users about the options of a shear cell."""

from grainfit.messages import Message

NOT_ASCENDING = Message(
    "{lowest:g} Pa is not below the highest_stress of {highest:g} Pa.",
    "Use about {usual:g} Pa (the default).",
)
ABOVE_PRESHEAR = Message(
    "{highest:g} Pa is more than {share:.0%} of the normal_stress of the preshear ({stress:g} Pa).",
    "Use at most {most:g} Pa: at failure, the bed carries less than at the preshear.",
)
LONG_PRESHEAR = Message(
    "the plate moves by {way:g} m in it, more than {share:g} times the length of {length:g} m.",
    "Use at most {most:.2g}, or a larger length: particles could not be told from their copies.",
)
ENTER_STEADY_ANGLE = Message("Enter it as phi_sf, the angle of steady flow at the preshear.")
ENTER_DENSITY = Message("Enter it as bulk_density, which is that of the preshear.")
ENTER_CURVE = Message(
    "Enter the points of normal and shear stress at failure as the curve shear_stress, without "
    "the preshear point: that one is phi_sf."
)
ENTER_STRENGTH = Message("Enter it as unconfined_strength.")
ENTER_CONSOLIDATION = Message("Enter it as major_consolidation_stress.")
ENTER_LINEAR_ANGLE = Message("Enter it as phi_lin, the angle of the linearised yield locus.")
NO_COHESION = Message(
    "nothing is cohesive, so the bed is free flowing: cohesion and unconfined_strength are zero "
    "within their standard errors, and runs have no ffc.",
    "Give the particles cohesion, such as particle_particle.surface_energy (docs/cohesion.md).",
)
OTHER_PRESHEAR = Message(
    "a major consolidation stress of {target:g} Pa is {times:.2g} times the normal stress of the "
    "preshear ({stress:g} Pa); in steady flow it is {low:g} to {high:g} times as large.",
    "Set normal_stress to that of your preshear, or correct the target.",
)
NOT_HELD_AT_FAILURE = Message(
    "the normal stress was not held at failure: {stress:.4g} Pa instead of {wanted:g} Pa, "
    "because the bed dilates; use a smaller inertial_number"
)
NO_YIELD_LOCUS = Message("no yield locus: {reason}")
FEW_RECORDS = Message("shear to failure: there are too few records")
