"""Materials: parameters, particle sizes, Rayleigh time step, material card."""
