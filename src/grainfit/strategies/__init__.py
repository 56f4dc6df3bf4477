"""Strategies: how runs are chosen, and when the answer is known."""
