"""Measurements on photographs, by the code that measures simulated heaps."""
