"""DMT: adhesion of hard elastic spheres, with the surface energy."""
