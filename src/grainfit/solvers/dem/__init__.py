"""DEM programs that simulate built-in bulk tests."""
