"""Hertz-Mindlin: normal force and friction of elastic spheres, with a restitution."""
