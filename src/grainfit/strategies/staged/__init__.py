"""Staged strategy: design, fit on metamodels, fit on the DEM."""
