"""Strategies decide which DEM run to make next, and when the answer is known."""
