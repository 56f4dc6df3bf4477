"""Hertz-Mindlin contacts."""
