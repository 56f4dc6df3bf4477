"""Messages to users about the options of a shear test."""

from grainfit.messages import Message

TOO_MANY_PARTICLES = Message(
    "between plates of {length:g} m x {depth:g} m, {gap:g} m apart, are {count:.3g} "
    "particles; at most {most:g} are allowed.",
    "Use particles at least {factor:g} times as large (particle.coarse_graining), or smaller "
    "lengths.",
)
FAST_SHEAR = Message(
    "the inertial number is {number:g}; shear is quasi-static up to about {slowest:g}. The angle "
    "of rough spheres is 22.8 degrees at 0.005, 23.5 at 0.02 and 25.0 at 0.1.",
    "A smaller inertial_number is nearer to a shear tester, and takes longer.",
)
ENTER_SHEAR_STRESS = Message(
    "Enter the steady angle: internal_friction_angle = arc tangent of shear stress over "
    "normal stress in steady flow (phi_sf), with that normal_stress. Points of a yield locus below "
    'the preshear stress are targets of a test of type "shear_cell".'
)
ENTER_ANGLE = Message(
    "The test simulates steady flow: enter phi_sf as internal_friction_angle, with normal_stress "
    "that of the preshear. From phi_e it is about atan(sin phi_e), from a linearised yield locus "
    'about atan(c / normal_stress + tan phi_lin). A test of type "shear_cell" has all three as its '
    "responses."
)
STAGES_MISSING = Message("stages.csv: stages are missing")
NO_BED = Message("the snapshot {name} has no bed, or no plates")
PARTICLES_LOST = Message("particles were lost between the plates")
NOT_HELD = Message(
    "the normal stress was not held: {stress:.4g} Pa instead of {wanted:g} Pa on average, "
    "because the bed still dilates or settles; use a larger {longer}"
)
OTHER_INERTIAL_NUMBER = Message(
    "the inertial number is {found:.3g} instead of {wanted:g}: the plates are {gap:.3g} m "
    "apart, and their speed is that for {expected:.3g} m, because the bed is much {density} "
    "than a solid fraction of 0.58; use {use}, or other frictions"
)
HARDLY_SHEARED = Message(
    "the bed was hardly sheared: its middle half took up {share:.0%} of the plate's velocity "
    "(50 % if even), the rest slipped at the plates; use a larger gap, or a smaller "
    "inertial_number"
)
LOCALISED = Message(
    "the shear is localised: within two diameters the shear rate is {steepest:.2g} times the "
    "mean (at most {most:g}); use a smaller inertial_number, or a larger averaged_strain"
)
LEAKED = Message(
    "{count} particles leaked through a plate: Young's modulus is too small for this stress, "
    "or the smallest particles are much smaller than the others"
)
