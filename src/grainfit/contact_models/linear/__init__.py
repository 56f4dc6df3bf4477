"""Linear springs and dashpots: normal force and friction with a stiffness that no load changes."""
