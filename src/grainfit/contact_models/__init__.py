"""Contact models: parameters, closed forms, and words for each solver."""
