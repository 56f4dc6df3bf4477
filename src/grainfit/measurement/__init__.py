"""Measurements on particles and images, the same for simulations and photographs."""
