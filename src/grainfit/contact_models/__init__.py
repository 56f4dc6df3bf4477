"""Contact models: parameters, closed forms, and the syntax of each solver."""
