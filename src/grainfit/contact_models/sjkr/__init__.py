"""SJKR: attraction in proportion to the area of contact, with a cohesion energy density."""
