"""JKR: adhesion of soft elastic spheres, with the surface energy."""
