"""Contact models: parameters, closed forms, and coefficients for each solver."""
