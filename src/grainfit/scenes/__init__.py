"""Scenes: simulated experiments as plain data, which every solver translates."""
