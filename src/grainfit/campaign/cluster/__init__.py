"""DEM runs in jobs of a cluster."""
