"""The commented calibration file that a new user starts from."""

from __future__ import annotations

#: The file that `grainfit new` writes: it teaches, and loads as it is.
STARTER_FILE = """\
# Calibration file of grainfit. It is valid as it is: change it, then
#
#     grainfit check FILE     says what is wrong with it, and shows the plan
#     grainfit run FILE       calibrates
#
# A quantity is a number with its unit, in quotes: "10 mm". A plain number is in SI units, an
# angle in degrees. A parameter that you know has a value:
#     restitution = 0.79
# One that is to be found, a free parameter, has an interval:
#     restitution = { min = 0.5, max = 0.9 }
# Lines that start with # are comments; most of those below are options with their defaults.

name = "glass beads"                    # for you; choose freely

[particle]
diameter = "10 mm"
# Instead, a particle size distribution, by mass as from a sieve analysis:
# diameter = [{ value = "8 mm", mass_fraction = 0.3 }, { value = "10 mm", mass_fraction = 0.7 }]
# Far softer than glass, because the number of time steps is proportional to its square root; stiff
# enough that overlaps of the particles add no more than 2 % to the bulk density. With "0.4 MPa" a
# run has a quarter of the time steps, but 13 % too much bulk density, which the fitted particle
# density then makes up for. Measure it: grainfit stiffness FILE
youngs_modulus = "7 MPa"
# Were it free, it would span orders of magnitude, and be searched by them:
# youngs_modulus = { min = "0.1 MPa", max = "100 MPa", scale = "log" }
poissons_ratio = 0.22
density = { min = "1400 kg/m^3", max = "2800 kg/m^3" }  # free; of the solid, not of the bulk

[wall]
youngs_modulus = "211 GPa"
poissons_ratio = 0.30
density = "7700 kg/m^3"

[particle_particle]                     # contacts between particles
sliding_friction = 0.18
rolling_friction = { min = 0.22, max = 1.11 }           # free
restitution = 0.79
rolling_damping = 0.25                  # viscous rolling damping ratio

[particle_wall]                         # contacts between particles and walls
sliding_friction = 0.27
rolling_friction = 0.005
restitution = 0.82
rolling_damping = 0.25

# What was measured. Two responses can determine two free parameters, hardly more.
[[test]]
type = "heap"                           # lifted cylinder: fill, strike off, lift, heap at rest
solver = "lammps"                         # or "liggghts"
# Geometry and procedure, as in your laboratory. These defaults follow the particle diameter d.
# cylinder_radius = "60 mm"             # 6 d
# strike_off_height = "105 mm"          # 10.5 d
# plate_radius = "160 mm"               # 16 d
# rim_height = "0 mm"                   # a free edge: particles may fall off
# lift_speed = "0.05 m/s"               # decides the angle of repose: use your laboratory's
# plate_sliding_friction = 0.5
# timeout = "30 min"                    # of one run; by default far above its estimated time

# Mean and standard uncertainty of your measurements ...
targets.bulk_density = { value = "1500 kg/m^3", uncertainty = "1 %" }
# ... or the measurements themselves.
targets.angle_of_repose = { measurements = ["21.4 deg", "22.9 deg", "21.8 deg", "21.9 deg"] }

[strategy]
name = "sequential"                     # every run where it helps most; or "staged" (the paper's)
# seed = 1                              # same seed, same calibration
# max_runs = 60                         # budget of DEM runs; none by default
# workers = 2                           # runs at a time; as many as the machine has cores for
# design_runs = 5                       # 1.5 (d + 1) for d free parameters
# verification_runs = 5                 # with fresh seeds, at the answer
# prefer = "accuracy"                   # closest parameter set, not the fastest that agrees
# extend_intervals = true               # move a bound that keeps a target out of reach

# A DEM model of your own, instead of the heap test or beside it, and all other keys:
# docs/calibration_file.md; runs in jobs of a cluster: docs/clusters.md
"""
