"""Start and end processes of solvers, and find the causes of their failures."""
