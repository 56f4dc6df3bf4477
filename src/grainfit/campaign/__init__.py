"""A campaign makes DEM runs and never loses one: identity, store, runner."""
