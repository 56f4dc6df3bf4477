"""Calibrates the material parameters of discrete element (DEM) models of bulk solids."""
