"""EPSD in the syntax of LIGGGHTS: ``rolling_friction epsd``."""

from grainfit.contact_models.liggghts import LiggghtsKeywords

EPSD_LIGGGHTS = LiggghtsKeywords(
    model="rolling_friction epsd",
    pair_properties={
        "coefficientRollingFriction": "rolling_friction",
        "coefficientRollingViscousDamping": "rolling_damping",
    },
    dashpot_difference=(
        "LAMMPS limits the rolling dashpot, and LIGGGHTS does not. At a rolling damping of 0.25, "
        "angles of repose of LIGGGHTS are 0.5° (glass beads) to 2° (sliding friction 0.5, rolling "
        "friction 0.2) larger, bulk densities up to 1.1 % and mass flows 6 % smaller; "
        "with the rolling model epsd2, they agree."
    ),
)
