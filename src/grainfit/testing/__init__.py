"""Tests that others can run against what they write for grainfit."""
