"""Bulk tests: geometry and decks of a laboratory test, and the responses that it yields."""
