"""Kriging metamodels of responses, designs, and searches of the unit cube."""
