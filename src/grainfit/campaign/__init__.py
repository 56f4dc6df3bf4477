"""Execute DEM runs, store them, and reuse them by identity."""
