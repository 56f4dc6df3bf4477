"""A calibration file of beads without its tests, for tests that add one."""

BEADS = """
name = "beads"
[particle]
diameter = "10 mm"
density = "2500 kg/m^3"
youngs_modulus = "5 MPa"
poissons_ratio = 0.25
[particle_particle]
restitution = 0.5
sliding_friction = { min = 0.2, max = 0.8 }
rolling_friction = 0.1
rolling_damping = 0
[particle_wall]
restitution = 0.5
sliding_friction = 0.5
rolling_friction = 0.1
rolling_damping = 0
[wall]
youngs_modulus = "5 MPa"
poissons_ratio = 0.25
density = "2500 kg/m^3"
"""
